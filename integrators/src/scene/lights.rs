//! Lights without a surface, as a scene file gives them.

use std::f32::consts::PI;

use aether_core::prelude::Direction;
use glam::Vec3;

use super::envmap::EnvironmentMap;
use super::texture::Texture;

/// Light from all around, infinitely far away.
#[derive(Clone, Debug, PartialEq)]
pub enum Sky {
    /// The same from all directions: radiance in linear Rec. 709.
    Constant(Vec3),
    /// As a picture shows it.
    Picture(EnvironmentMap),
}

impl Sky {
    /// The mean radiance over all directions.
    pub fn mean(&self) -> Vec3 {
        match self {
            Sky::Constant(radiance) => *radiance,
            Sky::Picture(map) => map.mean(),
        }
    }

    /// The feature of a kind of scene that it needs.
    pub fn feature(&self) -> &'static str {
        match self {
            Sky::Constant(_) => "Constant",
            Sky::Picture(_) => "Envmap",
        }
    }
}

/// Light from a point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bulb {
    /// Where.
    pub position: Vec3,
    /// Power per solid angle in linear Rec. 709, along the axis if there is one.
    pub intensity: Vec3,
    /// The cone that it is confined to; none for all directions.
    pub cone: Option<Cone>,
}

/// A cone of light that fades towards its rim.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Cone {
    /// The axis, of unit length.
    pub axis: Vec3,
    /// The angle, in radians, within which it does not fade.
    pub beam_width: f32,
    /// The angle, in radians, beyond which there is no light.
    pub cutoff: f32,
    /// What is projected, if it is a picture.
    pub slide: Option<Slide>,
}

/// A texture in front of a spot light, which the cone just fits into.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Slide {
    /// Index in [`super::Scene::textures`].
    pub texture: u32,
    /// The mean over the texture.
    pub mean: Vec3,
    /// Unit vectors in which its first and its second coordinate increase.
    pub axes: [Vec3; 2],
}

impl Slide {
    /// The colour in a direction of unit length.
    fn at(&self, w: Vec3, cone: &Cone, textures: &[Texture]) -> Vec3 {
        let Some(texture) = textures.get(self.texture as usize) else { return self.mean };
        let along = w.dot(cone.axis) * cone.cutoff.tan();
        texture.at(self.axes.map(|axis| 0.5 + 0.5 * w.dot(axis) / along).into())
    }
}

impl Bulb {
    /// What it sends in a direction of unit length, in a scene with these textures.
    pub fn intensity_towards(&self, w: Vec3, textures: &[Texture]) -> Vec3 {
        let Some(cone) = self.cone else { return self.intensity };
        let colour = cone.slide.map_or(Vec3::ONE, |slide| slide.at(w, &cone, textures));
        let intensity = self.intensity * colour;
        // By the half chord, which keeps its digits for narrow cones.
        let angle = 2.0 * (0.5 * (w - cone.axis).length()).min(1.0).asin();
        let fade = (cone.cutoff - angle) / (cone.cutoff - cone.beam_width);
        if angle <= cone.beam_width { intensity } else { intensity * fade.clamp(0.0, 1.0) }
    }

    /// The cone that it shines into, if it is no wider than a hemisphere: the axis, and by how much the
    /// cosine at the rim is below one.
    pub fn narrow_cone(&self) -> Option<(Direction<f32>, f32)> {
        let cone = self.cone?;
        let depth = 2.0 * (0.5 * cone.cutoff).sin().powi(2);
        (depth > 0.0 && depth <= 1.0).then(|| (Direction::from_unit(cone.axis.into()), depth))
    }

    /// Its power, roughly for a cone.
    pub fn power(&self) -> Vec3 {
        let solid_angle = match self.cone {
            None => 4.0 * PI,
            Some(cone) => {
                let half = 0.25 * (cone.cutoff + cone.beam_width);
                4.0 * PI * half.sin().powi(2)
            }
        };
        let slide = self.cone.and_then(|cone| cone.slide);
        self.intensity * slide.map_or(Vec3::ONE, |slide| slide.mean) * solid_angle
    }
}

/// Parallel light.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Distant {
    /// Where it comes from: a unit vector towards the light.
    pub towards: Vec3,
    /// What a surface across it receives, in linear Rec. 709.
    pub irradiance: Vec3,
}
