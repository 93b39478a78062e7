//! Numbers of 31 digits as a [`Real`], so that emitted code runs on them: the oracle of the stability
//! report. [`Dual`] carries a derivative as well.
//!
//! Emitted code writes constants with the digits of `f64`; here they are what is meant, so that a parameter
//! or a uniform must not be made by `of` but by [`exactly`].
//!
//! Special functions ([`aether_core::special`]) are the compiler's, which have these digits; their parameters
//! are taken as constant.

use core::cell::RefCell;
use core::iter::Sum;
use core::ops::{Add, AddAssign, Div, DivAssign, Mul, MulAssign, Neg, Sub, SubAssign};

use aether_core::special::Function;
use aether_core::{Real, Scalar, Single};
use aether_engine::number::{Dd, Number};

/// A double-double.
#[derive(Clone, Copy, Debug, PartialEq, PartialOrd)]
pub struct Precise(pub Dd);

/// A double-double with its derivative along some direction.
#[derive(Clone, Copy, Debug)]
pub struct Dual {
    /// The value.
    pub value: Precise,
    /// The derivative.
    pub slope: Precise,
}

impl Precise {
    /// The number `x`, exactly.
    pub const fn f64(x: f64) -> Self {
        Precise(Dd::of(x))
    }

    /// The constant that emitted code means by `x`, which it writes with the digits of `f64`: a simple
    /// fraction, or a multiple of π or of its inverse.
    fn meant(x: f64) -> Self {
        if x * 4096.0 == (x * 4096.0).floor() {
            return Precise::f64(x);
        }
        // The same few constants are asked for again and again.
        thread_local! {
            static LATELY: RefCell<[(f64, Dd); 64]> = const { RefCell::new([(0.0, Dd::ZERO); 64]) };
        }
        let place = (x.to_bits().wrapping_mul(0x9e37_79b9_7f4a_7c15) >> 58) as usize;
        LATELY.with_borrow_mut(|lately| {
            if lately[place].0 != x {
                lately[place] = (x, Precise::recognised(x));
            }
            Precise(lately[place].1)
        })
    }

    /// The simple fraction or multiple that has these digits, or the number itself.
    fn recognised(x: f64) -> Dd {
        let fraction = |x: f64| {
            let fits = |q: &f64| (x * q).round() / q == x && (x * q).abs() < 1e4;
            (1..100).map(f64::from).find(fits).map(|q| Dd::of((x * q).round()) / Dd::of(q))
        };
        let pi = <Dd as Number>::pi();
        let multiple = |unit: Dd| {
            let unit64 = Number::to_f64(unit);
            let factor = fraction(x / unit64)?;
            let close = (Number::to_f64(factor) * unit64 - x).abs() <= f64::EPSILON * x.abs();
            close.then(|| factor * unit)
        };
        let found = fraction(x).or_else(|| multiple(pi)).or_else(|| multiple(Dd::ONE / pi));
        found.unwrap_or(Dd::of(x))
    }
}

impl Dual {
    /// A number with derivative one.
    pub fn variable(value: Precise) -> Self {
        Dual { value, slope: Precise::ONE }
    }

    /// A number with derivative zero.
    pub const fn constant(value: Precise) -> Self {
        Dual { value, slope: Precise::f64(0.0) }
    }

    /// A function of this one, with its derivative; what is constant stays so even at a pole.
    fn chain(self, value: Precise, derivative: Precise) -> Self {
        let slope = if self.slope == Precise::ZERO { self.slope } else { derivative * self.slope };
        Dual { value, slope }
    }
}

/// Comparisons look at values alone.
impl PartialEq for Dual {
    fn eq(&self, other: &Self) -> bool {
        self.value == other.value
    }
}
impl PartialOrd for Dual {
    fn partial_cmp(&self, other: &Self) -> Option<core::cmp::Ordering> {
        self.value.partial_cmp(&other.value)
    }
}

macro_rules! arithmetic {
    ($number:ident; $($trait:ident $name:ident $assign:ident $assigned:ident: |$a:ident, $b:ident| $value:expr;)*) => {$(
        impl $trait for $number {
            type Output = Self;
            fn $name(self, other: Self) -> Self {
                let ($a, $b) = (self, other);
                $value
            }
        }
        impl $assign for $number {
            fn $assigned(&mut self, other: Self) {
                *self = $trait::$name(*self, other);
            }
        }
    )*};
}

arithmetic! { Precise;
    Add add AddAssign add_assign: |a, b| Precise(a.0 + b.0);
    Sub sub SubAssign sub_assign: |a, b| Precise(a.0 - b.0);
    Mul mul MulAssign mul_assign: |a, b| Precise(a.0 * b.0);
    Div div DivAssign div_assign: |a, b| Precise(a.0 / b.0);
}
arithmetic! { Dual;
    Add add AddAssign add_assign: |a, b| Dual { value: a.value + b.value, slope: a.slope + b.slope };
    Sub sub SubAssign sub_assign: |a, b| Dual { value: a.value - b.value, slope: a.slope - b.slope };
    Mul mul MulAssign mul_assign: |a, b| {
        let slope = a.chain(a.value, b.value).slope + b.chain(b.value, a.value).slope;
        Dual { value: a.value * b.value, slope }
    };
    Div div DivAssign div_assign: |a, b| {
        let value = a.value / b.value;
        let slope = a.chain(value, b.value.recip()).slope - b.chain(value, value / b.value).slope;
        Dual { value, slope }
    };
}

impl Neg for Precise {
    type Output = Self;
    fn neg(self) -> Self {
        Precise(-self.0)
    }
}
impl Neg for Dual {
    type Output = Self;
    fn neg(self) -> Self {
        Dual { value: -self.value, slope: -self.slope }
    }
}

macro_rules! number {
    ($number:ident) => {
        impl Default for $number {
            fn default() -> Self {
                Self::ZERO
            }
        }
        impl Sum for $number {
            fn sum<I: Iterator<Item = Self>>(items: I) -> Self {
                items.fold(Self::ZERO, |a, b| a + b)
            }
        }
        impl Scalar for $number {
            fn next_below(self) -> Self {
                self - self.abs() * Self::EPSILON
            }
        }
        /// Errors are not followed: what rounding decides has been decided with 31 digits.
        impl Single for $number {
            type Tracked = Self;
            fn track(self) -> Self {
                self
            }
            fn track_within(self, _: Self) -> Self {
                self
            }
            fn value_and_error(tracked: Self) -> (Self, Self) {
                (tracked, tracked.abs() * Self::EPSILON * Self::of(1e3))
            }
        }
    };
}
number!(Precise);
number!(Dual);

/// What both numbers have in common of [`Real`].
macro_rules! common {
    () => {
        type Mask = bool;
        type Lane = Self;
        const LANES: usize = 1;
        fn lane(self, _: usize) -> Self {
            self
        }
        fn with_lane(self, _: usize, value: Self) -> Self {
            value
        }
        fn lt(self, other: Self) -> bool {
            self < other
        }
        fn le(self, other: Self) -> bool {
            self <= other
        }
        fn select(mask: bool, yes: Self, no: Self) -> Self {
            if mask { yes } else { no }
        }
        fn min(self, other: Self) -> Self {
            if self <= other || other != other { self } else { other }
        }
        fn max(self, other: Self) -> Self {
            if self >= other || other != other { self } else { other }
        }
    };
}

macro_rules! forward {
    ($($name:ident)*) => {
        $(fn $name(self) -> Self { Precise(Number::$name(self.0)) })*
    };
}

#[allow(clippy::eq_op)]
impl Real for Precise {
    common!();
    const ZERO: Self = Precise::f64(0.0);
    const ONE: Self = Precise::f64(1.0);
    /// 2⁻¹⁰³.
    const EPSILON: Self = Precise::f64(f64::from_bits((1023 - 103) << 52));
    const INFINITY: Self = Precise::f64(f64::INFINITY);
    const MIN_POSITIVE: Self = Precise::f64(f64::MIN_POSITIVE);
    fn of(x: f64) -> Self {
        Precise::meant(x)
    }
    fn to_f64(self) -> f64 {
        Number::to_f64(self.0)
    }
    fn finite(self) -> bool {
        self.0.is_finite()
    }
    fn copysign(self, sign: Self) -> Self {
        if self.to_f64().is_sign_negative() == sign.to_f64().is_sign_negative() {
            self
        } else {
            -self
        }
    }
    forward! {
        abs floor sqrt cbrt exp exp_m1 ln ln_1p sin cos tan asin acos atan sinh cosh tanh asinh acosh atanh
    }
    fn sin_cos_pi(self) -> (Self, Self) {
        let n = (self + self + p(0.5)).floor();
        let rest = Precise(Number::pi()) * (self - n * p(0.5));
        let (sin, cos) = (rest.sin(), rest.cos());
        // A number of quarters beyond all integers is a multiple of four.
        match (n.to_f64() as i64).rem_euclid(4) {
            0 => (sin, cos),
            1 => (cos, -sin),
            2 => (-sin, -cos),
            _ => (-cos, sin),
        }
    }
    fn powf(self, exponent: Self) -> Self {
        Precise(Number::powf(self.0, exponent.0))
    }
    fn powi(self, exponent: i32) -> Self {
        Precise(Number::powi(self.0, exponent))
    }
    fn atan2(self, x: Self) -> Self {
        Precise(Number::atan2(self.0, x.0))
    }
    fn hypot(self, other: Self) -> Self {
        Precise(Number::hypot(self.0, other.0))
    }
    fn special<F: Function>(parameters: &[Self], x: Self) -> Self {
        special(F::NAME, parameters, x)
    }
}

/// The special function of this name.
///
/// # Panics
/// If there is none.
fn special(name: &str, parameters: &[Precise], x: Precise) -> Precise {
    let (root2, rest) = (p(2.0).sqrt(), p(1.0) - x);
    Precise(match (name, parameters) {
        ("erf", []) => x.0.erf(),
        ("erfc", []) => x.0.erfc(),
        ("erf_inv", []) => x.0.erf_inv(),
        ("erfc_inv", []) => x.0.erfc_inv(),
        ("ln_erfc", []) => x.0.ln_erfc(),
        ("erfc_inv_exp", []) => x.0.erfc_inv_exp(),
        ("normal_cdf", []) => p(0.5).0 * (-x / root2).0.erfc(),
        ("normal_quantile", []) => (-root2).0 * (p(2.0) * x).0.erfc_inv(),
        ("lambert_w", []) => x.0.lambert_w(),
        ("ln_gamma", []) => x.0.ln_gamma(),
        ("ln_beta", [a]) => a.0.ln_beta(x.0),
        ("beta_inc", [a, b]) => x.0.beta_inc(rest.0, a.0, b.0),
        ("beta_inc_inv", [a, b]) => x.0.beta_inc_inv(rest.0, a.0, b.0),
        ("beta_inc_rest", [a, b]) => rest.0.beta_inc(x.0, a.0, b.0),
        ("beta_inc_inv_rest", [a, b]) => rest.0.beta_inc_inv(x.0, a.0, b.0),
        _ => panic!("there is no function {name} of {} parameters", parameters.len()),
    })
}

/// The derivative of the special function of this name, by its argument and its value.
fn special_slope(name: &str, parameters: &[Precise], x: Precise, y: Precise) -> Precise {
    let half_root_pi = p(0.5) * p(core::f64::consts::PI).sqrt();
    let normal = |x: Precise| (-(x * x) / p(2.0)).exp() / p(core::f64::consts::TAU).sqrt();
    let beta = |x: Precise| {
        let [a, b] = *parameters else { return p(f64::NAN) };
        let logarithm = (a - Precise::ONE) * x.ln() + (b - Precise::ONE) * (-x).ln_1p();
        (logarithm - special("ln_beta", &[a], b)).exp()
    };
    match name {
        "erf" => (-(x * x)).exp() / half_root_pi,
        "erfc" => -((-(x * x)).exp() / half_root_pi),
        "erf_inv" => (y * y).exp() * half_root_pi,
        "erfc_inv" => -((y * y).exp() * half_root_pi),
        "ln_erfc" => -((-(x * x) - y).exp() / half_root_pi),
        "erfc_inv_exp" => -((y * y + x).exp() * half_root_pi),
        "normal_cdf" => normal(x),
        "normal_quantile" => normal(y).recip(),
        "lambert_w" => (y.exp() * (Precise::ONE + y)).recip(),
        "beta_inc" => beta(x),
        "beta_inc_inv" => beta(y).recip(),
        "beta_inc_rest" => -beta(p(1.0) - x),
        "beta_inc_inv_rest" => -beta(y).recip(),
        // Of parameters alone.
        _ => p(f64::NAN),
    }
}

macro_rules! differentiated {
    ($($name:ident: |$x:ident, $y:ident| $derivative:expr;)*) => {
        $(fn $name(self) -> Self {
            #[allow(unused_variables)]
            let ($x, $y) = (self.value, self.value.$name());
            self.chain($y, $derivative)
        })*
    };
}

/// The number `x`, exactly, in any precision that has its digits.
pub fn exactly<R: Real>(x: f64) -> R {
    if R::EPSILON.to_f64() > 1e-20 || x == 0.0 || !x.is_finite() {
        return R::of(x);
    }
    // Whole numbers and powers of two are what they are.
    let power = |n: i32| 2f64.powi(n);
    let exponent = (x.abs().log2() as i32 - 54).max(-1070);
    let half = exponent / 2;
    let whole = x * power(-half) * power(half - exponent);
    let high = (whole / power(27)).trunc();
    let low = whole - high * power(27);
    let scale = R::of(power(half)) * R::of(power(exponent - half));
    (R::of(high) * R::of(power(27)) + R::of(low)) * scale
}

/// Small integers and simple fractions.
fn p(x: f64) -> Precise {
    Precise::of(x)
}

#[allow(clippy::eq_op)]
impl Real for Dual {
    common!();
    const ZERO: Self = Dual::constant(Precise::ZERO);
    const ONE: Self = Dual::constant(Precise::ONE);
    const EPSILON: Self = Dual::constant(Precise::EPSILON);
    const INFINITY: Self = Dual::constant(Precise::INFINITY);
    const MIN_POSITIVE: Self = Dual::constant(Precise::MIN_POSITIVE);
    fn of(x: f64) -> Self {
        Dual::constant(Precise::of(x))
    }
    fn to_f64(self) -> f64 {
        self.value.to_f64()
    }
    fn finite(self) -> bool {
        self.value.finite()
    }
    fn copysign(self, sign: Self) -> Self {
        let same = self.value.to_f64().is_sign_negative() == sign.value.to_f64().is_sign_negative();
        if same { self } else { -self }
    }
    differentiated! {
        abs: |x, y| Precise::ONE.copysign(x);
        floor: |x, y| Precise::ZERO;
        sqrt: |x, y| p(0.5) / y;
        cbrt: |x, y| (p(3.0) * y * y).recip();
        exp: |x, y| y;
        exp_m1: |x, y| x.exp();
        ln: |x, y| x.recip();
        ln_1p: |x, y| (Precise::ONE + x).recip();
        sin: |x, y| x.cos();
        cos: |x, y| -x.sin();
        tan: |x, y| Precise::ONE + y * y;
        asin: |x, y| ((Precise::ONE - x) * (Precise::ONE + x)).sqrt().recip();
        acos: |x, y| -((Precise::ONE - x) * (Precise::ONE + x)).sqrt().recip();
        atan: |x, y| (Precise::ONE + x * x).recip();
        sinh: |x, y| x.cosh();
        cosh: |x, y| x.sinh();
        tanh: |x, y| (x.cosh() * x.cosh()).recip();
        asinh: |x, y| Precise::ONE.hypot(x).recip();
        acosh: |x, y| ((x - Precise::ONE) * (x + Precise::ONE)).sqrt().recip();
        atanh: |x, y| ((Precise::ONE - x) * (Precise::ONE + x)).recip();
    }
    fn sin_cos_pi(self) -> (Self, Self) {
        let ((sin, cos), pi) = (self.value.sin_cos_pi(), Precise(Number::pi()));
        (self.chain(sin, pi * cos), self.chain(cos, -(pi * sin)))
    }
    fn powf(self, exponent: Self) -> Self {
        let (x, e) = (self.value, exponent.value);
        let value = x.powf(e);
        let base = self.chain(value, e * x.powf(e - Precise::ONE)).slope;
        let power = exponent.chain(value, value * x.ln()).slope;
        Dual { value, slope: base + power }
    }
    fn powi(self, exponent: i32) -> Self {
        let slope = p(f64::from(exponent)) * self.value.powi(exponent - 1);
        self.chain(self.value.powi(exponent), slope)
    }
    fn atan2(self, x: Self) -> Self {
        let r = self.value.hypot(x.value);
        let value = self.value.atan2(x.value);
        let slope =
            self.chain(value, x.value / r / r).slope - x.chain(value, self.value / r / r).slope;
        Dual { value, slope }
    }
    fn hypot(self, other: Self) -> Self {
        let value = self.value.hypot(other.value);
        let slope = self.chain(value, self.value / value).slope
            + other.chain(value, other.value / value).slope;
        Dual { value, slope }
    }
    fn special<F: Function>(parameters: &[Self], x: Self) -> Self {
        let parameters: Vec<Precise> = parameters.iter().map(|p| p.value).collect();
        let value = special(F::NAME, &parameters, x.value);
        x.chain(value, special_slope(F::NAME, &parameters, x.value, value))
    }
}

#[cfg(test)]
mod tests;
