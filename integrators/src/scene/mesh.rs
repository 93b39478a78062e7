//! Triangle meshes between their file and the scene.

use glam::{DMat3, DMat4, DVec2, DVec3, Vec2, Vec3};

use super::values::relative_determinant;

/// Marks a corner without a normal or texture coordinates.
pub const NONE: u32 = u32::MAX;

/// A corner of a polygon, by indices into the lists of a mesh; [`NONE`] for what it does not have.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Corner {
    /// Its position.
    pub vertex: u32,
    /// Its normal.
    pub normal: u32,
    /// Its texture coordinates.
    pub texcoord: u32,
}

impl Corner {
    /// A corner that has a position and nothing else.
    pub fn plain(vertex: u32) -> Self {
        Corner { vertex, normal: NONE, texcoord: NONE }
    }
}

/// What a file says of each vertex or face beside position, normal and texture coordinates.
#[derive(Clone, Debug, PartialEq)]
pub struct Attribute {
    /// Its name, with `vertex_` or `face_` before it.
    pub name: String,
    /// Whether there is a value for each triangle, and not for each position.
    pub of_faces: bool,
    /// The values; single numbers three times.
    pub values: Vec<Vec3>,
}

impl Attribute {
    /// The values at the corners of a triangle.
    fn corners(&self, index: usize, triangle: [u32; 3]) -> [Vec3; 3] {
        let at = |k: usize| self.values.get(k).copied().unwrap_or_default();
        if self.of_faces { [at(index); 3] } else { triangle.map(|corner| at(corner as usize)) }
    }
}

/// A mesh as its file describes it.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Mesh {
    /// Vertex positions.
    pub positions: Vec<DVec3>,
    /// Vertex normals, of any length.
    pub normals: Vec<DVec3>,
    /// Texture coordinates.
    pub texcoords: Vec<DVec2>,
    /// Indices into `positions`.
    pub triangles: Vec<[u32; 3]>,
    /// Indices into `normals` or [`NONE`]; empty if the file has no normals.
    pub normal_triangles: Vec<[u32; 3]>,
    /// Indices into `texcoords` or [`NONE`]; empty if the file has no texture coordinates.
    pub texcoord_triangles: Vec<[u32; 3]>,
    /// What else the file says of vertices and faces.
    pub attributes: Vec<Attribute>,
}

impl Mesh {
    /// Adds a polygon as a fan around its first corner.
    pub fn push_polygon(&mut self, corners: &[Corner]) {
        for i in 1..corners.len().saturating_sub(1) {
            let fan = [corners[0], corners[i], corners[i + 1]];
            self.triangles.push(fan.map(|corner| corner.vertex));
            self.normal_triangles.push(fan.map(|corner| corner.normal));
            self.texcoord_triangles.push(fan.map(|corner| corner.texcoord));
        }
    }

    /// Forgets the indices of what the file does not have.
    pub fn drop_unused(&mut self) {
        if self.normals.is_empty() {
            self.normal_triangles.clear();
        }
        if self.texcoords.is_empty() {
            self.texcoord_triangles.clear();
        }
    }
}

/// How a shape is placed in the world.
#[derive(Clone, Copy, Debug)]
pub struct Placement {
    /// From the shape's own coordinates to the world.
    pub to_world: DMat4,
    /// Turn the surface inside out.
    pub flip_normals: bool,
    /// Whether this moves a surface that had its normals before: between the corners they are then those of
    /// before, moved, and at the corners not of unit length.
    pub is_instance: bool,
}

impl Placement {
    /// Maps normals: the inverse transpose, up to a positive factor, negated by `flip_normals`.
    ///
    /// So a mirror image keeps its outside outside, as in Mitsuba after 3.9 (3.9 itself then
    /// contradicts itself: geometric and shading normal differ in sign).
    pub fn normal_matrix(&self) -> DMat3 {
        let [x, y, z] = [self.to_world.x_axis, self.to_world.y_axis, self.to_world.z_axis]
            .map(|column| column.truncate());
        let sign = relative_determinant(&self.to_world).signum();
        let sign = if self.flip_normals { -sign } else { sign };
        DMat3::from_cols(y.cross(z), z.cross(x), x.cross(y)) * sign
    }

    /// Whether the winding of triangles has to be reversed for their normals to come out as
    /// [`Placement::normal_matrix`] says.
    pub fn reverses_winding(&self) -> bool {
        (relative_determinant(&self.to_world) < 0.0) != self.flip_normals
    }
}

/// The triangles of a mesh in the world.
#[derive(Debug, Default)]
pub struct Triangles {
    /// The corners; counter-clockwise seen from the outside.
    pub vertices: Vec<[Vec3; 3]>,
    /// Shading normals at the corners, of unit length but for instances; empty if the mesh is flat.
    pub normals: Vec<[Vec3; 3]>,
    /// Texture coordinates at the corners; empty if they are [`DEFAULT_TEXCOORDS`] everywhere.
    pub texcoords: Vec<[Vec2; 3]>,
    /// For each attribute of the mesh its values at the corners.
    pub attributes: Vec<Vec<[Vec3; 3]>>,
    /// Number of triangles left out because they have no area.
    pub degenerate: usize,
}

/// Texture coordinates at the corners, in the order of the file, of a triangle that has none: as in Mitsuba, the
/// weights of the second and the third corner.
pub const DEFAULT_TEXCOORDS: [Vec2; 3] = [Vec2::ZERO, Vec2::X, Vec2::Y];

impl Triangles {
    /// Gives the last triangle the texture coordinates of one without any. They are written down from the first one on
    /// whose corners are not in the order of the file, where the default of the new order would be another.
    fn push_default_texcoords(&mut self, is_reversed: bool) {
        if is_reversed && self.texcoords.is_empty() {
            self.texcoords = vec![DEFAULT_TEXCOORDS; self.vertices.len() - 1];
        }
        if is_reversed || !self.texcoords.is_empty() {
            self.texcoords.push(outside_first(DEFAULT_TEXCOORDS, is_reversed));
        }
    }
}

/// The triangles of a mesh placed in the world, with `origin` as zero. Unless `face_normals` is
/// set, a mesh that brings no normals gets smooth ones, as in Mitsuba.
pub fn place(mesh: &Mesh, placement: &Placement, face_normals: bool, origin: DVec3) -> Triangles {
    let in_world = |p: &DVec3| placement.to_world.transform_point3(*p) - origin;
    let positions: Vec<DVec3> = mesh.positions.iter().map(in_world).collect();
    let reverse = placement.reverses_winding();
    let orient = |t: [u32; 3]| if reverse { [t[0], t[2], t[1]] } else { t };
    let triangles: Vec<[u32; 3]> = mesh.triangles.iter().copied().map(orient).collect();

    let (normals, indices) = if face_normals {
        (Vec::new(), Vec::new())
    } else if mesh.normals.is_empty() {
        (smooth_normals(&positions, &triangles), triangles.clone())
    } else {
        let matrix = placement.normal_matrix();
        // The same factor for all keeps what is interpolated.
        let size = [matrix.x_axis, matrix.y_axis, matrix.z_axis].map(|axis| axis.length());
        let matrix = matrix * (1.0 / size.into_iter().fold(f64::MIN_POSITIVE, f64::max));
        let unit = |n: DVec3| if placement.is_instance { n } else { n.normalize_or_zero() };
        let normals = mesh.normals.iter().map(|n| unit(matrix * *n)).collect();
        let indices = mesh.normal_triangles.iter().copied().map(orient);
        (normals, indices.collect())
    };

    let texcoords: Vec<[u32; 3]> = mesh.texcoord_triangles.iter().copied().map(orient).collect();
    let attributes = vec![Vec::new(); mesh.attributes.len()];
    let mut result = Triangles { attributes, ..Triangles::default() };
    for (index, triangle) in triangles.iter().enumerate() {
        let vertices = triangle.map(|v| positions[v as usize].as_vec3());
        let Some(flat) = unit_normal(&vertices) else {
            result.degenerate += 1;
            continue;
        };
        let normal = |corner: u32| normals.get(corner as usize).map_or(Vec3::ZERO, |n| n.as_vec3());
        let corner_normals = indices.get(index).map(|corners| corners.map(normal));
        // Where a file's normals contradict the order of the corners, they say what is outside, as in Mitsuba.
        let turned =
            corner_normals.is_some_and(|corners| corners.iter().sum::<Vec3>().dot(flat) < 0.0);
        let flat = if turned { -flat } else { flat };
        result.vertices.push(outside_first(vertices, turned));
        if let Some(corners) = corner_normals {
            let usable = |n: Vec3| if n == Vec3::ZERO { flat } else { n };
            result.normals.push(outside_first(corners.map(usable), turned));
        }
        if let Some(corners) = texcoords.get(index) {
            let at = |corner: u32| mesh.texcoords.get(corner as usize).copied().unwrap_or_default();
            let corners = corners.map(|corner| at(corner).as_vec2());
            result.texcoords.push(outside_first(corners, turned));
        } else {
            result.push_default_texcoords(reverse != turned);
        }
        for (attribute, values) in mesh.attributes.iter().zip(&mut result.attributes) {
            values.push(outside_first(attribute.corners(index, *triangle), turned));
        }
    }
    result
}

/// What the corners of a triangle have, in the other order if it is to be turned inside out.
fn outside_first<T: Copy>([a, b, c]: [T; 3], turned: bool) -> [T; 3] {
    if turned { [a, c, b] } else { [a, b, c] }
}

/// The same mesh already in its place, with the unit normals that it has there: what an instance moves is
/// the surface with its normals.
pub fn settled(mesh: &Mesh, placement: &Placement) -> Mesh {
    let reverse = placement.reverses_winding();
    let orient = |t: &[u32; 3]| if reverse { [t[0], t[2], t[1]] } else { *t };
    let in_world = |p: &DVec3| placement.to_world.transform_point3(*p);
    let positions: Vec<DVec3> = mesh.positions.iter().map(in_world).collect();
    let triangles: Vec<[u32; 3]> = mesh.triangles.iter().map(orient).collect();
    let (normals, normal_triangles) = if mesh.normals.is_empty() {
        (smooth_normals(&positions, &triangles), triangles.clone())
    } else {
        let matrix = placement.normal_matrix();
        let normals = mesh.normals.iter().map(|n| (matrix * *n).normalize_or_zero());
        (normals.collect(), mesh.normal_triangles.iter().map(orient).collect())
    };
    let (texcoords, texcoord_triangles) = if reverse && mesh.texcoord_triangles.is_empty() {
        // What corners have without any depends on their order, which is no longer that of the file.
        let default = DEFAULT_TEXCOORDS.map(|uv| uv.as_dvec2()).to_vec();
        (default, vec![orient(&[0, 1, 2]); triangles.len()])
    } else {
        let corners = mesh.texcoord_triangles.iter().map(orient).collect();
        (mesh.texcoords.clone(), corners)
    };
    let attributes = mesh.attributes.clone();
    Mesh {
        positions,
        normals,
        texcoords,
        triangles,
        normal_triangles,
        texcoord_triangles,
        attributes,
    }
}

/// The unit normal of a triangle whose corners run counter-clockwise; none if it has no area in
/// f32.
pub fn unit_normal(vertices: &[Vec3; 3]) -> Option<Vec3> {
    let normal = double_area_normal(vertices);
    ((0.5 * normal.length()) as f32 >= f32::MIN_POSITIVE).then(|| normal.normalize().as_vec3())
}

/// The normal of a triangle with the length of twice its area.
pub fn double_area_normal(vertices: &[Vec3; 3]) -> DVec3 {
    let [a, b, c] = vertices.map(Vec3::as_dvec3);
    (b - a).cross(c - a)
}

/// The weights of the corners at a point of a triangle.
pub fn barycentric(vertices: &[Vec3; 3], point: Vec3) -> Vec3 {
    let [a, b, c] = vertices.map(|v| v.as_dvec3() - point.as_dvec3());
    let normal = double_area_normal(vertices);
    let weight = |p: DVec3, q: DVec3| p.cross(q).dot(normal);
    (DVec3::new(weight(b, c), weight(c, a), weight(a, b)) / normal.length_squared()).as_vec3()
}

/// Vertex normals as sums of the face normals around, weighted by the angle at the vertex
/// (Thürmer and Wüthrich, "Computing Vertex Normals from Polygonal Facets", 1998).
fn smooth_normals(positions: &[DVec3], triangles: &[[u32; 3]]) -> Vec<DVec3> {
    let mut sums = vec![DVec3::ZERO; positions.len()];
    for triangle in triangles {
        let p = triangle.map(|v| positions[v as usize]);
        let Some(normal) = (p[1] - p[0]).cross(p[2] - p[0]).try_normalize() else {
            continue;
        };
        for corner in 0..3 {
            let a = p[(corner + 1) % 3] - p[corner];
            let b = p[(corner + 2) % 3] - p[corner];
            let angle = a.cross(b).length().atan2(a.dot(b));
            sums[triangle[corner] as usize] += normal * angle;
        }
    }
    sums.into_iter().map(DVec3::normalize_or_zero).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn quad() -> Mesh {
        let mut mesh = Mesh {
            positions: [[0., 0., 0.], [1., 0., 0.], [1., 1., 0.], [0., 1., 1.]]
                .map(DVec3::from_array)
                .to_vec(),
            ..Mesh::default()
        };
        mesh.push_polygon(&[0, 1, 2, 3].map(Corner::plain));
        mesh
    }

    fn placement(to_world: DMat4, flip_normals: bool) -> Placement {
        Placement { to_world, flip_normals, is_instance: false }
    }

    fn place(mesh: &Mesh, placement: &Placement, face_normals: bool) -> Triangles {
        super::place(mesh, placement, face_normals, DVec3::ZERO)
    }

    #[test]
    fn smooth_normals_agree_with_mitsuba() {
        // From `mi.load_dict({'type': 'obj', ...})` on the same bent quad.
        let t = place(&quad(), &placement(DMat4::IDENTITY, false), false);
        assert_eq!(t.vertices.len(), 2);
        let expected = Vec3::new(0.370_483, -0.370_483, 0.851_754);
        assert!((t.normals[0][0] - expected).length() < 1e-6);
        assert!((t.normals[0][1] - Vec3::Z).length() < 1e-6);
        assert!((t.normals[1][2] - Vec3::new(1., -1., 1.).normalize()).length() < 1e-6);
    }

    #[test]
    fn mirrors_keep_the_outside_and_flips_turn_it() {
        let mirror = DMat4::from_scale(DVec3::new(-1.0, 1.0, 1.0));
        let mesh = quad();
        for (to_world, flip, sign) in [
            (DMat4::IDENTITY, false, 1.0),
            (DMat4::IDENTITY, true, -1.0),
            (mirror, false, 1.0),
            (mirror, true, -1.0),
        ] {
            let p = placement(to_world, flip);
            let t = place(&mesh, &p, true);
            assert!(t.normals.is_empty());
            let n = unit_normal(&t.vertices[0]).unwrap();
            assert_eq!(n, Vec3::Z * sign);
            assert_eq!((p.normal_matrix() * DVec3::Z).as_vec3(), n);
        }
    }

    #[test]
    fn normals_of_the_file_say_what_is_outside() {
        let mut mesh = quad();
        mesh.normals = vec![DVec3::new(0.0, 0.1, -1.0)];
        mesh.texcoords = (0..4).map(|k| DVec2::new(f64::from(k), 0.0)).collect();
        let corner = |k: u32| Corner { vertex: k, normal: 0, texcoord: k };
        (mesh.triangles, mesh.normal_triangles) = (Vec::new(), Vec::new());
        mesh.texcoord_triangles.clear();
        mesh.push_polygon(&[0, 1, 2].map(corner));
        let t = place(&mesh, &placement(DMat4::IDENTITY, false), false);
        assert_eq!(unit_normal(&t.vertices[0]), Some(-Vec3::Z));
        assert!(t.normals[0].iter().all(|n| n.z < 0.0));
        // Texture coordinates stay with their corners.
        assert_eq!(t.vertices[0][1], Vec3::new(1.0, 1.0, 0.0));
        assert_eq!(t.texcoords[0].map(|uv| uv.x), [0.0, 2.0, 1.0]);
        // Without them the order of the corners does.
        let t = place(&mesh, &placement(DMat4::IDENTITY, false), true);
        assert_eq!(unit_normal(&t.vertices[0]), Some(Vec3::Z));
    }

    /// The texture coordinates at the corner of a triangle that lies at a place.
    fn texcoord_at(t: &Triangles, triangle: usize, place: Vec3) -> Vec2 {
        let corner = t.vertices[triangle].iter().position(|v| *v == place).expect("a corner");
        t.texcoords.get(triangle).unwrap_or(&DEFAULT_TEXCOORDS)[corner]
    }

    #[test]
    fn corners_without_texture_coordinates_keep_those_of_their_order_in_the_file() {
        let mirror = DMat4::from_scale(DVec3::new(-1.0, 1.0, 1.0));
        let corners =
            [[0., 0., 0.], [1., 0., 0.], [1., 1., 0.], [0., 1., 1.]].map(Vec3::from_array);
        let expected = [(0, 0, Vec2::ZERO), (0, 1, Vec2::X), (0, 2, Vec2::Y), (1, 3, Vec2::Y)];
        let mut plain = quad();
        plain.drop_unused();
        let (normals, normal_triangles) = (vec![DVec3::NEG_Z], vec![[0; 3]; 2]);
        let contradicting = Mesh { normals, normal_triangles, ..plain.clone() };
        // Nothing is stored where nothing is turned.
        assert!(place(&plain, &placement(DMat4::IDENTITY, false), false).texcoords.is_empty());
        for mesh in [plain, contradicting] {
            for (to_world, flip) in
                [(DMat4::IDENTITY, false), (DMat4::IDENTITY, true), (mirror, false), (mirror, true)]
            {
                let p = placement(to_world, flip);
                let instance =
                    Placement { to_world: mirror, flip_normals: false, is_instance: true };
                let moved = super::place(&settled(&mesh, &p), &instance, false, DVec3::ZERO);
                for (triangle, corner, uv) in expected {
                    let at = to_world.transform_point3(corners[corner].as_dvec3());
                    let there = mirror.transform_point3(at).as_vec3();
                    for face_normals in [true, false] {
                        let t = place(&mesh, &p, face_normals);
                        assert_eq!(
                            texcoord_at(&t, triangle, at.as_vec3()),
                            uv,
                            "{to_world} {flip}"
                        );
                    }
                    assert_eq!(texcoord_at(&moved, triangle, there), uv, "{to_world} {flip}");
                }
            }
        }
    }

    #[test]
    fn triangles_without_area_are_counted() {
        let mut mesh = quad();
        mesh.push_polygon(&[0, 1, 1].map(Corner::plain));
        mesh.push_polygon(&[0, 1].map(Corner::plain));
        let t = place(&mesh, &placement(DMat4::IDENTITY, false), true);
        assert_eq!((t.vertices.len(), t.degenerate), (2, 1));
    }
}
