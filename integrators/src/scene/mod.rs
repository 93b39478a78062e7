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
mod simd;
mod size;
pub mod spectrum;
mod stack;
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

use std::convert::identity;
use std::path::PathBuf;

use glam::{DVec3, Vec2, Vec3};

pub use bsdf::Bsdf;
pub use camera::Camera;
pub use error::SceneError;
pub use lights::{Bulb, Distant, Sky};
pub use load::Overrides;
pub use model::{Bounds, Emitter, Primitive, PrimitiveId, Rectangle, Shape, ShapeKind};
pub use settings::{Film, Filter, Integrator, Sampler, SamplerKind};
pub use tangents::Tangents;

use segment::{End, On, RawHit};
use simd::{At, Eight, Task, plainly};
use stack::Room;
use texture::Texture;
use trace::Tracer;
use vectors::is_finite;

use crate::work::{count_nearest, count_occlusion};

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

/// What rays meet of a scene.
#[derive(Clone, Copy)]
pub struct Sight<'s> {
    scene: &'s Scene,
    tracer: &'s Tracer,
}

/// Where a ray meets the scene.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hit {
    /// What was hit.
    pub primitive: PrimitiveId,
    /// Distance from the origin of the ray.
    pub t: f32,
    /// The point, computed on the primitive rather than along the ray.
    pub position: Vec3,
    /// Unit normal of the surface: outwards, unless the shape is flipped.
    pub geometric_normal: Vec3,
    /// Interpolated unit normal of smooth meshes, otherwise the geometric one.
    pub shading_normal: Vec3,
    /// Weights of a triangle's corners, or a disk's coordinates, or nothing.
    pub weights: Vec3,
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

    /// An end of a ray with the surface that it lies on.
    #[inline(always)]
    fn end(&self, end: End) -> (End, Option<On>) {
        (end, end.on.map(|id| self.on(id, end.point)))
    }

    /// A surface at a point of it.
    #[inline(always)]
    fn on(&self, id: PrimitiveId, point: Vec3) -> On {
        let facts = &self.facts[id.0 as usize];
        if facts.is_round { self.on_round(id, point) } else { facts.plane }
    }

    // Out of the way of the code for planes.
    #[inline(never)]
    fn on_round(&self, id: PrimitiveId, point: Vec3) -> On {
        let round = self.primitive(id);
        On::new(round, round.normal(point))
    }

    #[inline(always)]
    fn hit(&self, origin: Vec3, direction: Vec3, raw: &RawHit) -> Hit {
        // Few hits need it.
        let direction = || direction.normalize();
        let primitive = self.primitive(raw.primitive);
        let facts = &self.facts[raw.primitive.0 as usize];
        let w = raw.weights;
        let position = match *primitive {
            Primitive::Triangle { v0, v1, v2 } => {
                let edge = w.min_element() < facts.margin;
                let inner = if edge { off_the_edges(w, &[v0, v1, v2]) } else { w };
                let by_weights = inner.x * v0 + inner.y * v1 + inner.z * v2;
                // The weights give a point with the rounding error of the corners, large beside the
                // distance of a hit on a huge triangle. Elsewhere they are as good, and never outside.
                let is_huge = facts.size > 8.0 * (origin.abs().max_element() + raw.t);
                let on_plane = || hit::inside_on_plane([v0, v1, v2], origin, direction());
                is_huge.then(on_plane).flatten().unwrap_or(by_weights)
            }
            Primitive::Sphere { center, radius, .. } => {
                let c = center.as_dvec3();
                let outwards = (origin + raw.t * direction()).as_dvec3() - c;
                (c + f64::from(radius) * outwards.normalize_or_zero()).as_vec3()
            }
            Primitive::Cylinder { base, axis, radius, .. } => {
                let point = (origin + raw.t * direction()).as_dvec3();
                hit::onto_cylinder(point, base, axis, radius)
            }
            Primitive::Disk { center, u_axis, v_axis, .. } => center + w.x * u_axis + w.y * v_axis,
        };
        let normal = facts.plane.normal;
        let geometric_normal = if facts.is_round { primitive.normal(position) } else { normal };
        let mut shading_normal = geometric_normal;
        if facts.is_smooth
            && let Some([n0, n1, n2]) = self.corner_normals(raw.primitive)
            && let Some(normal) = (w.x * *n0 + w.y * *n1 + w.z * *n2).try_normalize()
        {
            shading_normal = normal;
        }
        Hit {
            primitive: raw.primitive,
            t: (position - origin).dot(direction()).max(0.0),
            position,
            geometric_normal,
            shading_normal,
            weights: w,
        }
    }

    /// The texture coordinates at a point of a primitive.
    pub fn texture_coordinates_at(&self, id: PrimitiveId, position: Vec3) -> Vec2 {
        let weights = match *self.primitive(id) {
            Primitive::Triangle { v0, v1, v2 } => mesh::barycentric(&[v0, v1, v2], position),
            Primitive::Sphere { .. } | Primitive::Cylinder { .. } => Vec3::ZERO,
            Primitive::Disk { center, u_axis, v_axis, .. } => {
                let [a, b] = hit::disk_coordinates(position, center, u_axis, v_axis);
                Vec3::new(a as f32, b as f32, 0.0)
            }
        };
        let normal = self.normal(id, position);
        self.texture_coordinates(&Hit {
            primitive: id,
            t: 0.0,
            position,
            geometric_normal: normal,
            shading_normal: normal,
            weights,
        })
    }

    /// The texture coordinates at a hit, as Mitsuba has them: those of the mesh, or of a triangle without
    /// any the weights of its second and third corner; of a sphere azimuth and polar angle, of a cylinder
    /// azimuth and height, of a disk radius and azimuth, all from 0 to 1.
    pub fn texture_coordinates(&self, hit: &Hit) -> Vec2 {
        let shape = self.shape(hit.primitive);
        let w = hit.weights;
        let turn = |y: f32, x: f32| (y.atan2(x) / std::f32::consts::TAU).rem_euclid(1.0);
        match self.primitive(hit.primitive) {
            Primitive::Triangle { .. } => {
                let index = hit.primitive.0 - shape.first_primitive;
                let first = shape.first_texcoords;
                let corners = first.and_then(|first| self.texcoords.get((first + index) as usize));
                corners.map_or(Vec2::new(w.y, w.z), |[a, b, c]| w.x * *a + w.y * *b + w.z * *c)
            }
            Primitive::Sphere { center, .. } => {
                let local = (shape.to_local * (hit.position - *center)).normalize_or_zero();
                let polar = local.z.clamp(-1.0, 1.0).acos() / std::f32::consts::PI;
                Vec2::new(turn(local.y, local.x), polar)
            }
            Primitive::Cylinder { base, .. } => {
                let local = shape.to_local * (hit.position - *base);
                Vec2::new(turn(local.y, local.x), local.z)
            }
            Primitive::Disk { .. } => Vec2::new(w.x.hypot(w.y), turn(w.y, w.x)),
        }
    }
}

impl<'s> Sight<'s> {
    /// [`Scene::intersect`] of these surfaces.
    pub fn intersect(
        self,
        origin: Vec3,
        direction: Vec3,
        skip: Option<PrimitiveId>,
    ) -> Option<Hit> {
        self.intersect_then(origin, direction, skip, identity)
    }

    /// The same with what becomes of the hit or of there being none, which is computed on the way: what is
    /// not asked of a hit costs nothing.
    #[inline(always)]
    pub fn intersect_then<T>(
        self,
        origin: Vec3,
        direction: Vec3,
        skip: Option<PrimitiveId>,
        then: impl FnOnce(Option<Hit>) -> T,
    ) -> T {
        count_nearest();
        let ray = Cast { sight: self, from: End { point: origin, on: skip }, direction, then };
        self.tracer.machine().run(ray)
    }

    /// [`Scene::visible`] among these surfaces.
    #[inline(always)]
    pub fn visible(
        self,
        a: Vec3,
        a_primitive: Option<PrimitiveId>,
        b: Vec3,
        b_primitive: Option<PrimitiveId>,
    ) -> bool {
        if !(is_finite(a) && is_finite(b)) {
            return false;
        }
        count_occlusion();
        let (from, to) = (End { point: a, on: a_primitive }, End { point: b, on: b_primitive });
        self.tracer.machine().run(Between { sight: self, from, to })
    }

    /// [`Scene::is_open`] among these surfaces.
    pub fn is_open(self, from: Vec3, on: Option<PrimitiveId>, direction: Vec3) -> bool {
        count_occlusion();
        let from = End { point: from, on };
        self.tracer.machine().run(Outwards { sight: self, from, direction })
    }
}

/// Finds what a ray meets first, and what becomes of it.
struct Cast<'a, F> {
    sight: Sight<'a>,
    from: End,
    direction: Vec3,
    then: F,
}

impl<T, F: FnOnce(Option<Hit>) -> T> Task for Cast<'_, F> {
    type Output = T;

    #[inline(always)]
    fn run<E: Eight>(self, at: At<'_, E>) -> T {
        let (Sight { scene, tracer }, direction) = (self.sight, self.direction);
        let start = scene.end(self.from);
        let hit = match tracer.nearest::<E>(at, start, direction) {
            Some(raw) => Some(scene.hit(self.from.point, direction, &raw)),
            None => None,
        };
        (self.then)(hit)
    }

    fn run_plainly(self, room: &Room) -> T {
        let Cast { sight, from, direction, then } = self;
        then(plainly(Cast { sight, from, direction, then: identity::<Option<Hit>> }, room))
    }
}

/// Finds whether nothing lies between two points.
struct Between<'a> {
    sight: Sight<'a>,
    from: End,
    to: End,
}

impl Task for Between<'_> {
    type Output = bool;

    #[inline(always)]
    fn run<E: Eight>(self, at: At<'_, E>) -> bool {
        let Sight { scene, tracer } = self.sight;
        tracer.unoccluded::<E>(at, scene.end(self.from), scene.end(self.to))
    }
}

/// Finds whether a ray meets nothing.
struct Outwards<'a> {
    sight: Sight<'a>,
    from: End,
    direction: Vec3,
}

impl Task for Outwards<'_> {
    type Output = bool;

    #[inline(always)]
    fn run<E: Eight>(self, at: At<'_, E>) -> bool {
        let Sight { scene, tracer } = self.sight;
        tracer.is_open::<E>(at, scene.end(self.from), self.direction)
    }
}

/// What is known of a primitive beside its corners.
#[derive(Clone, Copy, Debug)]
struct Facts {
    /// The plane of a planar primitive; those of round ones are not used.
    plane: On,
    /// The largest coordinate of the corners of a triangle.
    size: f32,
    /// The least weight of a corner for which a point of a triangle lies well off all edges.
    margin: f32,
    /// Whether it is a sphere or a cylinder, of which normals differ from point to point.
    is_round: bool,
    /// Whether its shape has shading normals.
    is_smooth: bool,
}

/// What is known of primitives, given the index of the shape of each.
fn facts(primitives: &[Primitive], shapes_of: &[u32], shapes: &[Shape]) -> Vec<Facts> {
    let facts = |(primitive, shape): (&Primitive, &u32)| {
        Facts::new(primitive, shapes[*shape as usize].first_normals.is_some())
    };
    primitives.iter().zip(shapes_of).map(facts).collect()
}

/// How far points of a triangle are kept off its edges, relative to the coordinates of its corners.
///
/// A ray that starts on a wall next to another one must not start behind that one: if it runs along it, the
/// line of the ray passes the edge of both underneath, and meets neither. So hits are brought so far inside
/// that rounding and the lift along the normal (`trace.rs`) cannot put them behind a wall that
/// meets theirs at more than about 10 degrees.
pub const MARGIN: f64 = 64.0 * f32::EPSILON as f64;

impl Facts {
    fn new(primitive: &Primitive, is_smooth: bool) -> Self {
        let (mut size, mut margin) = (0.0, 0.0);
        if let Primitive::Triangle { v0, v1, v2 } = *primitive {
            size = v0.abs().max(v1.abs()).max(v2.abs()).max_element();
            margin = margins(&[v0, v1, v2]).max_element();
        }
        let plane = On::new(primitive, primitive.normal(Vec3::ZERO));
        let is_round = matches!(primitive, Primitive::Sphere { .. } | Primitive::Cylinder { .. });
        Facts { plane, size, margin, is_round, is_smooth }
    }
}

/// The least weights of the corners of a triangle at which points lie off its edges.
fn margins(corners: &[Vec3; 3]) -> Vec3 {
    let [a, b, c] = *corners;
    let size = f64::from(a.abs().max(b.abs()).max(c.abs()).max_element());
    // A weight is the distance from an edge over the height of the triangle above it.
    let edges = Vec3::new(c.distance(b), a.distance(c), b.distance(a)).as_dvec3();
    let margins = MARGIN * size * edges / mesh::double_area_normal(corners).length();
    // A triangle narrower than that has the point in its middle.
    margins.as_vec3().min(Vec3::splat(1.0 / 3.0))
}

/// The weights of a point of a triangle, brought off its edges.
#[cold]
fn off_the_edges(weights: Vec3, corners: &[Vec3; 3]) -> Vec3 {
    let inner = weights.max(margins(corners));
    inner / inner.element_sum()
}
