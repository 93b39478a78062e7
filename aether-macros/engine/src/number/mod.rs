//! Real numbers for the evaluator: `f64`, [`Single`] and the double-double [`Dd`].
//!
//! Results are the same on every machine: only IEEE basic operations and the pure-Rust functions of
//! the crate `libm` are used, never the host's mathematical library.

mod beta;
mod dd;
mod f64;
mod ratio;
mod single;

pub use dd::Dd;
pub use single::Single;

use std::fmt::Debug;
use std::ops::{Add, Div, Mul, Neg, Sub};

/// A real number with the elementary functions, at some fixed precision.
///
/// Nothing panics. NaN and infinities propagate as in IEEE 754: outside its domain a function is
/// NaN, at a pole it is infinite. Angles are in radians.
///
/// On a plain `f64` outside generic code `x.sin()` is the standard library's method, which may
/// differ between machines; write `Number::sin(x)` there.
pub trait Number:
    Copy
    + Debug
    + PartialOrd
    + Neg<Output = Self>
    + Add<Output = Self>
    + Sub<Output = Self>
    + Mul<Output = Self>
    + Div<Output = Self>
{
    /// The number `value`, exactly.
    fn from_f64(value: f64) -> Self;
    /// The number nearest to `numerator / denominator`; over zero it is infinite, and 0/0 is NaN.
    fn from_ratio(numerator: i128, denominator: i128) -> Self;
    /// The `f64` nearest to `self`.
    fn to_f64(self) -> f64;
    /// The number nearest to π.
    fn pi() -> Self;
    /// The absolute value.
    fn abs(self) -> Self;
    /// The largest integer not above `self`.
    fn floor(self) -> Self;
    /// The square root; NaN below zero.
    fn sqrt(self) -> Self;
    /// The cube root, of the sign of `self`.
    fn cbrt(self) -> Self;
    /// e to the power `self`.
    fn exp(self) -> Self;
    /// `exp(self) - 1`, accurate near zero.
    fn exp_m1(self) -> Self;
    /// The natural logarithm; -∞ at zero and NaN below.
    fn ln(self) -> Self;
    /// `ln(1 + self)`, accurate near zero.
    fn ln_1p(self) -> Self;
    /// The sine.
    fn sin(self) -> Self;
    /// The cosine.
    fn cos(self) -> Self;
    /// The tangent.
    fn tan(self) -> Self;
    /// The arc sine, in [-π/2, π/2]; NaN outside [-1, 1].
    fn asin(self) -> Self;
    /// The arc cosine, in [0, π]; NaN outside [-1, 1].
    fn acos(self) -> Self;
    /// The arc tangent, in [-π/2, π/2].
    fn atan(self) -> Self;
    /// The angle, in [-π, π], of the point whose ordinate is `self` and whose abscissa is `x`;
    /// zero at the origin.
    fn atan2(self, x: Self) -> Self;
    /// The hyperbolic sine.
    fn sinh(self) -> Self;
    /// The hyperbolic cosine.
    fn cosh(self) -> Self;
    /// The hyperbolic tangent.
    fn tanh(self) -> Self;
    /// The inverse of the hyperbolic sine.
    fn asinh(self) -> Self;
    /// The inverse, not negative, of the hyperbolic cosine; NaN below 1.
    fn acosh(self) -> Self;
    /// The inverse of the hyperbolic tangent; infinite at ±1 and NaN beyond.
    fn atanh(self) -> Self;
    /// `self` to the power `exponent`; 1 if the exponent is zero, and NaN for a negative base with
    /// a fractional exponent.
    fn powf(self, exponent: Self) -> Self;
    /// `self` to an integer power; 1 if the exponent is zero.
    fn powi(self, exponent: i32) -> Self;
    /// `sqrt(self² + other²)` without overflow on the way.
    fn hypot(self, other: Self) -> Self;
    /// The error function.
    fn erf(self) -> Self;
    /// `1 - erf(self)`, accurate where it is small.
    fn erfc(self) -> Self;
    /// The inverse of `erf`; infinite at ±1 and NaN beyond.
    fn erf_inv(self) -> Self;
    /// The inverse of `erfc`; infinite at 0 and 2 and NaN outside.
    fn erfc_inv(self) -> Self;
    /// The logarithm of `erfc`.
    fn ln_erfc(self) -> Self;
    /// The inverse of `ln_erfc`; NaN beyond ln 2.
    fn erfc_inv_exp(self) -> Self;
    /// The principal branch of Lambert's W; NaN below -1/e.
    fn lambert_w(self) -> Self;
    /// The logarithm of the gamma function of a positive number.
    fn ln_gamma(self) -> Self;
    /// The logarithm of the beta function of two positive numbers.
    fn ln_beta(self, b: Self) -> Self;
    /// The regularised incomplete beta function I of `self` in [0, 1], where `rest` is 1 - `self`.
    fn beta_inc(self, rest: Self, a: Self, b: Self) -> Self;
    /// The inverse of `beta_inc`.
    fn beta_inc_inv(self, rest: Self, a: Self, b: Self) -> Self;
    /// The smaller of two; the other one if one is NaN.
    fn min(self, other: Self) -> Self;
    /// The larger of two; the other one if one is NaN.
    fn max(self, other: Self) -> Self;
    /// Whether the number is neither infinite nor NaN.
    fn is_finite(self) -> bool;
    /// Whether this is not a number.
    fn is_nan(self) -> bool;
}
