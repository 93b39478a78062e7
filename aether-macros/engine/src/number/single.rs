//! Single precision, as generated programs compute in it: basic operations are those of `f32`, functions
//! are rounded once.

use std::ops::{Add, Div, Mul, Neg, Sub};

use super::Number;

/// A number of single precision.
#[derive(Clone, Copy, Debug, PartialEq, PartialOrd)]
pub struct Single(f32);

impl Single {
    fn wide(self) -> f64 {
        f64::from(self.0)
    }
}

macro_rules! operators {
    ($($name:ident $f:ident)*) => {$(
        impl $name for Single {
            type Output = Single;
            fn $f(self, other: Single) -> Single {
                Single($name::$f(self.0, other.0))
            }
        }
    )*};
}
operators!(Add add Sub sub Mul mul Div div);

impl Neg for Single {
    type Output = Single;
    fn neg(self) -> Single {
        Single(-self.0)
    }
}

/// Functions of one and of two numbers, by those of `f64`.
macro_rules! rounded {
    ($($f:ident)*; $($g:ident)*) => {
        $(fn $f(self) -> Self {
            Self::from_f64(Number::$f(self.wide()))
        })*
        $(fn $g(self, other: Self) -> Self {
            Self::from_f64(Number::$g(self.wide(), other.wide()))
        })*
    };
}

impl Number for Single {
    fn from_f64(value: f64) -> Self {
        Single(value as f32)
    }

    fn from_ratio(numerator: i128, denominator: i128) -> Self {
        Self::from_f64(f64::from_ratio(numerator, denominator))
    }

    fn to_f64(self) -> f64 {
        self.wide()
    }

    fn pi() -> Self {
        Single(std::f32::consts::PI)
    }

    fn powi(self, exponent: i32) -> Self {
        Self::from_f64(Number::powi(self.wide(), exponent))
    }

    fn is_finite(self) -> bool {
        self.0.is_finite()
    }

    fn is_nan(self) -> bool {
        self.0.is_nan()
    }

    rounded!(abs floor sqrt cbrt exp exp_m1 ln ln_1p sin cos tan asin acos atan sinh cosh tanh asinh acosh atanh erf erfc erf_inv erfc_inv ln_erfc erfc_inv_exp lambert_w ln_gamma;
        atan2 powf hypot ln_beta min max);

    fn beta_inc(self, rest: Self, a: Self, b: Self) -> Self {
        Self::from_f64(self.wide().beta_inc(rest.wide(), a.wide(), b.wide()))
    }

    fn beta_inc_inv(self, rest: Self, a: Self, b: Self) -> Self {
        Self::from_f64(self.wide().beta_inc_inv(rest.wide(), a.wide(), b.wide()))
    }
}
