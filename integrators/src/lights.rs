//! The lights of a scene as light sampling sees them.

use std::f32::consts::PI;

use aether_core::discrete::{Choices, discrete_weighted};
use glam::Vec3;

use crate::envmap::EnvironmentTable;
use crate::kind::{NotCovered, Presence, SceneKind, With};
use crate::scene::{Emitter, Primitive, Scene, Sky};
use crate::vertex::{Place, SceneVertex, SkyOf};

/// An emissive primitive.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AreaLight {
    /// Its place in the list of emitters.
    pub index: u32,
    /// The emitter.
    pub emitter: Emitter,
    /// Its geometry.
    pub shape: Primitive,
}

/// A light.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Light<K: SceneKind> {
    /// A surface.
    Area(With<K::Area, AreaLight>),
    /// A sky that is the same in all directions.
    Sky(With<K::Constant, SkyOf<K>>),
    /// A sky as a picture shows it.
    Picture(With<K::Envmap, SkyOf<K>>),
    /// A point.
    Bulb(With<K::Point, (u32, Vec3)>),
    /// Parallel light, by the direction towards it.
    Distant(With<K::Directional, (u32, Vec3)>),
}

/// All lights of a scene, chosen in proportion to their power.
#[derive(Clone, Debug)]
pub struct Lights<K: SceneKind> {
    /// The choice; none if nothing emits.
    pub choice: Option<Choices<Vec<Light<K>>, Light<K>, f32>>,
    /// Centre and radius of a sphere around the scene.
    pub bounds: (Vec3, f32),
    /// How to choose directions of a sky that a picture shows; none without such a picture, or if it is black.
    pub picture: Option<EnvironmentTable>,
    /// Where the sky is among them.
    sky: usize,
    /// Where the points begin.
    bulbs: usize,
    /// Where parallel lights begin.
    distant: usize,
}

impl<K: SceneKind> Lights<K> {
    /// The lights of a scene.
    ///
    /// # Errors
    /// If there is one of a sort that the kind leaves out.
    pub fn new(scene: &Scene) -> Result<Self, NotCovered> {
        let missing = |feature| NotCovered { kind: K::NAME, feature };
        let (mut lights, mut powers) = (Vec::new(), Vec::new());
        for (index, emitter) in (0..).zip(&scene.emitters) {
            let shape = scene.primitives[emitter.primitive as usize];
            let light = K::Area::with(|| AreaLight { index, emitter: *emitter, shape });
            lights.push(Light::Area(light.ok_or_else(|| missing("Area"))?));
            powers.push(emitter.power().element_sum());
        }
        // Light from afar falls on the disk that the scene shows to it.
        let bounds @ (_, radius) = scene.bounding_sphere();
        let cross_section = PI * radius * radius;
        let sky = lights.len();
        let mut picture = None;
        if let Some(from) = &scene.sky {
            let any = SkyOf::<K>::VALUE.ok_or_else(|| missing(from.feature()))?;
            let light = match from {
                Sky::Constant(_) => K::Constant::with(|| any).map(Light::Sky),
                Sky::Picture(map) => {
                    picture = K::Envmap::VALUE.and_then(|_| EnvironmentTable::new(map));
                    K::Envmap::with(|| any).map(Light::Picture)
                }
            };
            lights.push(light.ok_or_else(|| missing(from.feature()))?);
            powers.push(4.0 * PI * cross_section * from.mean().element_sum());
        }
        let bulbs = lights.len();
        for (index, bulb) in (0..).zip(&scene.bulbs) {
            let light = K::Point::with(|| (index, bulb.position));
            lights.push(Light::Bulb(light.ok_or_else(|| missing("Point"))?));
            powers.push(bulb.power().element_sum());
        }
        let distant = lights.len();
        for (index, light) in (0..).zip(&scene.distant) {
            powers.push(cross_section * light.irradiance.element_sum());
            let light = K::Directional::with(|| (index, light.towards));
            lights.push(Light::Distant(light.ok_or_else(|| missing("Directional"))?));
        }
        // No light, or only black ones: there is nothing to choose from.
        let choice = discrete_weighted(lights, powers).ok();
        Ok(Lights { choice, bounds, picture, sky, bulbs, distant })
    }

    /// Which light a vertex lies on.
    #[inline]
    pub fn index_of(&self, vertex: &SceneVertex<K>) -> Option<usize> {
        match vertex.place {
            Place::Camera | Place::Parallel(_) | Place::Backdrop(_) => None,
            Place::Surface(surface) => surface.emitter.map(|index| index as usize),
            Place::Sky(_) => Some(self.sky),
            Place::Bulb(index) => Some(self.bulbs + K::Point::get(index) as usize),
            Place::Distant(index) => Some(self.distant + K::Directional::get(index) as usize),
        }
    }
}
