//! A scene with what sampling needs beside it: lights as a discrete distribution, materials, frames.

use aether_core::RandomSequence;
use aether_core::prelude::{Direction, Frame, Map, Vec2};
use aether_core::strategy::Strategy;
use glam::Vec3;
use std::ops::Range;

use crate::kind::{Everything, NotCovered, Presence, SceneKind, covers};
use crate::lights::{AreaLight, Lights};
use crate::samplers::{pinhole, rotate};
use crate::scattering::{Material, Scattering};
use crate::scene::{Camera, Filter, Primitive, PrimitiveId, Scene, hit};
use crate::strategies::Pixel;
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
        match self.trace(from.position, w.vec().into(), from.primitive()) {
            Some(surface) => Some(Seen::Surface(surface)),
            // Without a sky that shines there is nothing to see.
            None => self.scene.sky.and(Presence::VALUE).map(Seen::Sky),
        }
    }

    /// The first surface on a ray that leaves a primitive, or none.
    pub fn trace(&self, origin: Vec3, w: Vec3, from: Option<PrimitiveId>) -> Option<Surface<K>> {
        let hit = self.scene.intersect(origin, w, from)?;
        Some(Surface {
            position: hit.position,
            normal: hit.geometric_normal,
            shading: hit.shading_normal,
            primitive: hit.primitive,
            emitter: self.light_of[hit.primitive.0 as usize],
            uv: K::Textures::uv(|| self.scene.texture_coordinates(&hit)),
        })
    }

    /// The first surface that light from infinitely far away meets, where it comes through the point `p`
    /// of a [`Window`].
    pub fn shone_on(&self, window: &Window, p: &Vec2<f32>) -> Option<Surface<K>> {
        let start = window.centre + p.x * window.u + p.y * window.v;
        self.trace(start, -window.towards, None)
    }

    /// The disk that light from a direction, of unit length, comes through to the scene.
    pub fn window(&self, towards: Vec3) -> Window {
        let frame = Frame::around(Direction::from_unit(towards.into()));
        let axis = |x, y| frame.to_world(aether_core::Vec3::new(x, y, 0.0)).into();
        let (centre, radius) = self.lights.bounds;
        Window {
            centre: centre + radius * towards,
            u: axis(1.0, 0.0),
            v: axis(0.0, 1.0),
            towards,
            radius,
        }
    }

    /// The surface that a ray from a vertex in direction `w` meets first.
    pub fn hit(&self, from: &SceneVertex<K>, w: &Direction<f32>) -> Option<Surface<K>> {
        self.trace(from.position, w.vec().into(), from.primitive())
    }

    /// Whether nothing lies between two vertices.
    pub fn visible(&self, from: &SceneVertex<K>, to: &SceneVertex<K>) -> bool {
        if to.is_infinite() {
            return self.scene.intersect(from.position, to.position, from.primitive()).is_none();
        }
        self.scene.visible(from.position, from.primitive(), to.position, to.primitive())
    }

    /// The piece of a spherical light that a ray in a direction of its cone meets first.
    pub fn lit(
        &self,
        light: &AreaLight,
        from: &SceneVertex<K>,
        w: &Direction<f32>,
    ) -> Option<Surface<K>> {
        let Primitive::Sphere { center, radius, .. } = light.shape else { return None };
        let point = hit::nearest_on_sphere(from.position, w.vec().into(), center, radius);
        Some(self.light_surface(light, point))
    }

    /// The piece of surface of a light at a point of it.
    pub fn light_surface(&self, light: &AreaLight, position: Vec3) -> Surface<K> {
        let primitive = PrimitiveId(light.emitter.primitive);
        let normal = self.scene.normal(primitive, position);
        // The path ends here: textures do not matter.
        let uv = Default::default();
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
                    self.scene.emitters[e as usize].radiance
                }
                _ => Vec3::ZERO,
            },
            Place::Sky(_) => self.scene.sky.map_or(Vec3::ZERO, |sky| sky.radiance),
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

    /// The map from points of the film, in pixels, to the directions that they look in.
    pub fn film_to_direction(&self) -> impl Map<f32, Source = Vec2<f32>, Target = Direction<f32>> {
        pinhole(self.film_centre(), self.film_scale()).then(rotate(self.camera_frame))
    }

    /// The point of the film, in pixels, where a camera at the vertex `eye` sees another vertex; `None`
    /// if that lies behind it. It may lie beside the image.
    pub fn film_point(&self, eye: &SceneVertex<K>, seen: &SceneVertex<K>) -> Option<Vec2<f32>> {
        let direction = Direction::from_unit(seen.direction_from(eye.position).into());
        let mut point = None;
        self.film_to_direction().preimages(&direction, |film, exists| {
            if exists {
                point = Some(film);
            }
        });
        point
    }

    /// How many pixels the image has.
    pub fn pixels(&self) -> usize {
        self.scene.film.width as usize * self.scene.film.height as usize
    }

    /// The pixels to which paths contribute whose second vertices are seen from their first, and `own`,
    /// each once.
    pub fn receivers<'p, S: Strategy<SceneVertex<K>> + 'p, const N: usize>(
        &self,
        own: Pixel,
        paths: [&RandomSequence<'p, SceneVertex<K>, S>; N],
    ) -> impl Iterator<Item = Pixel> + use<'s, 'p, K, S, N> {
        let squares = paths.map(|path| self.reached(path));
        let others = (0..N).flat_map(move |i| {
            let (columns, rows) = squares[i].clone();
            let earlier = squares.clone();
            let square = rows.flat_map(move |y| columns.clone().map(move |x| (x, y)));
            square.filter(move |(x, y)| {
                (*x, *y) != own
                    && !earlier[..i].iter().any(|(xs, ys)| xs.contains(x) && ys.contains(y))
            })
        });
        std::iter::once(own).chain(others)
    }

    /// The columns and rows whose pixels' filters reach the film point where a path is seen.
    fn reached<S: Strategy<SceneVertex<K>>>(
        &self,
        path: &RandomSequence<'_, SceneVertex<K>, S>,
    ) -> (Range<u32>, Range<u32>) {
        let film = match (path.vertex(0), path.vertex(1)) {
            (Some(eye), Some(seen)) if path.is_complete() => self.film_point(&eye, &seen),
            _ => None,
        };
        let Some(film) = film else { return (0..0, 0..0) };
        let reach = self.scene.film.filter.radius();
        let along = |x: f32, size: u32| {
            let first = (x - reach - 0.5).ceil().max(0.0) as u32;
            first..((x + reach - 0.5).floor() + 1.0).clamp(0.0, size as f32) as u32
        };
        (along(film.x, self.scene.film.width), along(film.y, self.scene.film.height))
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

/// A disk, across the direction in which it faces, that all light from there comes through which meets the
/// scene.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Window {
    /// Its centre.
    pub centre: Vec3,
    /// A unit vector in its plane.
    pub u: Vec3,
    /// A unit vector in its plane across `u`.
    pub v: Vec3,
    /// The direction, of unit length, that light comes from.
    pub towards: Vec3,
    /// Its radius.
    pub radius: f32,
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
