//! What is known of each primitive before any ray is cast, so that no ray computes it again.

use glam::Vec3;

use super::mesh;
use super::model::{Primitive, Shape};
use super::segment::On;

/// What is known of a primitive beside its corners.
#[derive(Clone, Copy, Debug)]
pub struct Facts {
    /// The plane of a planar primitive; those of round ones are not used.
    pub plane: On,
    /// The largest coordinate of the corners of a triangle.
    pub size: f32,
    /// The least weight of a corner for which a point of a triangle lies well off all edges.
    pub margin: f32,
    /// Whether it is a sphere or a cylinder, of which normals differ from point to point.
    pub is_round: bool,
    /// Whether its shape has shading normals.
    pub is_smooth: bool,
}

/// What is known of primitives, given the index of the shape of each.
pub fn facts(primitives: &[Primitive], shapes_of: &[u32], shapes: &[Shape]) -> Vec<Facts> {
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
pub fn off_the_edges(weights: Vec3, corners: &[Vec3; 3]) -> Vec3 {
    let inner = weights.max(margins(corners));
    inner / inner.element_sum()
}
