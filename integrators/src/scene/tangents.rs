//! How texture coordinates run over surfaces.

use std::f32::consts::{PI, TAU};

use glam::{Vec2, Vec3};

use super::{Hit, Primitive, Scene};

/// How a point of a surface moves with its texture coordinates; zero where that is not known.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Tangents {
    /// With the first.
    pub du: Vec3,
    /// With the second.
    pub dv: Vec3,
}

impl Scene {
    /// How the point at a hit moves with the coordinates that [`Scene::texture_coordinates`] gives.
    pub fn tangents(&self, hit: &Hit) -> Tangents {
        let shape = self.shape(hit.primitive);
        match *self.primitive(hit.primitive) {
            Primitive::Triangle { v0, v1, v2 } => {
                let edges = [v1 - v0, v2 - v0];
                let index = hit.primitive.0 - shape.first_primitive;
                let first = shape.first_texcoords;
                let corners = first.and_then(|first| self.texcoords.get((first + index) as usize));
                corners.map_or(Tangents { du: edges[0], dv: edges[1] }, |corners| {
                    of_triangle(edges, corners)
                })
            }
            Primitive::Sphere { center, radius, .. } => {
                let local = (shape.to_local * (hit.position - center)).normalize_or_zero();
                // The inverse of a rotation and a scale, but for the scale.
                let scale = radius / shape.to_local.x_axis.length();
                let to_world = |v: Vec3| shape.to_local.transpose() * v * scale;
                let around = Vec3::new(-local.y, local.x, 0.0);
                let height = local.x.hypot(local.y);
                let down = Vec2::new(local.x, local.y).try_normalize().unwrap_or(Vec2::X) * local.z;
                let down = Vec3::new(down.x, down.y, -height);
                Tangents { du: to_world(around * TAU), dv: to_world(down * PI) }
            }
            Primitive::Cylinder { base, axis, .. } => {
                let local = shape.to_local * (hit.position - base);
                let around = Vec3::new(-local.y, local.x, 0.0) * TAU;
                Tangents { du: shape.to_local.inverse() * around, dv: axis }
            }
            Primitive::Disk { u_axis, v_axis, .. } => {
                let (x, y) = (hit.weights.x, hit.weights.y);
                let Vec2 { x: c, y: s } = Vec2::new(x, y).normalize_or_zero();
                Tangents { du: c * u_axis + s * v_axis, dv: TAU * (x * v_axis - y * u_axis) }
            }
        }
    }
}

/// The derivatives of the linear function that takes the texture coordinates of the corners to the corners,
/// given the two edges from the first corner.
fn of_triangle([e1, e2]: [Vec3; 2], [a, b, c]: &[Vec2; 3]) -> Tangents {
    let (p, q) = (*b - *a, *c - *a);
    let determinant = p.perp_dot(q);
    if determinant == 0.0 {
        return Tangents::default();
    }
    Tangents { du: (q.y * e1 - p.y * e2) / determinant, dv: (p.x * e2 - q.x * e1) / determinant }
}
