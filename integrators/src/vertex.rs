//! The vertices of light paths, and what external code tells about them.

use aether_core::prelude::*;
use aether_core::{Recall, Vertex};
use glam::Vec3 as Vector;

use crate::samplers::{HitPlane, hit_plane};
use crate::scene::PrimitiveId;

/// What a ray cast found: a piece of surface, constant near the sample.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Surface {
    /// Where the ray met it.
    pub position: Vector,
    /// Unit normal of the surface.
    pub normal: Vector,
    /// Unit normal for shading.
    pub shading: Vector,
    /// Which primitive of the scene it is.
    pub primitive: PrimitiveId,
    /// Which emitter of the scene it is, if it is one.
    pub emitter: Option<u32>,
}

impl Surface {
    /// Where rays from `origin` meet this piece of surface: the map from directions to its points.
    pub fn seen_from(&self, origin: Vector) -> HitPlane<f32> {
        let id = surface_id(self.primitive);
        hit_plane(origin.into(), self.position.into(), self.normal.into(), id)
    }
}

/// The pinhole of a camera.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pinhole {
    /// Where it is.
    pub position: Vector,
}

/// A vertex of a light path: the pinhole, or a point of a surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SceneVertex {
    /// Where it is.
    pub position: Vector,
    /// The surface that it lies on; none for the pinhole.
    pub surface: Option<Surface>,
}

impl SceneVertex {
    /// The vertex at a pinhole.
    pub fn pinhole(pinhole: Pinhole) -> Self {
        SceneVertex { position: pinhole.position, surface: None }
    }

    /// The vertex where a ray met a surface. The ray caster computes the position on the primitive,
    /// more accurately than along the ray: `point`, the same position in the language, gives way.
    pub fn hit(surface: Surface, _point: SurfacePoint<f32>) -> Self {
        SceneVertex { position: surface.position, surface: Some(surface) }
    }

    /// A vertex on a surface that was chosen rather than found: a point of a light.
    pub fn on(surface: Surface) -> Self {
        SceneVertex { position: surface.position, surface: Some(surface) }
    }

    /// The primitive that the vertex lies on.
    pub fn primitive(&self) -> Option<PrimitiveId> {
        self.surface.map(|s| s.primitive)
    }
}

/// The identity of a primitive in the language.
pub fn surface_id(primitive: PrimitiveId) -> SurfaceId {
    SurfaceId(primitive.0)
}

impl Vertex for SceneVertex {
    type Real = f32;
    type Point = SurfacePoint<f32>;

    fn point(&self) -> SurfacePoint<f32> {
        let id = self.primitive().map_or(SurfaceId(u32::MAX), surface_id);
        SurfacePoint::new(self.position.into(), id)
    }
}

impl Recall<Surface> for SceneVertex {
    fn recall(&self) -> Option<Surface> {
        self.surface
    }
}

impl Recall<Pinhole> for SceneVertex {
    fn recall(&self) -> Option<Pinhole> {
        self.surface.is_none().then_some(Pinhole { position: self.position })
    }
}
