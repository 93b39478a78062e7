//! What a scene is made of once it is loaded: flat lists of primitives, materials and emitters.

use std::f32::consts::PI;

use glam::{Mat3, Vec3, vec3};

use super::mesh::{double_area_normal, unit_normal};
use super::texture::Colour;

/// Index of a primitive in [`super::Scene::primitives`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct PrimitiveId(pub u32);

/// A piece of surface that rays can hit.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Primitive {
    /// A triangle. Its normal points to the side from which the corners run counter-clockwise.
    Triangle {
        /// First corner.
        v0: Vec3,
        /// Second corner.
        v1: Vec3,
        /// Third corner.
        v2: Vec3,
    },
    /// A sphere.
    Sphere {
        /// The centre.
        center: Vec3,
        /// The radius, positive.
        radius: f32,
        /// Whether the normals point to the centre.
        flipped: bool,
    },
    /// The side of a cylinder, open at both ends.
    Cylinder {
        /// The centre of one end.
        base: Vec3,
        /// From there to the centre of the other end.
        axis: Vec3,
        /// The radius, positive.
        radius: f32,
        /// Whether the normals point to the axis.
        flipped: bool,
    },
    /// An ellipse in a plane: all `center + a * u_axis + b * v_axis` with `a² + b² <= 1`.
    Disk {
        /// The centre.
        center: Vec3,
        /// The unit normal.
        normal: Vec3,
        /// Where the unit disk's x axis went; neither of unit length nor orthogonal to `v_axis`.
        u_axis: Vec3,
        /// Where the unit disk's y axis went.
        v_axis: Vec3,
    },
}

impl Primitive {
    /// Surface area.
    pub fn area(&self) -> f32 {
        match *self {
            Self::Triangle { v0, v1, v2 } => {
                (0.5 * double_area_normal(&[v0, v1, v2]).length()) as f32
            }
            Self::Sphere { radius, .. } => 4.0 * PI * radius * radius,
            Self::Cylinder { axis, radius, .. } => {
                (2.0 * std::f64::consts::PI * f64::from(radius) * axis.as_dvec3().length()) as f32
            }
            Self::Disk { u_axis, v_axis, .. } => {
                (u_axis.as_dvec3().cross(v_axis.as_dvec3()).length()) as f32 * PI
            }
        }
    }

    /// The unit normal at a point of the surface: outwards, or inwards if the shape is flipped.
    #[inline]
    pub fn normal(&self, point: Vec3) -> Vec3 {
        match *self {
            // Triangles of no area are left out when the scene is loaded.
            Self::Triangle { v0, v1, v2 } => unit_normal(&[v0, v1, v2]).unwrap_or(Vec3::Z),
            Self::Sphere { center, flipped, .. } => {
                let outwards = (point.as_dvec3() - center.as_dvec3()).normalize_or_zero();
                let outwards = outwards.as_vec3();
                if flipped { -outwards } else { outwards }
            }
            Self::Cylinder { base, axis, flipped, .. } => {
                let outwards = away_from_axis(point, base, axis);
                if flipped { -outwards } else { outwards }
            }
            Self::Disk { normal, .. } => normal,
        }
    }

    /// The axis-parallel box around it.
    #[inline]
    pub fn bounds(&self) -> Bounds {
        match *self {
            Self::Triangle { v0, v1, v2 } => {
                Bounds { min: v0.min(v1).min(v2), max: v0.max(v1).max(v2) }
            }
            Self::Sphere { center, radius, .. } => {
                Bounds { min: center - radius, max: center + radius }
            }
            Self::Cylinder { base, axis, radius, .. } => cylinder_bounds(base, axis, radius),
            Self::Disk { center, u_axis, v_axis, .. } => {
                let [x, y, z] = [0, 1, 2].map(|i| u_axis[i].hypot(v_axis[i]));
                Bounds { min: center - vec3(x, y, z), max: center + vec3(x, y, z) }
            }
        }
    }
}

// Out of the way of the code for triangles, which is inlined in many places.

/// The unit vector to a point from an axis.
#[inline(never)]
fn away_from_axis(point: Vec3, base: Vec3, axis: Vec3) -> Vec3 {
    let (p, axis) = (point.as_dvec3() - base.as_dvec3(), axis.as_dvec3());
    (p - p.dot(axis) / axis.length_squared() * axis).normalize_or_zero().as_vec3()
}

#[inline(never)]
fn cylinder_bounds(base: Vec3, axis: Vec3, radius: f32) -> Bounds {
    // How far the circle across the axis reaches along each coordinate.
    let d = axis.as_dvec3().normalize_or_zero();
    let reach = (1.0 - d * d).max(glam::DVec3::ZERO).map(f64::sqrt).as_vec3() * radius;
    let top = base + axis;
    Bounds { min: base.min(top) - reach, max: base.max(top) + reach }
}

/// An axis-parallel box.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bounds {
    /// The lower corner.
    pub min: Vec3,
    /// The upper corner.
    pub max: Vec3,
}

impl Bounds {
    /// The box around nothing.
    pub const EMPTY: Self = Self { min: Vec3::INFINITY, max: Vec3::NEG_INFINITY };

    /// The box around both.
    #[must_use]
    pub fn union(self, other: Self) -> Self {
        Self { min: self.min.min(other.min), max: self.max.max(other.max) }
    }
}

/// What a shape was in the file.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum ShapeKind {
    /// The square `[-1, 1]²` in the plane z = 0, facing +z.
    Rectangle,
    /// The cube `[-1, 1]³`.
    Cube,
    /// A sphere.
    Sphere,
    /// The unit disk in the plane z = 0, facing +z.
    Disk,
    /// The side of a cylinder, open at both ends.
    Cylinder,
    /// A Wavefront OBJ mesh.
    Obj,
    /// A Stanford PLY mesh.
    Ply,
    /// A mesh of a compressed file of Mitsuba's.
    Serialized,
}

impl ShapeKind {
    /// The plugin type.
    pub fn name(self) -> &'static str {
        match self {
            Self::Rectangle => "rectangle",
            Self::Cube => "cube",
            Self::Sphere => "sphere",
            Self::Disk => "disk",
            Self::Cylinder => "cylinder",
            Self::Obj => "obj",
            Self::Ply => "ply",
            Self::Serialized => "serialized",
        }
    }
}

/// A shape of the file; its primitives lie next to each other.
#[derive(Clone, Debug, PartialEq)]
pub struct Shape {
    /// The id in the file, or one made up from the kind and the position in the file.
    pub name: String,
    /// What it was in the file.
    pub kind: ShapeKind,
    /// Index in [`super::Scene::bsdfs`].
    pub bsdf: u32,
    /// The radiance that it emits from the side that the normal points to.
    pub emission: Option<Colour>,
    /// Its first primitive.
    pub first_primitive: u32,
    /// How many primitives it has.
    pub primitive_count: u32,
    /// Where its shading normals begin in [`super::Scene::normals`], if it has any.
    pub first_normals: Option<u32>,
    /// Where its texture coordinates begin in [`super::Scene::texcoords`], if it has any.
    pub first_texcoords: Option<u32>,
    /// From directions in the world to those of a sphere's or cylinder's own coordinates, in which a
    /// cylinder goes along z from 0 to 1.
    pub to_local: Mat3,
}

/// A rectangle: all `corner + p * a + q * b` with p and q in [0, 1], where `a` and `b` are orthogonal.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Rectangle {
    /// A corner.
    pub corner: Vec3,
    /// From there to one neighbour.
    pub a: Vec3,
    /// To the other; it turns counter-clockwise from `a` as the normal sees it.
    pub b: Vec3,
}

/// How much a rectangle that coordinates in single precision describe may be askew, in terms of its sides.
const ASKEW: f32 = 1e-5;

impl Rectangle {
    /// The rectangle that two triangles make, if they do. The corner is that of the first one.
    pub fn of(first: &Primitive, second: &Primitive) -> Option<Rectangle> {
        let (Primitive::Triangle { v0, v1, v2 }, Primitive::Triangle { v0: w0, v1: w1, v2: w2 }) =
            (*first, *second)
        else {
            return None;
        };
        let turns = |[a, b, c]: [Vec3; 3]| [[a, b, c], [b, c, a], [c, a, b]];
        // The diagonal runs from p to q in one triangle, and from q to p in the other.
        turns([v0, v1, v2]).into_iter().find_map(|[corner, p, q]| {
            let [opposite, ..] =
                turns([w0, w1, w2]).into_iter().find(|[_, s, t]| *s == q && *t == p)?;
            let (a, b) = (p - corner, q - corner);
            let askew = (corner + a + b - opposite).length();
            let is_right = a.dot(b).abs() <= ASKEW * a.length() * b.length();
            let is_closed = askew <= ASKEW * a.length().min(b.length());
            (is_right && is_closed).then_some(Rectangle { corner, a, b })
        })
    }

    /// Whether a point of it lies in the second of the triangles that it was made of.
    pub fn is_beyond_diagonal(&self, point: Vec3) -> bool {
        let p = point - self.corner;
        p.dot(self.a) / self.a.length_squared() + p.dot(self.b) / self.b.length_squared() > 1.0
    }
}

/// An emissive primitive, or two that make a rectangle. It emits from the side that its normal points to.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Emitter {
    /// Index in [`super::Scene::primitives`], of a rectangle the first of two that follow each other.
    pub primitive: u32,
    /// How many primitives it is: two are a rectangle.
    pub count: u32,
    /// Emitted radiance in linear Rec. 709, the same in all directions; of a texture its mean.
    pub radiance: Vec3,
    /// Index in [`super::Scene::textures`] of what it emits, if that is not the same everywhere.
    pub texture: Option<u32>,
    /// Surface area.
    pub area: f32,
}

impl Emitter {
    /// The primitives of it.
    pub fn primitives(&self) -> std::ops::Range<u32> {
        self.primitive..self.primitive + self.count
    }

    /// Emitted power: `π · area · radiance`, as if all of a texture were on it.
    pub fn power(&self) -> Vec3 {
        self.radiance * (PI * self.area)
    }
}
