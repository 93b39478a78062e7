//! From a `<shape>` to primitives.

use std::rc::Rc;

use aether_core::prelude::{Direction, Frame};
use glam::{DMat3, DMat4, DVec2, DVec3, Mat3};

use super::document::Query;
use super::error::SceneError;
use super::files::read_bytes;
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
    /// What the file says of the triangles besides: a name, and values at the corners of each.
    pub attributes: Vec<(String, Vec<[glam::Vec3; 3]>)>,
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
        "cylinder" => ShapeKind::Cylinder,
        "obj" => ShapeKind::Obj,
        "ply" => ShapeKind::Ply,
        "serialized" => ShapeKind::Serialized,
        _ => {
            let supported = "rectangle, cube, sphere, disk, cylinder, obj, ply, serialized, shapegroup, instance";
            return Err(query.unsupported(supported));
        }
    })
}

/// A shape in its own coordinates, in double precision, and how it is placed in the world.
#[derive(Clone, Debug)]
pub struct Source {
    form: Form,
    placement: Placement,
    /// Whether the normals of a round shape point inwards.
    flipped: bool,
}

/// What a shape is, in its own coordinates. Instances share the mesh.
#[derive(Clone, Debug)]
enum Form {
    /// Triangles, and whether they are flat.
    Mesh(Rc<Mesh>, bool),
    /// A sphere.
    Sphere { center: DVec3, radius: f64 },
    /// The side of a cylinder.
    Cylinder { p0: DVec3, p1: DVec3, radius: f64 },
    /// The unit disk in the plane z = 0.
    Disk,
}

/// Reads a shape.
pub fn read(kind: ShapeKind, query: &Query) -> Result<Source, SceneError> {
    let placement = Placement {
        to_world: query.transform("to_world")?.unwrap_or(DMat4::IDENTITY),
        flip_normals: query.boolean("flip_normals")?.unwrap_or(false),
        is_instance: false,
    };
    // These concern only features that do not exist here.
    query.ignore(&["silhouette_sampling_weight", "max_smooth_angle"]);
    let form = match kind {
        ShapeKind::Rectangle => Form::Mesh(Rc::new(rectangle()), true),
        ShapeKind::Cube => Form::Mesh(Rc::new(cube()), true),
        ShapeKind::Sphere => Form::Sphere {
            center: query.vector("center")?.unwrap_or(DVec3::ZERO),
            radius: radius(query)?,
        },
        ShapeKind::Cylinder => {
            let p0 = query.vector("p0")?.unwrap_or(DVec3::ZERO);
            let p1 = query.vector("p1")?.unwrap_or(DVec3::Z);
            if (p1 - p0).length() < 1e-12 * p0.length().max(p1.length()) || p0 == p1 {
                return Err(query.error_at("p1", "p0 and p1 must differ"));
            }
            Form::Cylinder { p0, p1, radius: radius(query)? }
        }
        ShapeKind::Disk => Form::Disk,
        ShapeKind::Obj | ShapeKind::Ply | ShapeKind::Serialized => {
            let face_normals = query.boolean("face_normals")?;
            let (mesh, flat) = read_mesh(kind, query)?;
            Form::Mesh(Rc::new(mesh), face_normals.unwrap_or(flat))
        }
    };
    // As in Mitsuba, a mirror image of a sphere is turned inside out, unless an instance is the mirror image.
    let mirrored = relative_determinant(&placement.to_world) < 0.0;
    let inside_out = mirrored && kind == ShapeKind::Sphere;
    let source = Source { form, placement, flipped: placement.flip_normals != inside_out };
    source.check().map_err(|message| query.error_at("to_world", message))?;
    Ok(source)
}

fn radius(query: &Query) -> Result<f64, SceneError> {
    let radius = query.float("radius")?.unwrap_or(1.0);
    if radius > 0.0 {
        Ok(radius)
    } else {
        Err(query.error_at("radius", "the radius must be positive"))
    }
}

/// Where a scene has its zero: that of the file, unless its shapes lie further from there than they
/// extend. Then it is in their middle, so that single precision does for their coordinates.
pub fn origin<'a>(sources: impl Iterator<Item = &'a Source>) -> DVec3 {
    let empty = [DVec3::INFINITY, DVec3::NEG_INFINITY];
    let [min, max] =
        sources.map(Source::bounds).fold(empty, |a, b| [a[0].min(b[0]), a[1].max(b[1])]);
    let (middle, extent) = (0.5 * (min + max), (max - min).max_element());
    let distance = middle.abs().max_element();
    // Written so that NaN is refused. Shapes that are too far away stay where they are, to be refused.
    if distance > extent && distance <= MAX_COORDINATE { middle } else { DVec3::ZERO }
}

impl Source {
    /// The same shape as instances move it: with the normals that it has before.
    pub fn settled(self) -> Source {
        let Form::Mesh(mesh, false) = &self.form else { return self };
        let mesh = Rc::new(mesh::settled(mesh, &self.placement));
        let placement =
            Placement { to_world: DMat4::IDENTITY, flip_normals: false, is_instance: true };
        Source { form: Form::Mesh(mesh, false), placement, ..self }
    }

    /// The same shape moved in the world.
    pub fn moved(&self, by: &DMat4) -> Source {
        let to_world = *by * self.placement.to_world;
        let placement = Placement { to_world, ..self.placement };
        Source { form: self.form.clone(), placement, flipped: self.flipped }
    }

    /// The names of what the file says of vertices and faces besides.
    pub fn attributes(&self) -> impl Iterator<Item = &str> {
        let mesh = if let Form::Mesh(mesh, _) = &self.form { Some(mesh) } else { None };
        mesh.into_iter().flat_map(|mesh| &mesh.attributes).map(|attribute| &*attribute.name)
    }

    /// How many primitives it becomes, at most.
    pub fn primitive_count(&self) -> usize {
        if let Form::Mesh(mesh, _) = &self.form { mesh.triangles.len() } else { 1 }
    }

    /// Whether the shape can be placed like that.
    ///
    /// # Errors
    /// Why not.
    pub fn check(&self) -> Result<(), &'static str> {
        let m = self.placement.to_world;
        let determinant = relative_determinant(&m).abs();
        // Written so that NaN is refused.
        if !(m.is_finite() && determinant >= 1e-12) {
            return Err("the transform flattens space");
        }
        let round = match self.form {
            Form::Sphere { .. } => self.round().is_even(true),
            Form::Cylinder { .. } => self.round().is_even(false),
            _ => true,
        };
        if round {
            return Ok(());
        }
        Err(if matches!(self.form, Form::Sphere { .. }) {
            "a sphere must be scaled evenly; ellipsoids are not supported (nearest: ply, obj)"
        } else {
            "a cylinder must be scaled evenly across its axis, without shearing (nearest: ply, obj)"
        })
    }

    /// From directions in the world to those of a round shape's own coordinates.
    pub fn to_local(&self) -> Mat3 {
        match self.form {
            Form::Sphere { .. } | Form::Cylinder { .. } => self.round().axes.inverse().as_mat3(),
            _ => Mat3::IDENTITY,
        }
    }

    /// A round shape in the world.
    fn round(&self) -> Round {
        let m = self.placement.to_world;
        let linear = DMat3::from_mat4(m);
        let (origin, axes) = match self.form {
            Form::Sphere { center, radius } => (center, linear * radius),
            Form::Cylinder { p0, p1, radius } => {
                let axis = p1 - p0;
                let [x, y] = across(axis.normalize());
                (p0, linear * DMat3::from_cols(radius * x, radius * y, axis))
            }
            _ => (DVec3::ZERO, linear),
        };
        Round { origin: m.transform_point3(origin), axes, flipped: self.flipped }
    }

    /// The corners of a box around the shape in the world.
    fn bounds(&self) -> [DVec3; 2] {
        let m = self.placement.to_world;
        match &self.form {
            Form::Mesh(mesh, _) => {
                let empty = [DVec3::INFINITY, DVec3::NEG_INFINITY];
                let positions = mesh.positions.iter().map(|p| m.transform_point3(*p));
                positions.fold(empty, |[min, max], p| [min.min(p), max.max(p)])
            }
            Form::Sphere { .. } => {
                let Round { origin, axes, .. } = self.round();
                let radius = axes.x_axis.length();
                [origin - radius, origin + radius]
            }
            Form::Cylinder { .. } => {
                let Round { origin, axes, .. } = self.round();
                let (top, radius) = (origin + axes.z_axis, axes.x_axis.length());
                [origin.min(top) - radius, origin.max(top) + radius]
            }
            Form::Disk => {
                let (center, reach) = (m.w_axis.truncate(), (m.x_axis.abs() + m.y_axis.abs()));
                [center - reach.truncate(), center + reach.truncate()]
            }
        }
    }

    /// The primitives, with `origin` as zero. `None` if coordinates or areas leave the range in which
    /// single precision can compute with them.
    pub fn geometry(&self, origin: DVec3) -> Option<Geometry> {
        let geometry = match &self.form {
            Form::Mesh(mesh, face_normals) => {
                let placed = mesh::place(mesh, &self.placement, *face_normals, origin);
                triangles(placed, mesh.attributes.iter().map(|attribute| attribute.name.clone()))
            }
            Form::Sphere { .. } => {
                let Round { origin: center, axes, flipped } = self.round();
                Geometry::of(Primitive::Sphere {
                    center: (center - origin).as_vec3(),
                    radius: axes.x_axis.length() as f32,
                    flipped,
                })
            }
            Form::Cylinder { .. } => {
                let Round { origin: base, axes, flipped } = self.round();
                Geometry::of(Primitive::Cylinder {
                    base: (base - origin).as_vec3(),
                    axis: axes.z_axis.as_vec3(),
                    radius: axes.x_axis.length() as f32,
                    flipped,
                })
            }
            Form::Disk => disk(&self.placement, origin),
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

/// A sphere or a cylinder in the world.
struct Round {
    /// The centre of the sphere, or of one end of the cylinder.
    origin: DVec3,
    /// Where the axes of its own coordinates go: for a sphere as long as the radius, for a cylinder the
    /// first two, and the third from end to end.
    axes: DMat3,
    /// Whether the normals point inwards.
    flipped: bool,
}

impl Round {
    /// Whether the axes are orthogonal, and the first two, or all of them, of the same length.
    fn is_even(&self, all: bool) -> bool {
        let DMat3 { x_axis: x, y_axis: y, z_axis: z } = self.axes;
        let scale = x.length();
        let uneven = [y.length() - scale, if all { z.length() - scale } else { 0.0 }];
        let skewed = [x.dot(y) / scale, y.dot(z) / z.length(), z.dot(x) / z.length()];
        uneven.iter().chain(&skewed).all(|e| e.abs() <= 1e-3 * scale)
    }
}

/// Two unit vectors across a unit vector, with which it makes a frame as in Mitsuba, so that textures on
/// cylinders lie alike.
fn across(n: DVec3) -> [DVec3; 2] {
    let n32 = n.as_vec3();
    let frame = Frame::around(Direction::from_vec(n32.into()));
    let axis = |v: aether_core::prelude::Vec3<f32>| glam::Vec3::from(v).as_dvec3();
    let x = axis(frame.to_world(glam::Vec3::X));
    let y = (n.cross(x)).normalize();
    [y.cross(n), y]
}

impl Geometry {
    /// A single primitive.
    fn of(primitive: Primitive) -> Geometry {
        Geometry { primitives: vec![primitive], ..Geometry::default() }
    }
}

fn triangles(placed: Triangles, names: impl Iterator<Item = String>) -> Geometry {
    let triangle = |[v0, v1, v2]: [glam::Vec3; 3]| Primitive::Triangle { v0, v1, v2 };
    Geometry {
        primitives: placed.vertices.into_iter().map(triangle).collect(),
        normals: placed.normals,
        texcoords: placed.texcoords,
        attributes: names.zip(placed.attributes).collect(),
        degenerate: placed.degenerate,
    }
}

/// The mesh of a file, and whether the file wants it flat.
fn read_mesh(kind: ShapeKind, query: &Query) -> Result<(Mesh, bool), SceneError> {
    let path = query.file()?;
    let bytes = read_bytes(&path)
        .map_err(|e| query.error_at("filename", format!("{}: {e}", path.display())))?;
    let mut number = None;
    let (mut mesh, flat) = match kind {
        ShapeKind::Obj => (obj::read(&bytes, &path)?, false),
        ShapeKind::Serialized => {
            let index = query.integer("shape_index", 0, i64::from(u32::MAX))?.unwrap_or(0);
            let read = serialized::read(&bytes, &path, index as usize)?;
            number = Some(index);
            read
        }
        _ => (ply::read(&bytes, &path)?, false),
    };
    if mesh.triangles.is_empty() {
        let error = SceneError::in_file(&path, "the mesh has no triangles");
        return Err(number.map_or(error.clone(), |index| error.about(format!("mesh {index}"))));
    }
    if mesh.texcoords.iter().any(|uv| uv.abs().max_element() > MAX_COORDINATE) {
        let message = format!("texture coordinates must be at most {MAX_COORDINATE:e}");
        return Err(SceneError::in_file(&path, message));
    }
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

    const IDENTITY: Placement =
        Placement { to_world: DMat4::IDENTITY, flip_normals: false, is_instance: false };

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
