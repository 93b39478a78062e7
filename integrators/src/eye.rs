//! What cameras other than pinholes need, a lens, or a film from which all rays are parallel; and where on the
//! film a camera sees what.

use aether_core::prelude::*;
use glam::Vec3 as Vector;

use crate::integrand::film_points;
use crate::kind::SceneKind;
use crate::samplers::{ParallelHit, parallel_hit, pinhole, rotate};
use crate::scene::Camera;
use crate::scene::camera::Projection;
use crate::vertex::SceneVertex;
use crate::world::World;

/// The surface that points of a lens lie on; no primitive has this number.
pub const LENS: SurfaceId = SurfaceId(u32::MAX);

/// The plane that a parallel projection sees where there is nothing; no primitive has this number.
pub const BACKDROP: SurfaceId = SurfaceId(u32::MAX - 1);

/// A thin lens: a disk from each point of which the same plane is in focus.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Lens {
    /// Its centre.
    pub centre: Vector,
    /// Its radius to the right of the image.
    pub across: Vector,
    /// Its radius to the bottom of the image.
    pub down: Vector,
    /// The distance of the plane in focus.
    pub focus_distance: f32,
}

impl Lens {
    /// The lens of a camera, if it has one.
    pub fn of(camera: &Camera) -> Option<Self> {
        let Projection::ThinLens { aperture_radius, focus_distance } = camera.projection else {
            return None;
        };
        Some(Lens {
            centre: camera.origin,
            across: aperture_radius * camera.right,
            down: -aperture_radius * camera.up,
            focus_distance,
        })
    }

    /// By how much the film seen from a point of the lens is shifted against that seen from its centre, in
    /// units of the plane at distance one: as through a pinhole there, whose picture is laid so
    /// that the plane in focus stays where it is.
    pub fn shift(&self, point: Vector) -> Vec2<f32> {
        let offset = point - self.centre;
        let along = |axis: Vector| offset.dot(axis.normalize_or_zero()) / self.focus_distance;
        Vec2::new(along(self.across), along(self.down))
    }

    /// Its area.
    pub fn area(&self) -> f32 {
        std::f32::consts::PI * self.across.length() * self.down.length()
    }
}

/// The film of a parallel projection, in front of which it sees everything that its rays meet.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ParallelFilm {
    /// Where the film point `centre` is in the world.
    pub origin: Vector,
    /// The film point at the origin, in pixels.
    pub centre: Vec2<f32>,
    /// One pixel to the right.
    pub across: Vector,
    /// One pixel down.
    pub down: Vector,
    /// The direction of all rays, of unit length.
    pub forward: Vector,
}

impl ParallelFilm {
    /// The film of a camera with the film point that its axis goes through, if its projection is parallel.
    pub fn of(camera: &Camera, centre: Vec2<f32>) -> Option<Self> {
        let Projection::Orthographic { across, down } = camera.projection else { return None };
        let Camera { origin, forward, .. } = *camera;
        Some(ParallelFilm { origin, centre, across, down, forward })
    }

    /// Where a film point is in the world.
    pub fn point(&self, film: &Vec2<f32>) -> Vector {
        self.origin + (film.x - self.centre.x) * self.across + (film.y - self.centre.y) * self.down
    }

    /// The point of the film, or of the plane that it lies in, from which a point is seen.
    pub fn before(&self, point: Vector) -> Vector {
        let normal = self.across.cross(self.down);
        point - (point - self.origin).dot(normal) / self.forward.dot(normal) * self.forward
    }

    /// From film points to points of the plane of a piece of surface.
    pub fn onto(&self, point: Vector, normal: Vector, id: SurfaceId) -> ParallelHit<f32> {
        let [origin, across, down, forward] =
            [self.origin, self.across, self.down, self.forward].map(Into::into);
        parallel_hit(self.centre, origin, across, down, forward, point.into(), normal.into(), id)
    }

    /// From film points to points of a plane behind the film, which stands for all that lies infinitely far.
    pub fn backdrop(&self) -> ParallelHit<f32> {
        let size = self.origin.abs().max_element() + self.across.length() + self.down.length();
        self.onto(self.origin + size * self.forward, self.forward, BACKDROP)
    }
}

impl<'s, K: SceneKind> World<'s, K> {
    /// The map from points of the film, in pixels, to the directions that they look in.
    pub fn film_to_direction(
        &self,
        eye: &SceneVertex<K>,
    ) -> impl Map<f32, Source = Vec2<f32>, Target = Direction<f32>> {
        pinhole(self.film_centre(eye), self.film_scale()).then(rotate(self.camera_frame))
    }

    /// The point of the film, in pixels, where a camera at the vertex `eye` sees another vertex; `None`
    /// if that lies behind it. It may lie beside the image.
    pub fn film_point(&self, eye: &SceneVertex<K>, seen: &SceneVertex<K>) -> Option<Vec2<f32>> {
        let mut point = None;
        film_points(self, eye, seen, |film, _| point = Some(film));
        point
    }

    /// The corner and the size of the part of the film that the filter of some pixel reaches.
    pub fn reachable_film(&self) -> (Vec2<f32>, Vec2<f32>) {
        let beyond = self.scene.film.filter.radius() - 0.5;
        let size = |pixels: u32| pixels as f32 + 2.0 * beyond;
        let (width, height) = (self.scene.film.width, self.scene.film.height);
        (Vec2::new(-beyond, -beyond), Vec2::new(size(width), size(height)))
    }

    /// How many pixels the image has.
    pub fn pixels(&self) -> usize {
        self.scene.film.width as usize * self.scene.film.height as usize
    }

    /// The point of the film, in pixels of the image, that is seen straight ahead from the eye: a pinhole,
    /// or a point of the lens, from which it is shifted.
    #[inline]
    pub fn film_centre(&self, eye: &SceneVertex<K>) -> Vec2<f32> {
        let centre = self.film.centre;
        let Some(lens) = self.lens() else { return centre };
        let (shift, scale) = (lens.shift(eye.position), self.film_scale());
        Vec2::new(centre.x + shift.x / scale.x, centre.y + shift.y / scale.y)
    }

    /// Width and height of a pixel at distance one.
    #[inline]
    pub fn film_scale(&self) -> Vec2<f32> {
        self.film.scale
    }
}
