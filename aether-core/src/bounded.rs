//! A real number together with a bound on its rounding error.

use core::ops::{Add, AddAssign, Div, DivAssign, Mul, MulAssign, Neg, Sub, SubAssign};

use crate::real::{Real, Scalar, Single};
use crate::special::Function;

/// A value and a first-order bound on its absolute error (running error analysis).
///
/// A derived inverse runs on `Bounded` where a recovered uniform falls outside [0, 1) or where a
/// point may lie off the manifold: the bound says whether rounding alone explains it, so tolerances
/// follow the coordinates and the anchors instead of being absolute.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Bounded<R> {
    /// The value, computed as it would be without the bound but next to the ends of the domain of a root or an arc.
    pub value: R,
    /// Bound on the absolute error of `value`.
    pub error: R,
}

impl<R: Scalar> Bounded<R> {
    /// A number that was rounded once: its error is one unit in the last place.
    #[inline]
    pub fn rounded(value: R) -> Self {
        Bounded { value, error: value.abs() * R::EPSILON }
    }

    /// A number that is exact.
    #[inline]
    pub fn exact(value: R) -> Self {
        Bounded { value, error: R::ZERO }
    }

    /// A result with the error carried over from the operands, plus its own rounding.
    #[inline]
    fn result(value: R, carried: R) -> Self {
        let error = carried + value.abs() * R::EPSILON;
        // A NaN bound (0 times infinity) tells nothing: take it as no knowledge at all. This is one instruction, the least
        // of two numbers.
        Bounded { value, error: if error.lt(R::INFINITY) { error } else { R::INFINITY } }
    }

    /// Applies a function with the given derivative at the value.
    #[inline]
    fn function(self, value: R, derivative: R) -> Self {
        // An exact operand stays exact even at a pole of the derivative.
        let carried = if self.error == R::ZERO { R::ZERO } else { derivative.abs() * self.error };
        Self::result(value, carried)
    }

    /// A result that cannot be further off than the width of its range.
    #[inline]
    fn capped(self, width: R) -> Self {
        Bounded { value: self.value, error: self.error.min(width) }
    }

    /// A function with a domain that ends at `low` and `high`, of which an argument within it is meant: one that
    /// rounding has put beyond an end is that end, and there are no arguments beyond.
    #[inline]
    fn steep_between(self, f: impl Fn(R) -> R, low: R, high: R) -> Self {
        let far = R::of(8.0) * self.error;
        let beyond = self.value.lt(low - far) || self.value.gt(high + far);
        let inside = |x: R| if beyond || !x.ge(x) { x } else { x.max(low).min(high) };
        let at = Bounded { value: inside(self.value), error: self.error };
        at.steep(f(at.value), |x| f(inside(x)))
    }

    /// A function whose derivative blows up at an end of its domain (a square root at zero, an
    /// inverse cosine at one): the error is the secant over the interval of uncertainty.
    #[inline]
    fn steep(self, value: R, f: impl Fn(R) -> R) -> Self {
        let up = (f(self.value + self.error) - value).abs();
        let down = (value - f(self.value - self.error)).abs();
        let known = |d: R| if d.gt(R::ZERO) { d } else { R::ZERO };
        Self::result(value, known(up).max(known(down)))
    }
}

impl<R: Scalar> Neg for Bounded<R> {
    type Output = Self;
    #[inline]
    fn neg(self) -> Self {
        Bounded { value: -self.value, error: self.error }
    }
}
impl<R: Scalar> Add for Bounded<R> {
    type Output = Self;
    #[inline]
    fn add(self, other: Self) -> Self {
        Self::result(self.value + other.value, self.error + other.error)
    }
}
impl<R: Scalar> Sub for Bounded<R> {
    type Output = Self;
    #[inline]
    fn sub(self, other: Self) -> Self {
        Self::result(self.value - other.value, self.error + other.error)
    }
}
impl<R: Scalar> Mul for Bounded<R> {
    type Output = Self;
    #[inline]
    fn mul(self, other: Self) -> Self {
        let carried = self.value.abs() * other.error
            + other.value.abs() * self.error
            + self.error * other.error;
        Self::result(self.value * other.value, carried)
    }
}
impl<R: Scalar> Div for Bounded<R> {
    type Output = Self;
    #[inline]
    fn div(self, other: Self) -> Self {
        let quotient = self.value / other.value;
        let nearest = other.value.abs() - other.error;
        // If the divisor may be zero, the bound is infinite, or no number.
        let nearest = if nearest > R::ZERO { nearest } else { R::ZERO };
        let carried = (self.error + quotient.abs() * other.error) / nearest;
        Self::result(quotient, carried)
    }
}

macro_rules! assign {
    ($($trait:ident $name:ident $op:tt;)*) => {
        $(impl<R: Scalar> $trait for Bounded<R> {
            #[inline]
            fn $name(&mut self, other: Self) { *self = *self $op other; }
        })*
    };
}
assign! { AddAssign add_assign +; SubAssign sub_assign -; MulAssign mul_assign *; DivAssign div_assign /; }

macro_rules! smooth {
    ($($name:ident: $derivative:expr;)*) => {
        $(#[inline]
        fn $name(self) -> Self {
            let derivative: fn(R) -> R = $derivative;
            self.function(self.value.$name(), derivative(self.value))
        })*
    };
}

macro_rules! steep {
    ($($name:ident)*) => {
        $(#[inline]
        fn $name(self) -> Self { self.steep(self.value.$name(), R::$name) })*
    };
}

impl<R: Scalar> Single for Bounded<R> {
    type Tracked = Self;
    #[inline]
    fn track(self) -> Self {
        self
    }
    #[inline]
    fn track_within(self, error: Self) -> Self {
        Bounded { value: self.value, error: self.error.max(error.value) }
    }
    #[inline]
    fn value_and_error(tracked: Self) -> (Self, Self) {
        (Self::exact(tracked.value), Self::exact(tracked.error))
    }
}

/// Comparisons look at values alone.
impl<R: Scalar> Real for Bounded<R> {
    type Mask = bool;
    type Lane = Self;
    const LANES: usize = 1;
    const ZERO: Self = Bounded { value: R::ZERO, error: R::ZERO };
    const ONE: Self = Bounded { value: R::ONE, error: R::ZERO };
    const EPSILON: Self = Bounded { value: R::EPSILON, error: R::ZERO };
    const INFINITY: Self = Bounded { value: R::INFINITY, error: R::ZERO };
    const MIN_POSITIVE: Self = Bounded { value: R::MIN_POSITIVE, error: R::ZERO };

    #[inline]
    fn lane(self, _: usize) -> Self {
        self
    }
    #[inline]
    fn with_lane(self, _: usize, value: Self) -> Self {
        value
    }
    #[inline]
    fn exact(self) -> Self {
        Self::exact(self.value)
    }
    #[inline]
    fn of(x: f64) -> Self {
        let value = R::of(x);
        if value.to_f64() == x { Self::exact(value) } else { Self::rounded(value) }
    }
    #[inline]
    fn to_f64(self) -> f64 {
        self.value.to_f64()
    }
    #[inline]
    fn lt(self, other: Self) -> bool {
        self.value < other.value
    }
    #[inline]
    fn le(self, other: Self) -> bool {
        self.value <= other.value
    }
    #[inline]
    fn select(mask: bool, yes: Self, no: Self) -> Self {
        if mask { yes } else { no }
    }
    #[inline]
    fn finite(self) -> bool {
        self.value.finite()
    }
    #[inline]
    fn abs(self) -> Self {
        Bounded { value: self.value.abs(), error: self.error }
    }
    #[inline]
    fn min(self, other: Self) -> Self {
        let error = self.error.max(other.error);
        Bounded { value: self.value.min(other.value), error }
    }
    #[inline]
    fn max(self, other: Self) -> Self {
        let error = self.error.max(other.error);
        Bounded { value: self.value.max(other.value), error }
    }
    #[inline]
    fn floor(self) -> Self {
        Self::exact(self.value.floor())
    }
    #[inline]
    fn copysign(self, sign: Self) -> Self {
        Bounded { value: self.value.copysign(sign.value), error: self.error }
    }
    #[inline]
    fn powf(self, exponent: Self) -> Self {
        let value = self.value.powf(exponent.value);
        let base = self.steep(value, |x| x.powf(exponent.value)).error;
        let power = if exponent.error == R::ZERO {
            R::ZERO
        } else {
            (value * self.value.ln()).abs() * exponent.error
        };
        Self::result(value, base + power)
    }
    #[inline]
    fn powi(self, exponent: i32) -> Self {
        let slope = R::of(f64::from(exponent)) * self.value.powi(exponent - 1);
        self.function(self.value.powi(exponent), slope)
    }
    #[inline]
    fn sin(self) -> Self {
        self.function(self.value.sin(), self.value.cos()).capped(R::of(2.0))
    }
    #[inline]
    fn cos(self) -> Self {
        self.function(self.value.cos(), self.value.sin()).capped(R::of(2.0))
    }
    #[inline]
    fn sin_cos_pi(self) -> (Self, Self) {
        let (sin, cos) = self.value.sin_cos_pi();
        let slope = |x: R| R::of(core::f64::consts::PI) * x;
        // In double precision both are off by up to 1.6 units in the last place.
        let bounded = |value: R, slope: R| {
            let once = self.function(value, slope).capped(R::of(2.0));
            Self::result(value, once.error)
        };
        (bounded(sin, slope(cos)), bounded(cos, slope(sin)))
    }
    #[inline]
    fn atan2(self, x: Self) -> Self {
        let radius2 = self.value * self.value + x.value * x.value;
        let carried = (x.value.abs() * self.error + self.value.abs() * x.error) / radius2;
        Self::result(self.value.atan2(x.value), carried).capped(R::of(7.0))
    }
    #[inline]
    fn hypot(self, other: Self) -> Self {
        Self::result(self.value.hypot(other.value), self.error + other.error)
    }
    #[inline]
    fn special<F: Function>(parameters: &[Self], x: Self) -> Self {
        // None of them has more parameters than this.
        let mut values = [R::ZERO; 2];
        for (value, parameter) in values.iter_mut().zip(parameters) {
            *value = parameter.value;
        }
        let values = &values[..parameters.len().min(2)];
        let f = |x| F::value(values, x);
        let value = f(x.value);
        // The kernels are off by some units in the last place: this one, and the one of the inverse
        // function that may have made the argument. In single precision none is off by many.
        let double = R::EPSILON.to_f64() < 1e-10;
        let ulps = R::of(if double { F::ULPS } else { 4.0 });
        let off = |x: R| x.abs() * R::EPSILON * ulps;
        let wider = Bounded { value: x.value, error: x.error + off(x.value) };
        let carried = if x.error == R::ZERO { R::ZERO } else { wider.steep(value, f).error };
        Self::result(value, carried + off(value))
    }
    smooth! {
        exp: |x| x.exp();
        exp_m1: |x| x.exp();
        tan: |x| R::ONE + x.tan() * x.tan();
        atan: |x| R::ONE / (R::ONE + x * x);
        sinh: |x| x.cosh();
        cosh: |x| x.sinh();
        tanh: |x| R::ONE - x.tanh() * x.tanh();
        asinh: |x| R::ONE / (x * x + R::ONE).sqrt();
    }
    steep! { cbrt ln ln_1p acosh atanh }
    #[inline]
    fn sqrt(self) -> Self {
        self.steep_between(R::sqrt, R::ZERO, R::INFINITY)
    }
    #[inline]
    fn asin(self) -> Self {
        self.steep_between(R::asin, -R::ONE, R::ONE)
    }
    #[inline]
    fn acos(self) -> Self {
        self.steep_between(R::acos, -R::ONE, R::ONE)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// What rounding has put beyond the end of a domain is the end; the error covers what else it may have been.
    #[test]
    fn arguments_next_to_the_end_of_a_domain_lie_within_it() {
        let number = |value: f64, error: f64| Bounded { value, error };
        let root = number(-1e-17, 1e-16).sqrt();
        assert!(root.value == 0.0 && root.error >= 9e-17_f64.sqrt() && root.error < 1.1e-8);
        let root = number(1e-17, 1e-16).sqrt();
        assert!(root.value == 1e-17_f64.sqrt() && root.error >= root.value);
        let arc = number(1.0 + 1e-15, 4e-16).acos();
        assert!(arc.value == 0.0 && arc.error > 0.0 && arc.error < 1e-7);
        let arc = number(-1.0 - 1e-15, 4e-16).asin();
        assert!(arc.value == -core::f64::consts::FRAC_PI_2 && arc.error < 1e-7);
        // What no rounding explains is outside.
        assert!(number(-1e-14, 1e-16).sqrt().value.is_nan());
        assert!(number(-1e-17, 0.0).sqrt().value.is_nan());
        assert!(number(1.5, 1e-3).acos().value.is_nan());
        assert!(number(f64::NAN, 1.0).sqrt().value.is_nan());
    }
}
