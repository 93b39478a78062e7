//! Scenes: Mitsuba 3 XML files turned into flat lists that rays can be traced against.
//!
//! A file becomes a generic tree ([`document`], read by [`xml`]), and the tree a [`Scene`]
//! ([`Scene::load`]). What is not supported is an error that names file, line, column, element and
//! what is supported instead. Conventions are Mitsuba's: see [`Primitive`], [`ShapeKind`],
//! [`Camera`] and [`Filter`].

mod brightness;
pub mod bsdf;
pub mod camera;
pub mod document;
pub mod envmap;
pub mod error;
mod facts;
mod files;
pub(crate) mod hit;
mod indices;
pub mod inspect;
pub mod lights;
mod load;
mod load_bsdf;
mod load_lights;
mod load_settings;
mod load_texture;
mod mesh;
pub mod model;
mod obj;
mod packet;
mod params;
mod ply;
mod segment;
mod serialized;
pub mod settings;
mod shapes;
mod sight;
mod simd;
mod size;
pub mod spectrum;
mod stack;
mod surface;
mod tangents;
pub mod texture;
mod trace;
mod transform;
mod tree;
mod tree_build;
mod upgrade;
mod values;
pub(crate) mod vectors;
pub mod xml;

#[cfg(test)]
mod load_tests;
#[cfg(test)]
mod malformed_tests;
#[cfg(test)]
mod trace_tests;

use std::path::PathBuf;

use glam::{DVec3, Vec2, Vec3};

pub use bsdf::Bsdf;
pub use camera::Camera;
pub use error::SceneError;
pub use lights::{Bulb, Distant, Sky};
pub use load::Overrides;
pub use model::{Bounds, Emitter, Primitive, PrimitiveId, Rectangle, Shape, ShapeKind};
pub use settings::{Film, Filter, Integrator, Sampler, SamplerKind};
pub use sight::Sight;
pub use surface::Hit;
pub use tangents::Tangents;

pub use facts::MARGIN;

use facts::{Facts, facts};
use texture::Texture;
use trace::Tracer;

/// A scene ready to be rendered. It does not change any more, and threads share it.
pub struct Scene {
    /// The surfaces; those of a shape lie next to each other.
    pub primitives: Vec<Primitive>,
    /// The index in `shapes` of each primitive.
    pub primitive_shapes: Vec<u32>,
    /// The shapes in file order.
    pub shapes: Vec<Shape>,
    /// Shading normals at the corners of the triangles of smooth shapes, of unit length but for instances; see
    /// [`Scene::corner_normals`].
    pub normals: Vec<[Vec3; 3]>,
    /// Texture coordinates at the corners of the triangles of shapes that have them, or whose corners are not in the
    /// order of their file.
    pub texcoords: Vec<[Vec2; 3]>,
    /// The textures that materials refer to.
    pub textures: Vec<Texture>,
    /// The materials.
    pub bsdfs: Vec<Bsdf>,
    /// The emissive primitives, one entry for each.
    pub emitters: Vec<Emitter>,
    /// Light from all around, if there is any.
    pub sky: Option<Sky>,
    /// Lights that are points.
    pub bulbs: Vec<Bulb>,
    /// Parallel lights.
    pub distant: Vec<Distant>,
    /// The triangles of openings that light has to pass, which are no surfaces.
    pub portals: Vec<[Vec3; 3]>,
    /// The camera.
    pub camera: Camera,
    /// The image.
    pub film: Film,
    /// Where the uniforms come from.
    pub sampler: Sampler,
    /// What the file wants to render with.
    pub integrator: Integrator,
    /// Where in the file's world the coordinates of everything here have their zero: in the middle of a
    /// scene that lies further from the file's zero than it extends, otherwise there.
    pub origin: DVec3,
    /// The box around all primitives; [`Bounds::EMPTY`] if there are none.
    pub bounds: Bounds,
    /// What is strange about the file but no reason not to render it.
    pub warnings: Vec<SceneError>,
    /// The files that it was read from: the scene file, and what that refers to.
    pub files: Vec<PathBuf>,
    /// The parameters from outside that say nothing but how many samples there are.
    pub sample_parameters: Vec<String>,
    /// How many triangles were left out because they have no area.
    pub degenerate_triangles: usize,
    tracer: Tracer,
    /// The same without the shapes that emit, if eyes are not to see these.
    seen_by_eyes: Option<Tracer>,
    facts: Vec<Facts>,
}

impl Scene {
    /// A primitive.
    #[inline]
    pub fn primitive(&self, id: PrimitiveId) -> &Primitive {
        &self.primitives[id.0 as usize]
    }

    /// Centre and radius of a sphere that all surfaces lie in.
    pub fn bounding_sphere(&self) -> (Vec3, f32) {
        if self.primitives.is_empty() {
            return (Vec3::ZERO, 1.0);
        }
        let Bounds { min, max } = self.bounds;
        // Somewhat larger, for rounding.
        (0.5 * (min + max), 0.5001 * (max - min).length())
    }

    /// A point in the coordinates of the file.
    pub fn in_file(&self, point: Vec3) -> DVec3 {
        self.origin + point.as_dvec3()
    }

    /// The unit normal of a primitive at a point of it.
    #[inline]
    pub fn normal(&self, id: PrimitiveId, point: Vec3) -> Vec3 {
        let facts = &self.facts[id.0 as usize];
        if facts.is_round { self.primitive(id).normal(point) } else { facts.plane.normal }
    }

    /// The shape that a primitive belongs to.
    pub fn shape(&self, id: PrimitiveId) -> &Shape {
        &self.shapes[self.primitive_shapes[id.0 as usize] as usize]
    }

    /// The material of a primitive.
    pub fn bsdf(&self, id: PrimitiveId) -> &Bsdf {
        &self.bsdfs[self.shape(id).bsdf as usize]
    }

    /// The shading normals at the corners of a triangle, if its shape is smooth; of unit length but for instances.
    pub fn corner_normals(&self, id: PrimitiveId) -> Option<&[Vec3; 3]> {
        let shape = self.shape(id);
        let index = shape.first_normals? + (id.0 - shape.first_primitive);
        self.normals.get(index as usize)
    }

    /// The nearest surface that a ray hits. `direction` need not have unit length, distances are
    /// in the scene's unit. `skip` is the primitive that `origin` lies on: the ray leaves it
    /// without hitting it again, except through the inside of a sphere.
    ///
    /// No hit is reported for an origin or direction that is not finite or for a direction of 0.
    pub fn intersect(
        &self,
        origin: Vec3,
        direction: Vec3,
        skip: Option<PrimitiveId>,
    ) -> Option<Hit> {
        self.sight().intersect(origin, direction, skip)
    }

    /// Whether the open segment between two points is free. Each point may lie on a primitive,
    /// which then does not stand in the way, except a sphere whose inside the segment crosses.
    #[inline(always)]
    pub fn visible(
        &self,
        a: Vec3,
        a_primitive: Option<PrimitiveId>,
        b: Vec3,
        b_primitive: Option<PrimitiveId>,
    ) -> bool {
        self.sight().visible(a, a_primitive, b, b_primitive)
    }

    /// Whether nothing lies in a direction of unit length from a point, which may lie on a primitive.
    pub fn is_open(&self, from: Vec3, on: Option<PrimitiveId>, direction: Vec3) -> bool {
        self.sight().is_open(from, on, direction)
    }

    /// All surfaces.
    #[inline(always)]
    pub fn sight(&self) -> Sight<'_> {
        Sight { scene: self, tracer: &self.tracer }
    }

    /// What rays from eyes meet: shapes that emit are not there if the scene hides them.
    #[inline(always)]
    pub fn sight_of_eyes(&self) -> Sight<'_> {
        Sight { scene: self, tracer: self.seen_by_eyes.as_ref().unwrap_or(&self.tracer) }
    }

    /// Whether there are shapes that eyes do not see.
    #[inline(always)]
    pub fn hides_emitters(&self) -> bool {
        self.seen_by_eyes.is_some()
    }

    /// Whether rays from eyes pass through a primitive.
    #[inline]
    pub fn is_hidden(&self, id: PrimitiveId) -> bool {
        self.hides_emitters() && self.shape(id).emission.is_some()
    }
}
