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

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::*;

    /// The tangents where a ray along an axis meets a shape.
    fn of(shape: &str, origin: Vec3, direction: Vec3) -> Tangents {
        let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../tests/scenes/textures");
        let xml = format!(r#"<scene version="3.0.0"><sensor type="perspective"/>{shape}</scene>"#);
        let scene = Scene::from_str(&xml, &folder, &[]).unwrap_or_else(|error| panic!("{error}"));
        scene.tangents(&scene.intersect(origin, direction, None).expect("a hit"))
    }

    #[test]
    fn tangents_are_those_of_mitsuba() {
        let (side, above) = (Vec3::new(3.0, 0.5, 0.4), Vec3::new(0.3, 0.4, 3.0));
        let turned = r#"<shape type="sphere"><float name="radius" value="0.5"/>
            <transform name="to_world"><scale value="2"/><rotate z="1" angle="30"/>
            <rotate x="1" angle="-70"/></transform></shape>"#;
        let bent = r#"<shape type="obj"><string name="filename" value="bent.obj"/></shape>"#;
        let [gem, flipped_gem] = [false, true].map(|flip| {
            format!(
                r#"<shape type="obj"><string name="filename" value="../meshes/gem.obj"/>
                <boolean name="flip_normals" value="{flip}"/></shape>"#
            )
        });
        let down = Vec3::NEG_Z;
        // From `scene.ray_intersect` of Mitsuba 3.9.1.
        for (shape, origin, direction, du, dv) in [
            (
                r#"<shape type="sphere"/>"#,
                side,
                Vec3::NEG_X,
                [-PI, 4.82621, 0.0],
                [1.05316, 0.685552, -2.87932],
            ),
            (
                turned,
                side,
                Vec3::NEG_X,
                [1.28722, 1.65066, -4.53515],
                [1.84149, -2.51483, -0.39265],
            ),
            (r#"<shape type="disk"/>"#, above, down, [0.6, 0.8, 0.0], [-2.51327, 1.88496, 0.0]),
            (r#"<shape type="rectangle"/>"#, above, down, [2.0, 0.0, 0.0], [0.0, 2.0, 0.0]),
            (r#"<shape type="cube"/>"#, above, down, [0.0, 2.0, 0.0], [2.0, 0.0, 0.0]),
            (bent, Vec3::new(0.3, -0.2, 3.0), down, [1.0, -0.25, 0.125], [0.0, -1.25, 0.125]),
            (bent, Vec3::new(-0.3, 0.2, 3.0), down, [1.0, -0.25, -0.5], [0.0, -1.25, -0.5]),
            (&gem, above, down, [0.690983, 0.0, -0.951057], [-0.309017, 0.9, -0.951057]),
            (&flipped_gem, above, down, [0.690983, 0.0, -0.951057], [-0.309017, 0.9, -0.951057]),
        ] {
            let found = of(shape, origin, direction);
            let near = |a: Vec3, b: [f32; 3]| (a - Vec3::from(b)).length() < 2e-5;
            assert!(near(found.du, du) && near(found.dv, dv), "{found:?} for {shape}");
        }
    }
}
