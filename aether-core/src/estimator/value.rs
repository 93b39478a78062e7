//! What can be estimated.

use crate::real::Scalar;

/// The value of an integrand: a number or a spectrum, with componentwise products.
pub trait Value<R>: Copy {
    /// Nothing.
    fn zero() -> Self;
    /// The neutral element of [`Value::multiply`].
    fn one() -> Self;
    /// The sum.
    fn plus(self, other: Self) -> Self;
    /// The componentwise product.
    fn multiply(self, other: Self) -> Self;
    /// Scaled by a number.
    fn times(self, factor: R) -> Self;
    /// Divided by a number.
    fn over(self, divisor: R) -> Self;
    /// Whether every component is zero.
    fn is_zero(&self) -> bool;
}

macro_rules! values {
    ($($t:ty, $r:ty, $zero:expr, $one:expr;)*) => {
        $(impl Value<$r> for $t {
            #[inline]
            fn zero() -> Self { $zero }
            #[inline]
            fn one() -> Self { $one }
            #[inline]
            fn plus(self, other: Self) -> Self { self + other }
            #[inline]
            fn multiply(self, other: Self) -> Self { self * other }
            #[inline]
            fn times(self, factor: $r) -> Self { self * factor }
            #[inline]
            fn over(self, divisor: $r) -> Self { self / divisor }
            #[inline]
            fn is_zero(&self) -> bool { *self == $zero }
        })*
    };
}
values! {
    f32, f32, 0.0, 1.0;
    f64, f64, 0.0, 1.0;
    glam::Vec3, f32, glam::Vec3::ZERO, glam::Vec3::ONE;
    glam::Vec3A, f32, glam::Vec3A::ZERO, glam::Vec3A::ONE;
    glam::DVec3, f64, glam::DVec3::ZERO, glam::DVec3::ONE;
}

impl<R: Scalar, const N: usize> Value<R> for [R; N] {
    fn zero() -> Self {
        [R::ZERO; N]
    }
    fn one() -> Self {
        [R::ONE; N]
    }
    fn plus(self, other: Self) -> Self {
        core::array::from_fn(|i| self[i] + other[i])
    }
    fn multiply(self, other: Self) -> Self {
        core::array::from_fn(|i| self[i] * other[i])
    }
    fn times(self, factor: R) -> Self {
        self.map(|c| c * factor)
    }
    fn over(self, divisor: R) -> Self {
        self.map(|c| c / divisor)
    }
    fn is_zero(&self) -> bool {
        self.iter().all(|c| *c == R::ZERO)
    }
}
