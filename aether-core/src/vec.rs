//! Small vectors and matrices over any [`Real`], with free conversions to glam.

use core::ops::{
    Add, AddAssign, Div, DivAssign, Index, IndexMut, Mul, MulAssign, Neg, Sub, SubAssign,
};

use crate::point::Direction;
use crate::real::{Real, Scalar};

macro_rules! vector {
    ($(#[$doc:meta])* $name:ident, $n:literal, $($field:ident $i:literal),*) => {
        $(#[$doc])*
        #[derive(Clone, Copy, Debug, Default, PartialEq)]
        pub struct $name<R = f64> {
            $(#[doc = concat!("Coordinate ", stringify!($i), ".")] pub $field: R,)*
        }
        impl<R: Real> $name<R> {
            /// The zero vector.
            pub const ZERO: Self = $name { $($field: R::ZERO),* };
            /// A vector from its coordinates.
            #[inline(always)]
            pub const fn new($($field: R),*) -> Self { $name { $($field),* } }
            /// All coordinates equal to `value`.
            #[inline(always)]
            pub const fn splat(value: R) -> Self { $name { $($field: value),* } }
            /// The coordinates in order.
            #[inline(always)]
            pub const fn to_array(self) -> [R; $n] { [$(self.$field),*] }
            /// A vector from an array of coordinates.
            #[inline(always)]
            pub const fn from_array(c: [R; $n]) -> Self { $name { $($field: c[$i]),* } }
            /// Scalar product.
            #[inline(always)]
            pub fn dot(self, other: impl Into<Self>) -> R {
                let other = other.into();
                let products = [$(self.$field * other.$field),*];
                let mut sum = products[0];
                for p in &products[1..] { sum += *p; }
                sum
            }
            /// Euclidean length.
            #[inline(always)]
            pub fn length(self) -> R { self.dot(self).sqrt() }
            /// Squared Euclidean length.
            #[inline(always)]
            pub fn length_squared(self) -> R { self.dot(self) }
            /// The vector of length one in this direction.
            #[inline(always)]
            pub fn normalize(self) -> Self { self / self.length() }
            /// Euclidean length of the difference.
            #[inline(always)]
            pub fn distance(self, other: impl Into<Self>) -> R {
                self.distance_squared(other).sqrt()
            }
            /// Squared Euclidean length of the difference.
            #[inline(always)]
            pub fn distance_squared(self, other: impl Into<Self>) -> R {
                let other: Self = other.into();
                (self - other).length_squared()
            }
            /// Between this and `other`, which is reached at `t` = 1.
            #[inline(always)]
            pub fn lerp(self, other: impl Into<Self>, t: R) -> Self {
                let other: Self = other.into();
                self * (R::ONE - t) + other * t
            }
        }
        impl<R: Real> AddAssign for $name<R> {
            #[inline(always)]
            fn add_assign(&mut self, o: Self) { *self = *self + o; }
        }
        impl<R: Real> SubAssign for $name<R> {
            #[inline(always)]
            fn sub_assign(&mut self, o: Self) { *self = *self - o; }
        }
        impl<R: Real> MulAssign<R> for $name<R> {
            #[inline(always)]
            fn mul_assign(&mut self, k: R) { *self = *self * k; }
        }
        impl<R: Real> DivAssign<R> for $name<R> {
            #[inline(always)]
            fn div_assign(&mut self, k: R) { *self = *self / k; }
        }
        impl<R: Real> IndexMut<usize> for $name<R> {
            fn index_mut(&mut self, i: usize) -> &mut R {
                match i { $($i => &mut self.$field,)* _ => panic!("a {} has {} coordinates, not {}", stringify!($name), $n, i + 1) }
            }
        }
        impl<R: Real> Add for $name<R> {
            type Output = Self;
            #[inline(always)]
            fn add(self, o: Self) -> Self { $name { $($field: self.$field + o.$field),* } }
        }
        impl<R: Real> Sub for $name<R> {
            type Output = Self;
            #[inline(always)]
            fn sub(self, o: Self) -> Self { $name { $($field: self.$field - o.$field),* } }
        }
        impl<R: Real> Neg for $name<R> {
            type Output = Self;
            #[inline(always)]
            fn neg(self) -> Self { $name { $($field: -self.$field),* } }
        }
        impl<R: Real> Mul<R> for $name<R> {
            type Output = Self;
            #[inline(always)]
            fn mul(self, k: R) -> Self { $name { $($field: self.$field * k),* } }
        }
        impl Mul<$name<f64>> for f64 {
            type Output = $name<f64>;
            #[inline(always)]
            fn mul(self, v: $name<f64>) -> $name<f64> { v * self }
        }
        impl Mul<$name<f32>> for f32 {
            type Output = $name<f32>;
            #[inline(always)]
            fn mul(self, v: $name<f32>) -> $name<f32> { v * self }
        }
        impl<R: Real> Div<R> for $name<R> {
            type Output = Self;
            #[inline(always)]
            fn div(self, k: R) -> Self { $name { $($field: self.$field / k),* } }
        }
        impl<R: Real> Index<usize> for $name<R> {
            type Output = R;
            fn index(&self, i: usize) -> &R {
                match i { $($i => &self.$field,)* _ => panic!("a {} has {} coordinates, not {}", stringify!($name), $n, i + 1) }
            }
        }
    };
}

vector!(
    /// A vector of the plane.
    Vec2, 2, x 0, y 1);
vector!(
    /// A vector of space.
    Vec3, 3, x 0, y 1, z 2);

impl<R: Real> Vec2<R> {
    /// The x axis.
    pub const X: Self = Vec2::new(R::ONE, R::ZERO);
    /// The y axis.
    pub const Y: Self = Vec2::new(R::ZERO, R::ONE);
}

impl<R: Real> Vec3<R> {
    /// The x axis.
    pub const X: Self = Vec3::new(R::ONE, R::ZERO, R::ZERO);
    /// The y axis.
    pub const Y: Self = Vec3::new(R::ZERO, R::ONE, R::ZERO);
    /// The z axis.
    pub const Z: Self = Vec3::new(R::ZERO, R::ZERO, R::ONE);
    /// Vector product.
    #[inline(always)]
    pub fn cross(self, other: impl Into<Self>) -> Self {
        let o = other.into();
        Vec3::new(
            self.y * o.z - self.z * o.y,
            self.z * o.x - self.x * o.z,
            self.x * o.y - self.y * o.x,
        )
    }
}

/// A 3×3 matrix, stored by columns; also a frame whose columns are its axes.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Mat3<R = f64> {
    /// First column: the image of the x axis.
    pub x: Vec3<R>,
    /// Second column: the image of the y axis.
    pub y: Vec3<R>,
    /// Third column: the image of the z axis.
    pub z: Vec3<R>,
}

impl<R: Real> Mat3<R> {
    /// The matrix with these columns.
    #[inline(always)]
    pub const fn from_cols(x: Vec3<R>, y: Vec3<R>, z: Vec3<R>) -> Self {
        Mat3 { x, y, z }
    }

    /// The diagonal matrix.
    pub fn diagonal(d: Vec3<R>) -> Self {
        let o = R::ZERO;
        Mat3::from_cols(Vec3::new(d.x, o, o), Vec3::new(o, d.y, o), Vec3::new(o, o, d.z))
    }

    /// The rows become columns; for a frame this is the inverse.
    #[inline(always)]
    pub fn transpose(self) -> Self {
        Mat3::from_cols(
            Vec3::new(self.x.x, self.y.x, self.z.x),
            Vec3::new(self.x.y, self.y.y, self.z.y),
            Vec3::new(self.x.z, self.y.z, self.z.z),
        )
    }
}

/// An orthonormal matrix: its columns are the axes of a local frame, its transpose its inverse.
///
/// Orthonormality is guaranteed by the type, and the compiler of maps makes use of it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Frame<R = f64>(Mat3<R>);

impl<R: Real> Frame<R> {
    /// A frame whose third axis is the direction `n`, continuous except at n = (0, 0, -1) (Duff et
    /// al. 2017, "Building an Orthonormal Basis, Revisited").
    #[inline(always)]
    pub fn around(n: Direction<R>) -> Self {
        let n = n.vec();
        let sign = R::ONE.copysign(n.z);
        let a = -R::ONE / (sign + n.z);
        let b = n.x * n.y * a;
        Frame(Mat3::from_cols(
            Vec3::new(R::ONE + sign * n.x * n.x * a, sign * b, -sign * n.x),
            Vec3::new(b, sign + n.y * n.y * a, -n.y),
            n,
        ))
    }

    /// The matrix.
    #[inline(always)]
    pub fn mat(self) -> Mat3<R> {
        self.0
    }

    /// A vector given in the frame, in world coordinates.
    #[inline(always)]
    pub fn to_world(self, v: impl Into<Vec3<R>>) -> Vec3<R> {
        self.0 * v.into()
    }

    /// A vector given in world coordinates, in the frame.
    #[inline(always)]
    pub fn to_local(self, v: impl Into<Vec3<R>>) -> Vec3<R> {
        self.0.transpose() * v.into()
    }

    /// A frame from axes that are known to be orthonormal; emitted code uses it.
    #[inline(always)]
    pub fn from_unit_axes(x: Vec3<R>, y: Vec3<R>, z: Vec3<R>) -> Self {
        Frame(Mat3::from_cols(x, y, z))
    }
}

impl<R: Scalar> Frame<R> {
    /// A frame from its axes, if they are orthonormal to within rounding.
    pub fn try_from_axes(x: Vec3<R>, y: Vec3<R>, z: Vec3<R>) -> Option<Self> {
        let near = |a: R, b: R| (a - b).abs() <= R::of(32.0) * R::EPSILON;
        let unit = [x, y, z].iter().all(|v| near(v.length_squared(), R::ONE));
        let right = near(x.dot(y), R::ZERO) && near(y.dot(z), R::ZERO) && near(z.dot(x), R::ZERO);
        (unit && right).then_some(Frame(Mat3::from_cols(x, y, z)))
    }
}

impl<R> core::ops::Deref for Frame<R> {
    type Target = Mat3<R>;
    #[inline(always)]
    fn deref(&self) -> &Mat3<R> {
        &self.0
    }
}

impl<R: Real> Mul<Vec3<R>> for Frame<R> {
    type Output = Vec3<R>;
    #[inline(always)]
    fn mul(self, v: Vec3<R>) -> Vec3<R> {
        self.0 * v
    }
}

macro_rules! times_direction {
    ($($left:ty),*) => {
        $(impl<R: Real> Mul<Direction<R>> for $left {
            type Output = Vec3<R>;
            #[inline(always)]
            fn mul(self, w: Direction<R>) -> Vec3<R> { self * w.vec() }
        })*
    };
}
times_direction! { Mat3<R>, Frame<R> }

impl<R: Real> From<Direction<R>> for Vec3<R> {
    #[inline(always)]
    fn from(w: Direction<R>) -> Self {
        w.vec()
    }
}
impl<R: Real> Add<Direction<R>> for Vec3<R> {
    type Output = Self;
    #[inline(always)]
    fn add(self, w: Direction<R>) -> Self {
        self + w.vec()
    }
}
impl<R: Real> Sub<Direction<R>> for Vec3<R> {
    type Output = Self;
    #[inline(always)]
    fn sub(self, w: Direction<R>) -> Self {
        self - w.vec()
    }
}

macro_rules! direction_and {
    ($($right:ty),*) => {
        $(impl<R: Real> Add<$right> for Direction<R> {
            type Output = Vec3<R>;
            #[inline(always)]
            fn add(self, w: $right) -> Vec3<R> { self.vec() + w }
        }
        impl<R: Real> Sub<$right> for Direction<R> {
            type Output = Vec3<R>;
            #[inline(always)]
            fn sub(self, w: $right) -> Vec3<R> { self.vec() - w }
        })*
    };
}
direction_and! { Vec3<R>, Direction<R> }

impl<R: Real> Neg for Direction<R> {
    type Output = Self;
    #[inline(always)]
    fn neg(self) -> Self {
        Direction::from_unit(-self.vec())
    }
}

impl Mul<Direction<f64>> for f64 {
    type Output = Vec3<f64>;
    #[inline(always)]
    fn mul(self, w: Direction<f64>) -> Vec3<f64> {
        w.vec() * self
    }
}
impl Mul<Direction<f32>> for f32 {
    type Output = Vec3<f32>;
    #[inline(always)]
    fn mul(self, w: Direction<f32>) -> Vec3<f32> {
        w.vec() * self
    }
}
impl<R: Real> Mul<R> for Direction<R> {
    type Output = Vec3<R>;
    #[inline(always)]
    fn mul(self, k: R) -> Vec3<R> {
        self.vec() * k
    }
}

impl<R: Real> Div<R> for Direction<R> {
    type Output = Vec3<R>;
    #[inline(always)]
    fn div(self, k: R) -> Vec3<R> {
        self.vec() / k
    }
}

impl<R: Real> Mul<Vec3<R>> for Mat3<R> {
    type Output = Vec3<R>;
    #[inline(always)]
    fn mul(self, v: Vec3<R>) -> Vec3<R> {
        self.x * v.x + self.y * v.y + self.z * v.z
    }
}

macro_rules! glam {
    ($($ours:ident<$r:ident> $theirs:ident;)*) => {
        $(impl From<glam::$theirs> for $ours<$r> {
            #[inline(always)]
            fn from(v: glam::$theirs) -> Self { Self::from_array(v.to_array()) }
        }
        impl From<$ours<$r>> for glam::$theirs {
            #[inline(always)]
            fn from(v: $ours<$r>) -> Self { Self::from_array(v.to_array()) }
        })*
    };
}
glam! { Vec2<f32> Vec2; Vec3<f32> Vec3; Vec2<f64> DVec2; Vec3<f64> DVec3; }

impl From<glam::Mat3> for Mat3<f32> {
    fn from(m: glam::Mat3) -> Self {
        Mat3::from_cols(m.x_axis.into(), m.y_axis.into(), m.z_axis.into())
    }
}
impl From<Mat3<f32>> for glam::Mat3 {
    fn from(m: Mat3<f32>) -> Self {
        glam::Mat3::from_cols(m.x.into(), m.y.into(), m.z.into())
    }
}
