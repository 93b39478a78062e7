//! A scene with what sampling needs beside it: the lights as a discrete distribution, frames.

use aether_core::discrete::{Choices, discrete_weighted};
use aether_core::prelude::{Direction, Frame, Vec2};
use glam::Vec3;

use crate::scene::{Camera, Emitter, Filter, Primitive, PrimitiveId, Scene};
use crate::vertex::{Pinhole, SceneVertex, Surface};

/// An emissive primitive as light sampling sees it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Light {
    /// Its place in the list of emitters.
    pub index: u32,
    /// The emitter.
    pub emitter: Emitter,
    /// Its geometry.
    pub shape: Primitive,
}

/// A scene ready for the strategies.
pub struct World<'s> {
    /// The scene.
    pub scene: &'s Scene,
    /// The lights, chosen in proportion to their power; none if nothing emits.
    pub lights: Option<Choices<Vec<Light>, Light, f32>>,
    /// Which light each primitive is.
    light_of: Vec<Option<u32>>,
    /// The camera's axes: right, down, forward.
    pub camera_frame: Frame<f32>,
    /// One over the integral of the reconstruction filter.
    pub filter_scale: f32,
}

impl<'s> World<'s> {
    /// Prepares a scene.
    pub fn new(scene: &'s Scene) -> Self {
        let mut light_of = vec![None; scene.primitives.len()];
        let mut lights = Vec::new();
        for (index, emitter) in (0..).zip(&scene.emitters) {
            light_of[emitter.primitive as usize] = Some(index);
            let shape = scene.primitives[emitter.primitive as usize];
            lights.push(Light { index, emitter: *emitter, shape });
        }
        let powers: Vec<f32> = lights.iter().map(|l| l.emitter.power().element_sum()).collect();
        // No emitter, or only black ones: there is nothing to choose from.
        let lights = discrete_weighted(lights, powers).ok();
        let camera_frame = camera_frame(&scene.camera);
        let filter_scale = 1.0 / profile_integral(scene.film.filter).powi(2);
        World { scene, lights, light_of, camera_frame, filter_scale }
    }

    /// The pinhole of the camera.
    pub fn pinhole(&self) -> Pinhole {
        Pinhole { position: self.scene.camera.origin }
    }

    /// What a ray from a vertex in direction `w` meets first.
    pub fn cast(&self, from: &SceneVertex, w: &Direction<f32>) -> Option<Surface> {
        let hit = self.scene.intersect(from.position, w.vec().into(), from.primitive())?;
        Some(Surface {
            position: hit.position,
            normal: hit.geometric_normal,
            shading: hit.shading_normal,
            primitive: hit.primitive,
            emitter: self.light_of[hit.primitive.0 as usize],
        })
    }

    /// The piece of surface of a light at a point of it.
    pub fn light_surface(&self, light: &Light, position: Vec3) -> Surface {
        let primitive = PrimitiveId(light.emitter.primitive);
        let normal = self.scene.normal(primitive, position);
        Surface { position, normal, shading: normal, primitive, emitter: Some(light.index) }
    }

    /// Radiance that a vertex emits towards a point, in linear Rec. 709.
    pub fn emitted(&self, vertex: &SceneVertex, towards: Vec3) -> Vec3 {
        let Some(surface) = vertex.surface else { return Vec3::ZERO };
        match surface.emitter {
            Some(e) if surface.normal.dot(towards - vertex.position) > 0.0 => {
                self.scene.emitters[e as usize].radiance
            }
            _ => Vec3::ZERO,
        }
    }

    /// How a surface scatters light that arrives from or leaves towards `other`: `None` if that side
    /// is black.
    pub fn scattering(&self, surface: &Surface, other: Vec3) -> Option<Lambert> {
        let bsdf = self.scene.bsdf(surface.primitive);
        let front = surface.shading.dot(other - surface.position) > 0.0;
        let normal = if front { surface.shading } else { -surface.shading };
        (front || bsdf.two_sided).then_some(Lambert { albedo: bsdf.reflectance, normal })
    }

    /// The point of the film that the camera's axis goes through, in pixels.
    pub fn film_centre(&self) -> Vec2<f32> {
        let Camera { width, height, principal, .. } = self.scene.camera;
        Vec2::new((0.5 - principal.x) * width as f32, (0.5 - principal.y) * height as f32)
    }

    /// Width and height of a pixel at distance one.
    pub fn film_scale(&self) -> Vec2<f32> {
        let Camera { width, height, tan_x, tan_y, .. } = self.scene.camera;
        Vec2::new(2.0 * tan_x / width as f32, 2.0 * tan_y / height as f32)
    }
}

/// A Lambertian surface as seen from one side.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Lambert {
    /// The fraction of light that it reflects.
    pub albedo: Vec3,
    /// The shading normal on the side of the viewer.
    pub normal: Vec3,
}

impl Lambert {
    /// The frame about the normal.
    pub fn frame(&self) -> Frame<f32> {
        let n = self.normal;
        Frame::around(Direction::new(n.x, n.y, n.z))
    }

    /// The probability to survive Russian roulette here.
    pub fn survival(&self) -> f32 {
        self.albedo.max_element().min(0.95)
    }
}

fn camera_frame(camera: &Camera) -> Frame<f32> {
    let [x, y, z] = [camera.right, -camera.up, camera.forward].map(|v| v.as_dvec3());
    let axes = Frame::try_from_axes(x.as_vec3().into(), y.as_vec3().into(), z.as_vec3().into());
    // The loader has made the axes orthonormal.
    axes.unwrap_or_else(|| Frame::around(Direction::new(0.0, 0.0, 1.0)))
}

/// The integral of the filter's profile along one axis, by Simpson's rule on each half.
fn profile_integral(filter: Filter) -> f32 {
    const PANELS: usize = 64;
    let h = f64::from(filter.radius()) / PANELS as f64;
    let sum: f64 = (0..=PANELS)
        .map(|i| {
            let weight = if i == 0 || i == PANELS { 1.0 } else { 2.0 + 2.0 * (i % 2) as f64 };
            weight * f64::from(filter.profile((h * i as f64) as f32))
        })
        .sum();
    (2.0 * sum * h / 3.0) as f32
}
