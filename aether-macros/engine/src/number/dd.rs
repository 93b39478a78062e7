//! Double-double arithmetic: the unevaluated sum of two `f64`, about 31 decimal digits.
//!
//! The algorithms are those of Dekker (1971) and Knuth for error-free sums and products, with the
//! accurate addition of Joldes, Muller and Popescu (2017, "Tight and rigorous error bounds for basic
//! building blocks of double-word arithmetic").

mod constants;
mod functions;
mod special;
#[cfg(test)]
mod tests;

use super::ratio;
use std::ops::{Add, Div, Mul, Neg, Sub};

/// A number `hi + lo`, where `hi` is the `f64` nearest to the sum; `lo` is zero unless `hi` is
/// finite.
///
/// Its precision is at least 104 bits while `lo` is a normal `f64`, that is above about 1e-290;
/// smaller numbers keep what the exponent range of `f64` leaves. The functions of
/// [`Number`](super::Number) have relative errors below 1e-30 except where noted: an integer power
/// `n` up to `n` units of 2⁻¹⁰⁴, other powers `x^y` up to `|y ln x|` of these; sines and cosines
/// lose relative accuracy near their zeros as the rounding of the argument itself does, and
/// arguments beyond 2⁵⁰ give 16 digits only.
#[derive(Clone, Copy, PartialEq, PartialOrd, Debug)]
pub struct Dd {
    hi: f64,
    lo: f64,
}

/// `a + b` and its rounding error, exactly.
#[inline(always)]
fn two_sum(a: f64, b: f64) -> (f64, f64) {
    let sum = a + b;
    let b_part = sum - a;
    (sum, (a - (sum - b_part)) + (b - b_part))
}

/// The upper 26 bits of `a` and the rest.
#[inline(always)]
fn split(a: f64) -> (f64, f64) {
    const SPLITTER: f64 = ((1u64 << 27) + 1) as f64;
    let t = SPLITTER * a;
    let hi = t - (t - a);
    (hi, a - hi)
}

/// `a * b` and its rounding error, exactly unless the error is subnormal; no error if the product
/// is not finite.
#[inline(always)]
pub(super) fn two_prod(a: f64, b: f64) -> (f64, f64) {
    /// Splitting larger numbers could overflow.
    const LARGE: f64 = 1e290;
    const DOWN: f64 = 1.0 / (1u64 << 60) as f64;
    let product = a * b;
    if !is_finite(product) {
        return (product, 0.0);
    }
    // Of a finite product not both can be as large. These comparisons are no calls where the compiler runs unoptimised.
    #[allow(clippy::manual_range_contains)]
    let (large_a, large_b) = (a > LARGE || a < -LARGE, b > LARGE || b < -LARGE);
    if large_a {
        return (product, error_of(a * DOWN, b, product * DOWN) / DOWN);
    }
    if large_b {
        return (product, error_of(a, b * DOWN, product * DOWN) / DOWN);
    }
    (product, error_of(a, b, product))
}

/// The rounding error of a product of numbers that are not too large to be split.
#[inline(always)]
fn error_of(a: f64, b: f64, product: f64) -> f64 {
    let ((a_hi, a_lo), (b_hi, b_lo)) = (split(a), split(b));
    ((a_hi * b_hi - product) + a_hi * b_lo + a_lo * b_hi) + a_lo * b_lo
}

/// Whether a number is one: as an expression, because calls cost where the compiler runs unoptimised.
#[inline(always)]
#[allow(clippy::eq_op)]
fn is_finite(x: f64) -> bool {
    x - x == 0.0
}

/// Whether products of a few numbers of this size neither overflow nor lose their error terms.
fn is_moderate(a: f64) -> bool {
    const LARGE: f64 = 1e150;
    (1.0 / LARGE..=LARGE).contains(&a.abs())
}

impl Dd {
    /// Zero.
    pub const ZERO: Dd = Dd { hi: 0.0, lo: 0.0 };
    /// One.
    pub const ONE: Dd = Dd { hi: 1.0, lo: 0.0 };
    const NAN: Dd = Dd::of(f64::NAN);
    const INFINITY: Dd = Dd::of(f64::INFINITY);

    /// The number `hi`.
    pub const fn of(hi: f64) -> Dd {
        Dd { hi, lo: 0.0 }
    }

    /// The sum `hi + lo` of a number and a smaller one (at most of its size).
    #[inline(always)]
    fn normalized(hi: f64, lo: f64) -> Dd {
        let sum = hi + lo;
        if is_finite(sum) {
            Dd { hi: sum, lo: lo - (sum - hi) }
        } else if is_finite(hi) && !lo.is_nan() {
            Dd::of(sum)
        } else {
            // An error term next to an infinity is NaN and means nothing.
            Dd::of(hi)
        }
    }

    /// The sum `a + b`.
    pub fn sum(a: f64, b: f64) -> Dd {
        let (sum, error) = two_sum(a, b);
        Dd::normalized(sum, error)
    }

    /// The product `a * b`, exact unless its error is subnormal.
    pub fn product(a: f64, b: f64) -> Dd {
        let (product, error) = two_prod(a, b);
        Dd::normalized(product, error)
    }

    /// The two parts: the nearest `f64`, and the rest.
    pub const fn parts(self) -> (f64, f64) {
        (self.hi, self.lo)
    }

    fn of_ratio(numerator: i128, denominator: i128) -> Dd {
        let (hi, lo) = ratio::quotient(numerator, denominator);
        Dd { hi, lo }
    }

    /// `self * 2^exponent`.
    fn scale(self, exponent: i32) -> Dd {
        Dd::normalized(libm::scalbn(self.hi, exponent), libm::scalbn(self.lo, exponent))
    }

    /// `self * factor` for a power of two, where nothing is subnormal.
    #[inline]
    fn times_power(self, factor: f64) -> Dd {
        Dd { hi: self.hi * factor, lo: self.lo * factor }
    }
}

impl Neg for Dd {
    type Output = Dd;

    #[inline]
    fn neg(self) -> Dd {
        Dd { hi: -self.hi, lo: -self.lo }
    }
}

impl Add for Dd {
    type Output = Dd;

    fn add(self, other: Dd) -> Dd {
        let (sum, error) = two_sum(self.hi, other.hi);
        let (low_sum, low_error) = two_sum(self.lo, other.lo);
        let Dd { hi, lo } = Dd::normalized(sum, error + low_sum);
        Dd::normalized(hi, lo + low_error)
    }
}

impl Sub for Dd {
    type Output = Dd;

    #[inline]
    fn sub(self, other: Dd) -> Dd {
        self + -other
    }
}

impl Mul for Dd {
    type Output = Dd;

    fn mul(self, other: Dd) -> Dd {
        let (product, error) = two_prod(self.hi, other.hi);
        Dd::normalized(product, error + (self.hi * other.lo + self.lo * other.hi))
    }
}

impl Div for Dd {
    type Output = Dd;

    fn div(self, other: Dd) -> Dd {
        let first = self.hi / other.hi;
        if !first.is_finite() || first == 0.0 {
            return Dd::of(first);
        }
        if !is_moderate(self.hi) || !is_moderate(other.hi) {
            let (n, d) = (libm::ilogb(self.hi), libm::ilogb(other.hi));
            return (self.scale(-n) / other.scale(-d)).scale(n - d);
        }
        let rest = self - other * Dd::of(first);
        let second = rest.hi / other.hi;
        let rest = rest - other * Dd::of(second);
        let third = rest.hi / other.hi;
        Dd::normalized(first, second) + Dd::of(third)
    }
}
