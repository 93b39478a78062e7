//! The density of a whole path: a product that neither overflows nor underflows.

use core::cmp::Ordering;
use core::ops::{Add, Div, Mul};

use crate::real::Scalar;

/// A non-negative number with the precision of `R` and a wide exponent: the product of the
/// conditional densities of a path (Aether 2017, Eq. 4). A thousand factors survive in `f32`.
///
/// Its measure is the product of the measures of the vertices. Zero times infinity is zero: a path
/// that cannot arise does not arise at a pole either. NaN and negative factors count as zero.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PathDensity<R> {
    /// In [2^-48, 2^48), or zero or infinite: products and quotients of two stay in the range of `f32`, and nearly all
    /// densities need no exponent.
    mantissa: R,
    /// In powers of 2^96.
    exponent: i32,
}

/// Bits that one step of the exponent stands for, and the mantissas from which on and below which there is another step.
const STEP: i32 = 96;
const LEAST: f64 = 1.0 / MOST;
const MOST: f64 = (1_u64 << (STEP / 2)) as f64;

impl<R: Scalar> PathDensity<R> {
    /// The density of a path that cannot arise.
    pub const ZERO: Self = PathDensity { mantissa: R::ZERO, exponent: 0 };
    /// The density of the empty path.
    pub const ONE: Self = PathDensity { mantissa: R::ONE, exponent: 0 };
    /// A pole.
    pub const INFINITY: Self = PathDensity { mantissa: R::INFINITY, exponent: 0 };

    /// A number of ordinary range.
    #[inline]
    pub fn new(value: R) -> Self {
        Self::normalised(value, 0)
    }

    /// A number of ordinary range over another number.
    #[inline(always)]
    pub(crate) fn quotient(value: R, divisor: Self) -> Self {
        let mantissa = value / divisor.mantissa;
        if divisor.exponent == 0 && Self::is_usual(mantissa) {
            return PathDensity { mantissa, exponent: 0 };
        }
        Self::new(value).divided(divisor)
    }

    /// b / (a + b) with this number as a, which may be infinite, and b as usual: the weight of one beside others.
    #[inline(always)]
    pub(crate) fn share_beside(self, one: Self) -> R {
        if self.exponent | one.exponent == 0 {
            // Neither quotient nor sum of two such numbers leaves the range of numbers.
            return R::ONE / (R::ONE + self.mantissa / one.mantissa);
        }
        (Self::ONE / (Self::ONE + self / one)).value()
    }

    /// (a + b) c^n, where `power` takes a plain number to the power n: at once if none of the numbers has an exponent and the
    /// result needs none. Then c^n has not left the range of numbers either, as the sum is not zero and no less than 2^-48.
    /// `None` where that does not hold, nor a value is more than zero.
    #[inline(always)]
    pub(crate) fn plain_sum_times(
        [a, b]: [Self; 2],
        (value, divisor): (R, Self),
        power: impl Fn(R) -> R,
    ) -> Option<Self> {
        let mantissa = (a.mantissa + b.mantissa) * power(value / divisor.mantissa);
        let is_plain = a.exponent | b.exponent | divisor.exponent == 0
            && value > R::ZERO
            && Self::is_usual(mantissa);
        is_plain.then_some(PathDensity { mantissa, exponent: 0 })
    }

    /// The number m 2^(96 e) of a mantissa m and an exponent e: what [`PathDensity::parts`] has given, unchanged.
    pub fn from_parts(mantissa: R, exponent: i32) -> Self {
        Self::normalised(mantissa, exponent)
    }

    /// The mantissa m and the exponent e of the number m 2^(96 e), to be kept in a file.
    pub fn parts(self) -> (R, i32) {
        (self.mantissa, self.exponent)
    }

    #[inline(always)]
    fn normalised(mantissa: R, exponent: i32) -> Self {
        if Self::is_usual(mantissa) {
            PathDensity { mantissa, exponent }
        } else {
            Self::moved(mantissa, exponent)
        }
    }

    /// Whether a mantissa is neither zero nor infinite and stays as it is.
    #[inline(always)]
    fn is_usual(mantissa: R) -> bool {
        mantissa >= R::of(LEAST) && mantissa < R::of(MOST)
    }

    #[cold]
    #[inline(never)]
    fn moved(mut mantissa: R, mut exponent: i32) -> Self {
        if mantissa == R::INFINITY {
            return Self::INFINITY;
        }
        let positive = mantissa > R::ZERO; // false for NaN
        if !positive {
            return Self::ZERO;
        }
        while mantissa >= R::of(MOST) {
            mantissa *= R::of(LEAST * LEAST);
            exponent = exponent.saturating_add(1);
        }
        while mantissa < R::of(LEAST) {
            mantissa *= R::of(MOST * MOST);
            exponent = exponent.saturating_sub(1);
        }
        PathDensity { mantissa, exponent }
    }

    /// The value in the range of `R`: zero or infinite where it leaves it.
    #[inline]
    pub fn value(self) -> R {
        if self.exponent == 0 { self.mantissa } else { self.scaled() }
    }

    fn scaled(self) -> R {
        // 2^(±24 * 96) lies outside the range of f64, from any mantissa.
        let steps = self.exponent.clamp(-24, 24);
        let step = R::of(2.0).powi(if steps < 0 { -STEP } else { STEP });
        let mut value = self.mantissa;
        for _ in 0..steps.unsigned_abs() {
            value *= step;
        }
        value
    }

    /// Natural logarithm, as `f64`; -∞ for zero.
    pub fn ln(self) -> f64 {
        let exponent = f64::from(self.exponent) * f64::from(STEP) * core::f64::consts::LN_2;
        self.mantissa.to_f64().ln() + exponent
    }

    /// Whether the path cannot arise.
    #[inline]
    pub fn is_zero(self) -> bool {
        self.mantissa == R::ZERO
    }

    /// Whether the density has a pole here.
    #[inline]
    pub fn is_infinite(self) -> bool {
        self.mantissa == R::INFINITY
    }

    /// Whether a sample of this density can be used: neither zero nor infinite.
    #[inline]
    pub fn is_regular(self) -> bool {
        !self.is_zero() && !self.is_infinite()
    }

    /// How much likelier than `other`, as the weights of multiple importance sampling need it:
    /// infinite over infinite is one (the two are alike), anything over zero infinite.
    pub fn ratio(self, other: Self) -> R {
        if other.is_zero() {
            R::INFINITY
        } else if other.is_infinite() {
            if self.is_infinite() { R::ONE } else { R::ZERO }
        } else {
            (self / other).value()
        }
    }
}

impl<R: Scalar> Default for PathDensity<R> {
    fn default() -> Self {
        Self::ONE
    }
}

impl<R: Scalar> From<R> for PathDensity<R> {
    fn from(value: R) -> Self {
        Self::new(value)
    }
}

impl<R: Scalar> Mul for PathDensity<R> {
    type Output = Self;
    #[inline]
    fn mul(self, other: Self) -> Self {
        let mantissa = self.mantissa * other.mantissa;
        if self.exponent | other.exponent == 0 && Self::is_usual(mantissa) {
            return PathDensity { mantissa, exponent: 0 };
        }
        self.multiplied(other)
    }
}

impl<R: Scalar> Mul<R> for PathDensity<R> {
    type Output = Self;
    #[inline]
    fn mul(self, factor: R) -> Self {
        self * Self::new(factor)
    }
}

/// Division as of limits: by zero gives infinity (zero by zero zero), by infinity zero.
impl<R: Scalar> Div for PathDensity<R> {
    type Output = Self;
    #[inline]
    fn div(self, other: Self) -> Self {
        let mantissa = self.mantissa / other.mantissa;
        if self.exponent | other.exponent == 0 && Self::is_usual(mantissa) {
            return PathDensity { mantissa, exponent: 0 };
        }
        self.divided(other)
    }
}

/// The density of a mixture.
impl<R: Scalar> Add for PathDensity<R> {
    type Output = Self;
    #[inline]
    fn add(self, other: Self) -> Self {
        match self.exponent == other.exponent {
            true => Self::normalised(self.mantissa + other.mantissa, self.exponent),
            false => self.plus(other),
        }
    }
}

/// What is unusual is not in line.
impl<R: Scalar> PathDensity<R> {
    /// The product of any two numbers.
    #[cold]
    #[inline(never)]
    fn multiplied(self, other: Self) -> Self {
        if self.is_zero() || other.is_zero() {
            return Self::ZERO;
        }
        let exponent = self.exponent.saturating_add(other.exponent);
        Self::normalised(self.mantissa * other.mantissa, exponent)
    }

    /// The quotient of any two numbers.
    #[cold]
    #[inline(never)]
    fn divided(self, other: Self) -> Self {
        if self.is_zero() || other.is_infinite() {
            return Self::ZERO;
        }
        let exponent = self.exponent.saturating_sub(other.exponent);
        Self::normalised(self.mantissa / other.mantissa, exponent)
    }

    /// The sum of two numbers of different sizes.
    #[cold]
    #[inline(never)]
    fn plus(self, other: Self) -> Self {
        let (large, small) = if self < other { (other, self) } else { (self, other) };
        if small.is_zero() || large.is_infinite() {
            return large;
        }
        let steps = large.exponent.saturating_sub(small.exponent);
        if steps > 1 {
            return large; // The other is less than 2^-96 of it.
        }
        Self::normalised(large.mantissa + small.mantissa * R::of(LEAST * LEAST), large.exponent)
    }
}

impl<R: Scalar> PartialOrd for PathDensity<R> {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        if self.is_regular() && other.is_regular() && self.exponent != other.exponent {
            return self.exponent.partial_cmp(&other.exponent);
        }
        self.mantissa.partial_cmp(&other.mantissa)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_thousand_factors_survive_in_f32() {
        let mut p = PathDensity::<f32>::ONE;
        for i in 0..1000 {
            p = p * if i % 3 == 0 { 1e-30 } else { 3e-7 };
        }
        assert!(p.is_regular());
        assert_eq!(p.value(), 0.0);
        let expected = 334.0 * 1e-30_f64.ln() + 666.0 * 3e-7_f64.ln();
        assert!((p.ln() - expected).abs() < 1e-3, "{} {expected}", p.ln());
        let q = p * 0.25;
        assert_eq!(p.ratio(q), 4.0);
        assert_eq!(q.ratio(p), 0.25);
        assert!(q < p);
    }

    #[test]
    fn plain_numbers_are_those_of_wide_exponents() {
        let square = |x: f32| x * x;
        let steps = (-40..=40).map(|k| 1.3 * 2.0_f32.powi(3 * k));
        let numbers: Vec<f32> = steps.chain([0.0, -0.7, f32::INFINITY, f32::NAN]).collect();
        let mut plain = 0;
        for &value in &numbers {
            for &divisor in &numbers {
                for (a, b) in
                    [(0.0, 0.3), (3e-14, 0.0), (1e-16, 1e-18), (2e14, 2.7e14), (9.0, 1e15)]
                {
                    let [a, b, divisor] = [a, b, divisor].map(PathDensity::new);
                    let ratio = PathDensity::quotient(value, divisor);
                    let expected = (a + b) * (ratio * ratio);
                    let found = PathDensity::plain_sum_times([a, b], (value, divisor), square);
                    if let Some(found) = found {
                        assert_eq!(found, expected, "{a:?} {b:?} {value} {divisor:?}");
                        plain += 1;
                    }
                }
            }
            for &one in numbers.iter().filter(|one| **one > 0.0 && **one < f32::INFINITY) {
                let [others, one] = [value, one].map(PathDensity::new);
                let expected = (PathDensity::ONE / (PathDensity::ONE + others / one)).value();
                assert_eq!(others.share_beside(one), expected, "{others:?} {one:?}");
            }
        }
        assert!(plain > 500, "{plain}");
    }

    #[test]
    fn values_of_ordinary_range_are_exact() {
        for x in [1.0_f64, 0.1, 3.5e-300, 1.7e308, 5e-324, 123_456.0] {
            assert_eq!(PathDensity::new(x).value(), x);
        }
        for x in [1.0_f32, 0.1, 3.4e38, 1e-45, 1e-38] {
            assert_eq!(PathDensity::new(x).value(), x);
        }
        assert_eq!((PathDensity::new(1e300) * 1e300 / PathDensity::new(1e299)).value(), 1e301);
    }

    #[test]
    fn zero_and_infinity() {
        let (zero, one) = (PathDensity::<f64>::ZERO, PathDensity::<f64>::ONE);
        let infinite = one * f64::INFINITY;
        assert!((zero * infinite).is_zero() && (infinite * zero).is_zero());
        assert!(infinite.is_infinite() && !infinite.is_regular());
        assert_eq!(infinite.ratio(infinite), 1.0);
        assert_eq!(one.ratio(infinite), 0.0);
        assert_eq!(infinite.ratio(one), f64::INFINITY);
        assert_eq!(one.ratio(zero), f64::INFINITY);
        assert_eq!(zero.ratio(one), 0.0);
        assert!((one * f64::NAN).is_zero() && (one * -1.0).is_zero());
        assert!((zero / zero).is_zero() && (one / zero).is_infinite());
        assert!(infinite > one && zero < one);
    }

    #[test]
    fn sums_of_any_magnitudes() {
        let p = PathDensity::<f64>::new;
        for (a, b) in [(1.0, 2.0), (1e-300, 3e-290), (7e12, 1e-3), (65_535.0, 1e5), (1e300, 1.0)] {
            assert_eq!((p(a) + p(b)).value(), a + b);
            assert_eq!((p(b) + p(a)).value(), a + b);
        }
        let tiny = p(1e-200) * p(1e-200);
        assert_eq!((tiny + tiny).ratio(tiny), 2.0);
        assert_eq!((tiny + PathDensity::ZERO).ratio(tiny), 1.0);
        assert!((PathDensity::INFINITY + p(1.0)).is_infinite());
        assert!((PathDensity::<f64>::ZERO + PathDensity::ZERO).is_zero());
    }

    #[test]
    fn a_wide_exponent_saturates_instead_of_wrapping() {
        let mut p = PathDensity::<f64>::new(1e300);
        for _ in 0..60 {
            p = p * p;
        }
        assert!(p.value() == f64::INFINITY && p > PathDensity::ONE);
    }
}
