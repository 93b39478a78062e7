//! The surface where a ray meets it: a point of the primitive, its normals and its texture coordinates.

use glam::{Vec2, Vec3};

use super::facts::off_the_edges;
use super::model::{Primitive, PrimitiveId};
use super::segment::RawHit;
use super::{Scene, hit, mesh};

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
    /// The surface at what a ray has met.
    #[inline(always)]
    pub(super) fn hit(&self, origin: Vec3, direction: Vec3, raw: &RawHit) -> Hit {
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
