//! The elementary functions of double-doubles.
//!
//! The exponential, sine and cosine are Taylor series after argument reduction. The inverse
//! functions take one Newton step from the `f64` value, in a form that keeps the relative accuracy
//! of small results; the step itself is so small that `f64` suffices for it.

use super::constants::{HALF_PI_PARTS, INVERSE_FACTORIAL, LN_2, LN_2_PARTS, PI};
use super::{Dd, is_moderate, special};
use crate::number::{Number, beta};
use std::f64::consts::{FRAC_2_PI, LOG2_E, SQRT_2};

/// Below this, `exp_m1`, `ln_1p` and the like are the identity.
const TINY: f64 = 1e-33;
/// Above this, `tanh` is 1 and `exp(-2 x)` vanishes beside 1.
const SATURATED: f64 = 40.0;
/// Above this, `sqrt(x^2 ± 1)` is `x`.
const HUGE: f64 = 1e17;

/// `Σ z^j / (first + step j)!` over `j < terms`; from the term `j = exact` on, each is so small
/// that `f64` is precise enough for it.
fn series(z: Dd, first: usize, step: usize, exact: usize, terms: usize) -> Dd {
    let coefficient = |j: usize| INVERSE_FACTORIAL[first + step * j];
    let tail = (exact..terms).rev().fold(0.0, |sum, j| sum * z.hi + coefficient(j).hi);
    (0..exact).rev().fold(Dd::of(tail), |sum, j| sum * z + coefficient(j))
}

/// `x - k * Σ parts`, for an integer `k` and parts of decreasing size.
fn reduce(x: Dd, k: f64, parts: [f64; 3]) -> Dd {
    parts.iter().fold(x, |rest, &part| rest - Dd::product(k, part))
}

/// `exp(r) - 1` for `|r| <= 0.35`: the series at `r / 16`, then four doublings of the argument.
fn small_exp_m1(r: Dd) -> Dd {
    if r.hi.abs() < TINY {
        return r;
    }
    let z = r.times_power(1.0 / 16.0);
    (0..4).fold(z * series(z, 1, 1, 8, 15), |e, _| e.times_power(2.0) + e * e)
}

/// `ln(1 + u)` for `1 + u` from √½ to √2: with `y` the `f64` value and `e = exp(y) - 1`, it is
/// `y + ln(1 + (u - e) / (1 + e))`.
fn small_ln_1p(u: Dd) -> Dd {
    if u.hi.abs() < TINY {
        return u;
    }
    let y = libm::log1p(u.hi);
    let e = small_exp_m1(Dd::of(y));
    Dd::sum(y, (u - e).hi / (1.0 + e.hi))
}

/// The sine and the cosine of `x`.
fn sin_cos(x: Dd) -> (Dd, Dd) {
    /// Beyond this the multiples of π/2 are not counted exactly.
    const COUNTABLE: f64 = (1u64 << 50) as f64;
    if !x.hi.is_finite() {
        return (Dd::NAN, Dd::NAN);
    }
    if x.hi.abs() > COUNTABLE {
        let ((s, c), (ds, dc)) = (libm::sincos(x.hi), libm::sincos(x.lo));
        return (Dd::of(s * dc + c * ds), Dd::of(c * dc - s * ds));
    }
    let k = (x.hi * FRAC_2_PI).round();
    let r = reduce(x, k, HALF_PI_PARTS);
    let z = -(r * r);
    let (s, c) = (r * series(z, 1, 2, 9, 15), series(z, 0, 2, 9, 15));
    match (k as i64).rem_euclid(4) {
        0 => (s, c),
        1 => (c, -s),
        2 => (-s, -c),
        _ => (-c, s),
    }
}

/// The angle of a point off the axes with finite coordinates of moderate size: with `t` the `f64`
/// value, the rest is the angle of the point turned back by `t`.
fn angle(y: Dd, x: Dd) -> Dd {
    let t = libm::atan2(y.hi, x.hi);
    let (s, c) = sin_cos(Dd::of(t));
    Dd::sum(t, (y * c - x * s).hi / (x * c + y * s).hi)
}

/// `f(|x|)` with the sign of `x`, for an odd function.
fn odd(x: Dd, f: impl Fn(Dd) -> Dd) -> Dd {
    if x.hi < 0.0 { -f(-x) } else { f(x) }
}

/// `exp(x) / 2`, infinite only if this is.
fn half_exp(x: Dd) -> Dd {
    let root = x.times_power(0.5).exp();
    root.times_power(0.5) * root
}

/// Scales `x` to a moderate size by a power of `2^base`; also returns the exponent of two by which
/// the `base`-th root has to be scaled back.
fn scale_for_root(x: Dd, base: i32) -> (Dd, i32) {
    let exponent = libm::ilogb(x.hi).div_euclid(base);
    (x.scale(-exponent * base), exponent)
}

/// `base^n` by repeated squaring.
fn power(mut base: Dd, mut n: u32) -> Dd {
    let mut result = Dd::ONE;
    loop {
        if n & 1 == 1 {
            result = result * base;
        }
        n >>= 1;
        if n == 0 {
            return result;
        }
        base = base * base;
    }
}

impl Number for Dd {
    fn from_f64(value: f64) -> Self {
        Dd::of(value)
    }

    fn from_ratio(numerator: i128, denominator: i128) -> Self {
        Dd::of_ratio(numerator, denominator)
    }

    fn to_f64(self) -> f64 {
        self.hi
    }

    fn pi() -> Self {
        PI
    }

    fn abs(self) -> Self {
        if self.hi.is_sign_negative() { -self } else { self }
    }

    fn floor(self) -> Self {
        let floor = self.hi.floor();
        let below = if floor == self.hi { self.lo.floor() } else { 0.0 };
        Dd::normalized(floor, below)
    }

    fn sqrt(self) -> Self {
        if self.hi <= 0.0 || !self.hi.is_finite() {
            return Dd::of(self.hi.sqrt());
        }
        if !is_moderate(self.hi) {
            let (scaled, exponent) = scale_for_root(self, 2);
            return scaled.sqrt().scale(exponent);
        }
        let y = self.hi.sqrt();
        Dd::sum(y, (self - Dd::product(y, y)).hi / (2.0 * y))
    }

    fn cbrt(self) -> Self {
        if self.hi == 0.0 || !self.hi.is_finite() {
            return self;
        }
        if !is_moderate(self.hi) {
            let (scaled, exponent) = scale_for_root(self, 3);
            return scaled.cbrt().scale(exponent);
        }
        let y = libm::cbrt(self.hi);
        let square = Dd::product(y, y);
        Dd::sum(y, (self - square * Dd::of(y)).hi / (3.0 * square.hi))
    }

    fn exp(self) -> Self {
        if self.hi.is_nan() {
            return self;
        }
        // Above 709.79 the result overflows, and below -745.14 it vanishes.
        if self.hi.abs() > 750.0 {
            return if self.hi > 0.0 { Dd::INFINITY } else { Dd::ZERO };
        }
        let k = (self.hi * LOG2_E).round();
        (Dd::ONE + small_exp_m1(reduce(self, k, LN_2_PARTS))).scale(k as i32)
    }

    fn exp_m1(self) -> Self {
        if self.hi.abs() < 0.34 { small_exp_m1(self) } else { self.exp() - Dd::ONE }
    }

    fn ln(self) -> Self {
        if self.hi <= 0.0 || !self.hi.is_finite() {
            // Its logarithm is special, and the same as in `f64`.
            return Dd::of(libm::log(self.hi));
        }
        let exponent = libm::ilogb(self.hi);
        let above = i32::from(libm::scalbn(self.hi, -exponent) > SQRT_2);
        let exponent = exponent + above;
        let rest = small_ln_1p(self.scale(-exponent) - Dd::ONE);
        if exponent == 0 { rest } else { LN_2 * Dd::of(f64::from(exponent)) + rest }
    }

    fn ln_1p(self) -> Self {
        let small = (-0.29..=0.41).contains(&self.hi);
        if small { small_ln_1p(self) } else { (Dd::ONE + self).ln() }
    }

    fn sin(self) -> Self {
        sin_cos(self).0
    }

    fn cos(self) -> Self {
        sin_cos(self).1
    }

    fn tan(self) -> Self {
        let (s, c) = sin_cos(self);
        s / c
    }

    fn asin(self) -> Self {
        self.atan2(((Dd::ONE - self) * (Dd::ONE + self)).sqrt())
    }

    fn acos(self) -> Self {
        ((Dd::ONE - self) * (Dd::ONE + self)).sqrt().atan2(self)
    }

    fn atan(self) -> Self {
        self.atan2(Dd::ONE)
    }

    fn atan2(self, x: Self) -> Self {
        let y = self;
        if y.hi < 0.0 {
            return -(-y).atan2(x);
        }
        if y.is_nan() || x.is_nan() {
            return Dd::NAN;
        }
        // On an axis or at infinity the angle is a multiple of π/4.
        let eighths = match (y.hi, x.hi) {
            (0.0, x) => {
                if x < 0.0 {
                    4.0
                } else {
                    0.0
                }
            }
            (f64::INFINITY, f64::INFINITY) => 1.0,
            (f64::INFINITY, f64::NEG_INFINITY) => 3.0,
            (f64::INFINITY, _) | (_, 0.0) => 2.0,
            (_, f64::INFINITY) => 0.0,
            (_, f64::NEG_INFINITY) => 4.0,
            _ if is_moderate(y.hi) && is_moderate(x.hi) => return angle(y, x),
            _ => {
                let exponent = libm::ilogb(y.hi.max(x.hi.abs()));
                return angle(y.scale(-exponent), x.scale(-exponent));
            }
        };
        PI.times_power(0.25) * Dd::of(eighths)
    }

    fn sinh(self) -> Self {
        odd(self, |x| {
            if x.hi > SATURATED {
                return half_exp(x);
            }
            let e = x.exp_m1();
            (e + e / (e + Dd::ONE)).times_power(0.5)
        })
    }

    fn cosh(self) -> Self {
        let x = self.abs();
        if x.hi > SATURATED {
            return half_exp(x);
        }
        let e = x.exp();
        (e + Dd::ONE / e).times_power(0.5)
    }

    fn tanh(self) -> Self {
        odd(self, |x| {
            if x.hi > SATURATED {
                return Dd::ONE;
            }
            let e = x.times_power(2.0).exp_m1();
            e / (e + Dd::of(2.0))
        })
    }

    fn asinh(self) -> Self {
        odd(self, |x| {
            if x.hi > HUGE {
                return x.ln() + LN_2;
            }
            let square = x * x;
            (x + square / (Dd::ONE + (Dd::ONE + square).sqrt())).ln_1p()
        })
    }

    fn acosh(self) -> Self {
        if self.hi > HUGE {
            return self.ln() + LN_2;
        }
        let t = self - Dd::ONE;
        (t + (t * (t + Dd::of(2.0))).sqrt()).ln_1p()
    }

    fn atanh(self) -> Self {
        odd(self, |x| (x.times_power(2.0) / (Dd::ONE - x)).ln_1p().times_power(0.5))
    }

    fn powf(self, exponent: Self) -> Self {
        /// Up to this, repeated squaring is at least as accurate.
        const SMALL: f64 = 64.0;
        let is_integer = exponent.floor() == exponent;
        if is_integer && exponent.hi.abs() <= SMALL {
            return self.powi(exponent.hi as i32);
        }
        if self == Dd::ONE {
            return Dd::ONE;
        }
        let power = (self.abs().ln() * exponent).exp();
        if self.hi >= 0.0 {
            return power;
        }
        let half = exponent.times_power(0.5);
        match (is_integer, half.floor() == half) {
            (false, _) => Dd::NAN,
            (true, true) => power,
            (true, false) => -power,
        }
    }

    fn powi(self, exponent: i32) -> Self {
        // The reciprocal comes first: a power that overflows may have a finite reciprocal.
        let base = if exponent < 0 { Dd::ONE / self } else { self };
        power(base, exponent.unsigned_abs())
    }

    fn hypot(self, other: Self) -> Self {
        let (a, b) = (self.abs(), other.abs());
        let largest = a.hi.max(b.hi);
        if !a.is_finite() || !b.is_finite() || largest == 0.0 {
            return Dd::of(libm::hypot(a.hi, b.hi));
        }
        let exponent = libm::ilogb(largest);
        let (a, b) = (a.scale(-exponent), b.scale(-exponent));
        (a * a + b * b).sqrt().scale(exponent)
    }

    fn erf(self) -> Self {
        special::erf(self)
    }

    fn erfc(self) -> Self {
        special::erfc(self)
    }

    fn erf_inv(self) -> Self {
        special::erf_inv(self)
    }

    fn erfc_inv(self) -> Self {
        special::erfc_inv(self)
    }

    fn ln_erfc(self) -> Self {
        special::ln_erfc(self)
    }

    fn erfc_inv_exp(self) -> Self {
        special::erfc_inv_exp(self)
    }

    fn lambert_w(self) -> Self {
        special::lambert_w(self)
    }

    fn ln_gamma(self) -> Self {
        special::ln_gamma(self)
    }

    fn ln_beta(self, b: Self) -> Self {
        beta::ln_beta(self, b)
    }

    fn beta_inc(self, rest: Self, a: Self, b: Self) -> Self {
        beta::incomplete([self, rest], a, b)
    }

    fn beta_inc_inv(self, rest: Self, a: Self, b: Self) -> Self {
        beta::quantile([self, rest], a, b)
    }

    fn min(self, other: Self) -> Self {
        if self <= other || other.is_nan() { self } else { other }
    }

    fn max(self, other: Self) -> Self {
        if self >= other || other.is_nan() { self } else { other }
    }

    fn is_finite(self) -> bool {
        self.hi.is_finite()
    }

    fn is_nan(self) -> bool {
        self.hi.is_nan()
    }
}
