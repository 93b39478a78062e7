//! From a `<shape>` to primitives.

use glam::{DMat3, DMat4, DVec2, DVec3, Mat3};

use super::document::Query;
use super::error::SceneError;
use super::files::find_file;
use super::mesh::{self, Corner, Mesh, Placement, Triangles};
use super::model::{Primitive, ShapeKind};
use super::values::relative_determinant;
use super::{obj, ply, serialized};

/// Coordinates beyond this have areas that overflow f32.
pub const MAX_COORDINATE: f64 = 1e15;

/// The primitives of a shape.
#[derive(Debug, Default)]
pub struct Geometry {
    /// The primitives.
    pub primitives: Vec<Primitive>,
    /// Shading normals at the corners of each triangle; empty if the shape is flat or round.
    pub normals: Vec<[glam::Vec3; 3]>,
    /// Texture coordinates at the corners of each triangle; empty if the shape has none of its own.
    pub texcoords: Vec<[glam::Vec2; 3]>,
    /// Triangles left out because they have no area.
    pub degenerate: usize,
}

/// The kind that a plugin type names.
pub fn kind(query: &Query) -> Result<ShapeKind, SceneError> {
    Ok(match query.object.plugin.as_str() {
        "rectangle" => ShapeKind::Rectangle,
        "cube" => ShapeKind::Cube,
        "sphere" => ShapeKind::Sphere,
        "disk" => ShapeKind::Disk,
        "obj" => ShapeKind::Obj,
        "ply" => ShapeKind::Ply,
        "serialized" => ShapeKind::Serialized,
        _ => return Err(query.unsupported("rectangle, cube, sphere, disk, obj, ply, serialized")),
    })
}

/// A shape in the world, in double precision and not yet moved to where the scene has its zero.
#[derive(Debug)]
pub enum Source {
    /// Triangles.
    Mesh {
        /// Vertices in the world.
        mesh: Mesh,
        /// For normals and winding.
        placement: Placement,
        /// Whether the triangles are flat.
        face_normals: bool,
    },
    /// A sphere.
    Sphere {
        /// The centre.
        center: DVec3,
        /// The radius.
        radius: f64,
        /// Whether the normals point to the centre.
        flipped: bool,
        /// From directions in the world to those of the sphere's own coordinates.
        to_local: Mat3,
    },
    /// The unit disk in the plane z = 0, and where it went.
    Disk(Placement),
}

/// Reads a shape and places it in the world.
pub fn read(kind: ShapeKind, query: &Query) -> Result<Source, SceneError> {
    let placement = Placement {
        to_world: query.transform("to_world")?.unwrap_or(DMat4::IDENTITY),
        flip_normals: query.boolean("flip_normals")?.unwrap_or(false),
    };
    if relative_determinant(&placement.to_world).abs() < 1e-12 {
        return Err(query.error_at("to_world", "the transform flattens space"));
    }
    // These concern only features that do not exist here.
    query.ignore(&["silhouette_sampling_weight", "max_smooth_angle"]);
    let in_world = |mut mesh: Mesh, face_normals| {
        mesh.move_to_world(&placement);
        Source::Mesh { mesh, placement, face_normals }
    };
    Ok(match kind {
        ShapeKind::Rectangle => in_world(rectangle(), true),
        ShapeKind::Cube => in_world(cube(), true),
        ShapeKind::Sphere => sphere(query, &placement)?,
        ShapeKind::Disk => Source::Disk(placement),
        ShapeKind::Obj | ShapeKind::Ply | ShapeKind::Serialized => {
            let face_normals = query.boolean("face_normals")?;
            let (mesh, flat) = read_mesh(kind, query)?;
            in_world(mesh, face_normals.unwrap_or(flat))
        }
    })
}

/// Where a scene has its zero: that of the file, unless its shapes lie further from there than they
/// extend. Then it is in their middle, so that single precision does for their coordinates.
pub fn origin<'a>(sources: impl Iterator<Item = &'a Source>) -> DVec3 {
    let empty = [DVec3::INFINITY, DVec3::NEG_INFINITY];
    let [min, max] =
        sources.map(Source::bounds).fold(empty, |a, b| [a[0].min(b[0]), a[1].max(b[1])]);
    let (middle, extent) = (0.5 * (min + max), (max - min).max_element());
    if middle.is_finite() && middle.abs().max_element() > extent { middle } else { DVec3::ZERO }
}

impl Source {
    /// From directions in the world to those of a sphere's own coordinates.
    pub fn to_local(&self) -> Mat3 {
        if let Source::Sphere { to_local, .. } = self { *to_local } else { Mat3::IDENTITY }
    }

    /// The corners of a box around the shape.
    fn bounds(&self) -> [DVec3; 2] {
        match self {
            Source::Mesh { mesh, .. } => {
                let empty = [DVec3::INFINITY, DVec3::NEG_INFINITY];
                mesh.positions.iter().fold(empty, |[min, max], p| [min.min(*p), max.max(*p)])
            }
            Source::Sphere { center, radius, .. } => [*center - *radius, *center + *radius],
            Source::Disk(placement) => {
                let m = placement.to_world;
                let (center, reach) = (m.w_axis.truncate(), (m.x_axis.abs() + m.y_axis.abs()));
                [center - reach.truncate(), center + reach.truncate()]
            }
        }
    }

    /// The primitives, with `origin` as zero. `None` if coordinates or areas leave the range in which
    /// single precision can compute with them.
    pub fn geometry(&self, origin: DVec3) -> Option<Geometry> {
        let geometry = match self {
            Source::Mesh { mesh, placement, face_normals } => {
                triangles(mesh::place(mesh, placement, *face_normals, origin))
            }
            Source::Sphere { center, radius, flipped, .. } => Geometry::of(Primitive::Sphere {
                center: (*center - origin).as_vec3(),
                radius: *radius as f32,
                flipped: *flipped,
            }),
            Source::Disk(placement) => disk(placement, origin),
        };
        let representable = |p: &Primitive| {
            let bounds = p.bounds();
            let largest = bounds.min.abs().max(bounds.max.abs()).max_element();
            // Written so that NaN is refused.
            f64::from(largest) <= MAX_COORDINATE && p.area() >= f32::MIN_POSITIVE
        };
        geometry.primitives.iter().all(representable).then_some(geometry)
    }
}

impl Geometry {
    /// A single primitive.
    fn of(primitive: Primitive) -> Geometry {
        Geometry { primitives: vec![primitive], ..Geometry::default() }
    }
}

fn triangles(placed: Triangles) -> Geometry {
    let triangle = |[v0, v1, v2]: [glam::Vec3; 3]| Primitive::Triangle { v0, v1, v2 };
    Geometry {
        primitives: placed.vertices.into_iter().map(triangle).collect(),
        normals: placed.normals,
        texcoords: placed.texcoords,
        degenerate: placed.degenerate,
    }
}

/// The mesh of a file, and whether the file wants it flat.
fn read_mesh(kind: ShapeKind, query: &Query) -> Result<(Mesh, bool), SceneError> {
    let name = query.string("filename")?;
    let name = name.ok_or_else(|| query.error_at("", "the string \"filename\" is missing"))?;
    let path = find_file(name, &query.object.folders).map_err(|e| query.error_at("filename", e))?;
    let bytes = std::fs::read(&path)
        .map_err(|e| query.error_at("filename", format!("{}: {e}", path.display())))?;
    let (mut mesh, flat) = match kind {
        ShapeKind::Obj => (obj::read(&bytes, &path)?, false),
        ShapeKind::Serialized => {
            let index = query.integer("shape_index", 0, i64::from(u32::MAX))?.unwrap_or(0);
            serialized::read(&bytes, &path, index as usize)?
        }
        _ => (ply::read(&bytes, &path)?, false),
    };
    // As Mitsuba: files in OBJ have v upwards, pictures have their first row at v = 0.
    let flip = query.boolean("flip_tex_coords")?.unwrap_or(kind == ShapeKind::Obj);
    if flip {
        mesh.texcoords.iter_mut().for_each(|uv| uv.y = 1.0 - uv.y);
    }
    Ok((mesh, flat))
}

/// The square `[-1, 1]²` in the plane z = 0, facing +z.
fn rectangle() -> Mesh {
    let mut mesh = Mesh {
        positions: [[-1., -1.], [1., -1.], [1., 1.], [-1., 1.]]
            .map(|[x, y]| DVec3::new(x, y, 0.0))
            .to_vec(),
        texcoords: unit_square(),
        ..Mesh::default()
    };
    mesh.push_polygon(&[0, 1, 2, 3].map(|v| Corner { texcoord: v, ..Corner::plain(v) }));
    mesh
}

/// The cube `[-1, 1]³` with outward normals. Bit k of a corner's index is the sign of axis k. Each
/// face has the whole unit square, turned as in Mitsuba.
fn cube() -> Mesh {
    let sign = |corner: u32, axis: u32| if corner >> axis & 1 == 1 { 1.0 } else { -1.0 };
    let corner = |i| DVec3::new(sign(i, 0), sign(i, 1), sign(i, 2));
    let positions = (0..8).map(corner).collect();
    let texcoords = vec![DVec2::Y, DVec2::ONE, DVec2::X, DVec2::ZERO];
    let mut mesh = Mesh { positions, texcoords, ..Mesh::default() };
    for (face, first) in [
        ([0, 4, 6, 2], 3),
        ([1, 3, 7, 5], 0),
        ([0, 1, 5, 4], 3),
        ([2, 6, 7, 3], 1),
        ([0, 2, 3, 1], 2),
        ([4, 5, 7, 6], 3),
    ] {
        let corner =
            |i: u32| Corner { texcoord: (first + i) % 4, ..Corner::plain(face[i as usize]) };
        mesh.push_polygon(&[0, 1, 2, 3].map(corner));
    }
    mesh
}

/// The corners of the unit square.
fn unit_square() -> Vec<DVec2> {
    vec![DVec2::ZERO, DVec2::X, DVec2::ONE, DVec2::Y]
}

fn sphere(query: &Query, placement: &Placement) -> Result<Source, SceneError> {
    let center = query.vector("center")?.unwrap_or(DVec3::ZERO);
    let radius = query.float("radius")?.unwrap_or(1.0);
    if radius <= 0.0 {
        return Err(query.error_at("radius", "the radius must be positive"));
    }
    let m = placement.to_world;
    let [x, y, z] = [m.x_axis, m.y_axis, m.z_axis].map(|column| column.truncate());
    let scale = x.length();
    let uneven = [y.length() - scale, z.length() - scale];
    let skewed = [x.dot(y), y.dot(z), z.dot(x)].map(|dot| dot / scale);
    if uneven.iter().chain(&skewed).any(|e| e.abs() > 1e-3 * scale) {
        return Err(query.error_at(
            "to_world",
            "a sphere must be scaled evenly; ellipsoids are not supported (nearest: ply, obj)",
        ));
    }
    // As in Mitsuba, a mirror image of a sphere is turned inside out.
    let mirrored = relative_determinant(&m) < 0.0;
    Ok(Source::Sphere {
        center: m.transform_point3(center),
        radius: radius * scale,
        flipped: placement.flip_normals != mirrored,
        to_local: DMat3::from_cols(x, y, z).inverse().as_mat3(),
    })
}

fn disk(placement: &Placement, origin: DVec3) -> Geometry {
    let m = placement.to_world;
    let normal = (placement.normal_matrix() * DVec3::Z).normalize();
    Geometry::of(Primitive::Disk {
        center: (m.w_axis.truncate() - origin).as_vec3(),
        normal: normal.as_vec3(),
        u_axis: m.x_axis.truncate().as_vec3(),
        v_axis: m.y_axis.truncate().as_vec3(),
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::mesh::unit_normal;

    const IDENTITY: Placement = Placement { to_world: DMat4::IDENTITY, flip_normals: false };

    #[test]
    fn cubes_face_outwards() {
        let cube = mesh::place(&cube(), &IDENTITY, true, DVec3::ZERO);
        assert_eq!(cube.vertices.len(), 12);
        for triangle in &cube.vertices {
            let normal = unit_normal(triangle).unwrap();
            assert!(triangle.iter().all(|v| v.dot(normal) == 1.0), "{triangle:?}");
        }
        let area: f64 = cube.vertices.iter().map(|t| mesh::double_area_normal(t).length()).sum();
        assert_eq!(area, 48.0);
    }

    #[test]
    fn rectangles_and_disks_face_up_even_mirrored() {
        let rectangle = mesh::place(&rectangle(), &IDENTITY, true, DVec3::ZERO);
        assert!(rectangle.vertices.iter().all(|t| unit_normal(t) == Some(glam::Vec3::Z)));
        let mirrored =
            Placement { to_world: DMat4::from_scale(DVec3::new(-1.0, 2.0, 1.0)), ..IDENTITY };
        let Primitive::Disk { normal, .. } = disk(&mirrored, DVec3::ZERO).primitives[0] else {
            panic!("a disk is a disk");
        };
        assert_eq!(normal, glam::Vec3::Z);
        assert!(
            (disk(&mirrored, DVec3::ZERO).primitives[0].area() - 2.0 * std::f32::consts::PI).abs()
                < 1e-6
        );
    }
}
