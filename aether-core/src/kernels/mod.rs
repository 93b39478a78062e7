//! Elementary functions in single precision, the same for one number and for lanes.
//!
//! A kernel computes in double precision and is rounded once, at the end. So its result is off by
//! little more than half a unit in the last place, there is nothing to lose by underflow or
//! cancellation, and a polynomial of a few terms is enough. It has no branch that depends on its
//! argument, but for those that are rare: zero, infinity, angles so large that their reduction needs more
//! than a double. It uses no fused operations and nothing of the host's library: results are the same
//! bits on every machine, and in every lane.
//!
//! `Lanes` computes with them. `f32` does with the feature `portable` only: for one number, the tables
//! and fused operations of a good host library are faster. Sines and cosines of fractions of a turn, which hosts do not have,
//! are those of `turns.rs` in every type, also in double precision; `f64` has some others of its own (`double.rs`).
//!
//! Reductions: n π/2 is subtracted from angles, n ln 2 from exponents (Cody and Waite 1980); logarithms
//! are 2 atanh((m - 1) / (m + 1)) of the mantissa m in [1/√2, √2]; an inverse tangent is that of
//! (y - x) / (y + x) and an eighth of a turn where the angle is above a sixteenth. The polynomials
//! are Chebyshev interpolations of the exact functions, computed with 40 digits.

mod circular;
pub(crate) mod double;
mod exponential;
mod turns;

pub(crate) use circular::{acos, asin, atan, atan2, cos, sin, tan};
pub(crate) use exponential::{
    acosh, asinh, atanh, cbrt, cosh, exp, exp_m1, hypot, ln, ln_1p, powf, sinh, tanh,
};
pub(crate) use turns::{sin_cos_pi, sin_cos_pi_double};

use core::ops::{Add, Div, Mul, Neg, Sub};

use crate::real::Mask;

/// What a kernel computes with: one or several numbers in double precision.
pub(crate) trait Double:
    Copy
    + Neg<Output = Self>
    + Add<Output = Self>
    + Sub<Output = Self>
    + Mul<Output = Self>
    + Div<Output = Self>
{
    /// What comparisons return.
    type Mask: Mask;
    /// The number `x`.
    fn of(x: f64) -> Self;
    /// `self < other`.
    fn lt(self, other: Self) -> Self::Mask;
    /// `self <= other`.
    fn le(self, other: Self) -> Self::Mask;
    /// `yes` where `mask` is true, else `no`.
    fn select(mask: Self::Mask, yes: Self, no: Self) -> Self;
    /// Magnitude.
    fn abs(self) -> Self;
    /// Square root.
    fn sqrt(self) -> Self;
    /// Magnitude of `self` with the sign of `sign`.
    fn copysign(self, sign: Self) -> Self;
    /// 2^self, for whole numbers from -1022 to 1023.
    fn power_of_two(self) -> Self;
    /// Mantissa in [1/√2, √2] and exponent of a positive normal number.
    fn mantissa_exponent(self) -> (Self, Self);
    /// `f(x)` where the mask is true, else `self`.
    fn replace(self, mask: Self::Mask, x: Self, f: fn(f64) -> f64) -> Self;
    /// The sine and cosine of an angle, turned on by as many quarters of a turn as the last two bits of `quarters`
    /// count.
    fn turned(quarters: Self, sin: Self, cos: Self) -> (Self, Self);

    /// The whole number nearest to `self`, if that is below 2^51 in magnitude.
    #[inline(always)]
    fn round(self) -> Self {
        let shift = Self::of(ROUND_SHIFT);
        (self + shift) - shift
    }
    /// Of a whole number below 2^51 in magnitude: whether it is odd, and whether its half, rounded
    /// down, is.
    #[inline(always)]
    fn lowest_bits(self) -> (Self::Mask, Self::Mask) {
        let half = |n: Self| (n * Self::of(0.5) - Self::of(0.25)).round();
        let h = half(self);
        (h.lt(self * Self::of(0.5)), half(h).lt(h * Self::of(0.5)))
    }
    /// At most `limit`; NaN stays.
    #[inline(always)]
    fn at_most(self, limit: f64) -> Self {
        let limit = Self::of(limit);
        Self::select(limit.lt(self), limit, self)
    }
    /// At least `limit`; NaN stays.
    #[inline(always)]
    fn at_least(self, limit: f64) -> Self {
        let limit = Self::of(limit);
        Self::select(self.lt(limit), limit, self)
    }
    /// Whether it is finite.
    #[inline(always)]
    fn finite(self) -> Self::Mask {
        self.abs().lt(Self::of(f64::INFINITY))
    }
    /// Equality.
    #[inline(always)]
    fn is(self, other: Self) -> Self::Mask {
        self.le(other).and(other.le(self))
    }
}

impl Double for f64 {
    type Mask = bool;
    #[inline(always)]
    fn of(x: f64) -> f64 {
        x
    }
    #[inline(always)]
    fn lt(self, other: f64) -> bool {
        self < other
    }
    #[inline(always)]
    fn le(self, other: f64) -> bool {
        self <= other
    }
    #[inline(always)]
    fn select(mask: bool, yes: f64, no: f64) -> f64 {
        if mask { yes } else { no }
    }
    #[inline(always)]
    fn abs(self) -> f64 {
        f64::abs(self)
    }
    #[inline(always)]
    fn sqrt(self) -> f64 {
        f64::sqrt(self)
    }
    #[inline(always)]
    fn copysign(self, sign: f64) -> f64 {
        f64::copysign(self, sign)
    }
    #[inline(always)]
    fn lowest_bits(self) -> (bool, bool) {
        let bits = (self + ROUND_SHIFT).to_bits();
        (bits & 1 == 1, bits & 2 == 2)
    }
    #[inline(always)]
    fn power_of_two(self) -> f64 {
        f64::from_bits((self + POWER_SHIFT).to_bits() << 52)
    }
    #[inline(always)]
    fn mantissa_exponent(self) -> (f64, f64) {
        let bits = self.to_bits().wrapping_add(ONE - LEAST);
        let mantissa = f64::from_bits((bits & MANTISSA) + LEAST);
        (mantissa, f64::from_bits((bits >> 52) | EXPONENT) - POWER_SHIFT)
    }
    #[inline(always)]
    fn replace(self, mask: bool, x: f64, f: fn(f64) -> f64) -> f64 {
        if mask { outside(x, f) } else { self }
    }
    #[inline(always)]
    fn turned(quarters: f64, sin: f64, cos: f64) -> (f64, f64) {
        let (n, sin, cos) = (quarters.to_bits(), sin.to_bits(), cos.to_bits());
        let exchanged = (sin ^ cos) & (n & 1).wrapping_neg();
        let sin = sin ^ exchanged ^ ((n & 2) << 62);
        let cos = cos ^ exchanged ^ ((n.wrapping_add(1) & 2) << 62);
        (f64::from_bits(sin), f64::from_bits(cos))
    }
}

/// 3/2 2^52: the sum with a small number is a whole number, its lowest bits those of the nearest one.
const ROUND_SHIFT: f64 = 6_755_399_441_055_744.0;
/// 2^52 plus the bias of exponents: in the sum with n, the lowest bits are the exponent of 2^n.
pub(crate) const POWER_SHIFT: f64 = 4_503_599_627_370_496.0 + 1023.0;
/// The bits of a mantissa.
pub(crate) const MANTISSA: u64 = 0x000F_FFFF_FFFF_FFFF;
/// The bits of one.
pub(crate) const ONE: u64 = 0x3FF0_0000_0000_0000;
/// The bits of 1/√2.
pub(crate) const LEAST: u64 = 0x3FE6_A09E_667F_3BCD;
/// The bits of 2^52; combined with a biased exponent, they are the number 2^52 + exponent.
pub(crate) const EXPONENT: u64 = 0x4330_0000_0000_0000;

/// A rare argument.
#[cold]
pub(crate) fn outside(x: f64, f: fn(f64) -> f64) -> f64 {
    f(x)
}

/// c[0] + c[1] t + c[2] t² + …; even and odd powers apart, which halves the time that the one result
/// takes.
#[inline(always)]
fn polynomial<D: Double, const N: usize>(c: &[f64; N], t: D) -> D {
    let square = t * t;
    let chain = |highest: usize| {
        let (mut i, mut sum) = (highest, D::of(c[highest]));
        while i > 1 {
            i -= 2;
            sum = sum * square + D::of(c[i]);
        }
        sum
    };
    let (last, other) = (chain(N - 1), chain(N - 2));
    if N.is_multiple_of(2) { other + last * t } else { last + other * t }
}

/// x^n by repeated squaring.
#[inline(always)]
pub(crate) fn powi<R: crate::real::Real>(x: R, exponent: i32) -> R {
    let (mut n, mut square, mut product) = (exponent.unsigned_abs(), x, R::ONE);
    while n > 0 {
        if n % 2 == 1 {
            product *= square;
        }
        square *= square;
        n /= 2;
    }
    if exponent < 0 { R::ONE / product } else { product }
}

/// The functions of `Real` for a type in single precision that goes to double precision by `widen` and
/// back by `narrow`.
macro_rules! single_precision {
    ($t:ident) => {
        crate::kernels::single_precision! { $t:
            cbrt exp exp_m1 ln ln_1p sin cos tan asin acos atan sinh cosh tanh asinh acosh atanh;
            powf(exponent) atan2(x) hypot(other)
        }
        #[inline(always)]
        fn powi(self, exponent: i32) -> $t {
            crate::kernels::powi(self, exponent)
        }
        #[inline(always)]
        fn sin_cos_pi(self) -> ($t, $t) {
            crate::kernels::sin_cos_pi(self)
        }
    };
    ($t:ident: $($unary:ident)*; $($binary:ident($argument:ident))*) => {
        $(#[inline]
        fn $unary(self) -> $t {
            crate::kernels::SinglePrecision::narrow(crate::kernels::$unary(
                crate::kernels::SinglePrecision::widen(self),
            ))
        })*
        $(#[inline]
        fn $binary(self, $argument: $t) -> $t {
            crate::kernels::SinglePrecision::narrow(crate::kernels::$binary(
                crate::kernels::SinglePrecision::widen(self),
                crate::kernels::SinglePrecision::widen($argument),
            ))
        })*
    };
}
pub(crate) use single_precision;

/// A number in single precision.
pub(crate) trait SinglePrecision {
    /// The same in double precision.
    type Wide: Double;
    /// Exactly.
    fn widen(self) -> Self::Wide;
    /// Rounded.
    fn narrow(wide: Self::Wide) -> Self;
}

impl SinglePrecision for f32 {
    type Wide = f64;
    #[inline(always)]
    fn widen(self) -> f64 {
        f64::from(self)
    }
    #[inline(always)]
    fn narrow(wide: f64) -> f32 {
        wide as f32
    }
}
