//! The precision of the programs that are generated: `f64` on the functions of `libm`.

use super::{Dd, Number, ratio};

impl Number for f64 {
    fn from_f64(value: f64) -> Self {
        value
    }

    fn from_ratio(numerator: i128, denominator: i128) -> Self {
        ratio::quotient(numerator, denominator).0
    }

    fn to_f64(self) -> f64 {
        self
    }

    fn pi() -> Self {
        std::f64::consts::PI
    }

    fn powi(self, exponent: i32) -> Self {
        match exponent {
            1 => self,
            2 => self * self,
            _ => libm::pow(self, f64::from(exponent)),
        }
    }

    fn is_finite(self) -> bool {
        f64::is_finite(self)
    }

    fn is_nan(self) -> bool {
        f64::is_nan(self)
    }

    fn abs(self) -> Self {
        libm::fabs(self)
    }

    fn floor(self) -> Self {
        libm::floor(self)
    }

    fn sqrt(self) -> Self {
        libm::sqrt(self)
    }

    fn cbrt(self) -> Self {
        libm::cbrt(self)
    }

    fn exp(self) -> Self {
        libm::exp(self)
    }

    fn exp_m1(self) -> Self {
        libm::expm1(self)
    }

    fn ln(self) -> Self {
        libm::log(self)
    }

    fn ln_1p(self) -> Self {
        libm::log1p(self)
    }

    fn sin(self) -> Self {
        libm::sin(self)
    }

    fn cos(self) -> Self {
        libm::cos(self)
    }

    fn tan(self) -> Self {
        libm::tan(self)
    }

    fn asin(self) -> Self {
        libm::asin(self)
    }

    fn acos(self) -> Self {
        libm::acos(self)
    }

    fn atan(self) -> Self {
        libm::atan(self)
    }

    fn sinh(self) -> Self {
        libm::sinh(self)
    }

    fn cosh(self) -> Self {
        libm::cosh(self)
    }

    fn tanh(self) -> Self {
        libm::tanh(self)
    }

    fn asinh(self) -> Self {
        libm::asinh(self)
    }

    fn acosh(self) -> Self {
        libm::acosh(self)
    }

    fn atanh(self) -> Self {
        libm::atanh(self)
    }

    fn atan2(self, x: Self) -> Self {
        libm::atan2(self, x)
    }

    fn powf(self, exponent: Self) -> Self {
        libm::pow(self, exponent)
    }

    fn hypot(self, other: Self) -> Self {
        libm::hypot(self, other)
    }

    fn erf(self) -> Self {
        libm::erf(self)
    }

    fn erfc(self) -> Self {
        libm::erfc(self)
    }

    fn erf_inv(self) -> Self {
        Dd::from_f64(self).erf_inv().to_f64()
    }

    fn erfc_inv(self) -> Self {
        Dd::from_f64(self).erfc_inv().to_f64()
    }

    fn ln_erfc(self) -> Self {
        Dd::from_f64(self).ln_erfc().to_f64()
    }

    fn erfc_inv_exp(self) -> Self {
        Dd::from_f64(self).erfc_inv_exp().to_f64()
    }

    fn lambert_w(self) -> Self {
        Dd::from_f64(self).lambert_w().to_f64()
    }

    fn ln_gamma(self) -> Self {
        libm::lgamma(self)
    }

    fn ln_beta(self, b: Self) -> Self {
        Dd::from_f64(self).ln_beta(Dd::from_f64(b)).to_f64()
    }

    fn beta_inc(self, rest: Self, a: Self, b: Self) -> Self {
        let [x, rest, a, b] = [self, rest, a, b].map(Dd::from_f64);
        x.beta_inc(rest, a, b).to_f64()
    }

    fn beta_inc_inv(self, rest: Self, a: Self, b: Self) -> Self {
        let [x, rest, a, b] = [self, rest, a, b].map(Dd::from_f64);
        x.beta_inc_inv(rest, a, b).to_f64()
    }

    fn min(self, other: Self) -> Self {
        libm::fmin(self, other)
    }

    fn max(self, other: Self) -> Self {
        libm::fmax(self, other)
    }
}
