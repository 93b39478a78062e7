//! A scene with what sampling needs beside it: lights as a discrete distribution, materials, frames.

use aether_core::prelude::{Direction, Frame, Vec2};
use glam::Vec3;

use crate::kind::{Everything, NotCovered, Presence, SceneKind, covers};
use crate::lights::{AreaLight, Lights};
use crate::scattering::{Material, Scattering};
use crate::scene::{Camera, Filter, Primitive, PrimitiveId, Scene, Sky, hit};
use crate::vertex::{Pinhole, Place, SceneVertex, Seen, Surface};

/// A scene ready for the strategies.
pub struct World<'s, K: SceneKind = Everything> {
    /// The scene.
    pub scene: &'s Scene,
    /// The lights.
    pub lights: Lights<K>,
    /// The materials, in the order of the scene's.
    materials: Vec<Material<K>>,
    /// Which light each primitive is.
    light_of: Vec<Option<u32>>,
    /// The camera's axes: right, down, forward.
    pub camera_frame: Frame<f32>,
    /// One over the integral of the reconstruction filter.
    pub filter_scale: f32,
}

impl<'s, K: SceneKind> World<'s, K> {
    /// Prepares a scene.
    ///
    /// # Errors
    /// If the scene needs what the kind leaves out.
    pub fn new(scene: &'s Scene) -> Result<Self, NotCovered> {
        // Some features leave no trace below: without textures a colour would be their mean.
        covers::<K>(scene)?;
        let mut light_of = vec![None; scene.primitives.len()];
        for (index, emitter) in (0..).zip(&scene.emitters) {
            light_of[emitter.primitive as usize] = Some(index);
        }
        let materials = scene.bsdfs.iter().map(Material::new).collect::<Result<_, _>>()?;
        let camera_frame = camera_frame(&scene.camera);
        let filter_scale = 1.0 / profile_integral(scene.film.filter).powi(2);
        let lights = Lights::new(scene)?;
        Ok(World { scene, lights, materials, light_of, camera_frame, filter_scale })
    }

    /// The pinhole of the camera.
    pub fn pinhole(&self) -> Pinhole {
        Pinhole { position: self.scene.camera.origin }
    }

    /// What a ray from a vertex in direction `w` meets first.
    pub fn cast(&self, from: &SceneVertex<K>, w: &Direction<f32>) -> Option<Seen<K>> {
        self.cast_along(from, w.vec().into())
    }

    /// The same for a vector.
    pub fn cast_along(&self, from: &SceneVertex<K>, w: Vec3) -> Option<Seen<K>> {
        match self.scene.intersect(from.position, w, from.primitive()) {
            Some(hit) => Some(Seen::Surface(Surface {
                position: hit.position,
                normal: hit.geometric_normal,
                shading: hit.shading_normal,
                primitive: hit.primitive,
                emitter: self.light_of[hit.primitive.0 as usize],
                uv: K::Textures::uv(|| self.scene.texture_coordinates(&hit)),
            })),
            // Without a sky that shines there is nothing to see.
            None => self.scene.sky.as_ref().and(Presence::VALUE).map(Seen::Sky),
        }
    }

    /// The surface that a ray from a vertex in direction `w` meets first.
    pub fn hit(&self, from: &SceneVertex<K>, w: &Direction<f32>) -> Option<Surface<K>> {
        match self.cast(from, w)? {
            Seen::Surface(surface) => Some(surface),
            Seen::Sky(_) => None,
        }
    }

    /// Whether nothing lies between two vertices.
    pub fn visible(&self, from: &SceneVertex<K>, to: &SceneVertex<K>) -> bool {
        if to.is_infinite() {
            return self.scene.is_open(from.position, from.primitive(), to.position);
        }
        self.scene.visible(from.position, from.primitive(), to.position, to.primitive())
    }

    /// Whether a flat light shines to the side on which a point lies.
    pub fn faces(&self, light: &AreaLight, point: Vec3) -> bool {
        let (on, normal) = match light.shape {
            Primitive::Triangle { v0, .. } => {
                (v0, self.scene.normal(PrimitiveId(light.emitter.primitive), v0))
            }
            Primitive::Disk { center, normal, .. } => (center, normal),
            Primitive::Sphere { .. } => return true,
        };
        normal.dot(point - on) > 0.0
    }

    /// The piece of a light that a ray in one of the directions in which it is seen meets first.
    pub fn lit(
        &self,
        light: &AreaLight,
        from: &SceneVertex<K>,
        w: &Direction<f32>,
    ) -> Option<Surface<K>> {
        let (origin, w) = (from.position, w.vec().into());
        let point = match light.shape {
            Primitive::Sphere { center, radius, .. } => {
                hit::nearest_on_sphere(origin, w, center, radius)
            }
            Primitive::Triangle { v0, v1, v2 } => hit::on_plane([v0, v1, v2], origin, w)?,
            Primitive::Disk { .. } => return None,
        };
        Some(self.light_surface(light, point))
    }

    /// The piece of surface of a light at a point of it.
    pub fn light_surface(&self, light: &AreaLight, position: Vec3) -> Surface<K> {
        let primitive = PrimitiveId(light.emitter.primitive);
        let normal = self.scene.normal(primitive, position);
        // The path ends here: only a texture of the emission matters.
        let uv = K::Textures::uv(|| match light.emitter.texture {
            Some(_) => self.scene.texture_coordinates_at(primitive, position),
            None => glam::Vec2::ZERO,
        });
        Surface { position, normal, shading: normal, primitive, emitter: Some(light.index), uv }
    }

    /// What a vertex emits towards another, in linear Rec. 709: radiance, of a point light intensity, of
    /// parallel light irradiance.
    pub fn emitted(&self, vertex: &SceneVertex<K>, towards: &SceneVertex<K>) -> Vec3 {
        let w = || (towards.position - vertex.position).normalize_or_zero();
        match vertex.place {
            Place::Camera => Vec3::ZERO,
            Place::Surface(surface) => match surface.emitter {
                Some(e) if surface.normal.dot(towards.position - vertex.position) > 0.0 => {
                    let emitter = &self.scene.emitters[e as usize];
                    match emitter.texture {
                        Some(texture) if K::Textures::VALUE.is_some() => {
                            let uv = K::Textures::coordinates(surface.uv);
                            self.scene.textures[texture as usize].at(uv)
                        }
                        _ => emitter.radiance,
                    }
                }
                _ => Vec3::ZERO,
            },
            Place::Sky(_) => match &self.scene.sky {
                Some(Sky::Constant(radiance)) => *radiance,
                Some(Sky::Picture(map)) if K::Envmap::VALUE.is_some() => {
                    map.radiance(vertex.position)
                }
                _ => Vec3::ZERO,
            },
            Place::Bulb(index) => {
                self.scene.bulbs[K::Point::get(index) as usize].intensity_towards(w())
            }
            Place::Distant(index) => {
                self.scene.distant[K::Directional::get(index) as usize].irradiance
            }
        }
    }

    /// How the surface at a vertex scatters light to or from another vertex: `None` if there is no
    /// surface or if that side is black.
    pub fn scattering(
        &self,
        here: &SceneVertex<K>,
        other: &SceneVertex<K>,
    ) -> Option<Scattering<'_, K>> {
        let surface = here.surface()?;
        let material = &self.materials[self.scene.shape(surface.primitive).bsdf as usize];
        let uv = K::Textures::coordinates(surface.uv);
        let towards = other.direction_from(here.position);
        Scattering::new(material, &self.scene.textures, uv, surface.shading, towards)
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
