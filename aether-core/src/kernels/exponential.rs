//! Exponentials, logarithms, powers and hyperbolic functions.

use core::f64::consts::{LN_2, LOG2_E};

use super::{Double, polynomial};
use crate::real::Mask;

/// (e^r - 1 - r) / r² for |r| <= ln 2 / 2, to 2^-43.
const EXP: [f64; 8] = [
    0.4999999999995511,
    0.16666666666662586,
    0.04166666678626573,
    0.00833333334420298,
    0.0013888839110572009,
    0.00019841224599656011,
    2.4867870179687727e-05,
    2.7617564785876086e-06,
];

/// (atanh(s) / s - 1) / s² in s², for |s| <= (√2 - 1) / (√2 + 1), to 2^-50.
const LN: [f64; 6] = [
    0.3333333333333104,
    0.20000000005603252,
    0.1428571206916208,
    0.11111431140054358,
    0.09070096901432996,
    0.08310908576429464,
];

/// 2^n and e^r - 1 such that their combination is e^x. Beyond the range of single precision, x is
/// that of some number there.
#[inline(always)]
fn parts<D: Double>(x: D) -> (D, D) {
    let x = x.at_most(140.0).at_least(-160.0);
    let n = (x * D::of(LOG2_E)).round();
    let r = x - n * D::of(LN_2);
    (n.power_of_two(), r + r * r * polynomial(&EXP, r))
}

#[inline(always)]
pub(crate) fn exp<D: Double>(x: D) -> D {
    let (power, rest) = parts(x);
    power + power * rest
}

#[inline(always)]
pub(crate) fn exp_m1<D: Double>(x: D) -> D {
    let (power, rest) = parts(x);
    ((power - D::of(1.0)) + power * rest).copysign(x)
}

/// The logarithm of a number 1 + x, of which both are given.
#[inline(always)]
fn logarithm<D: Double>(number: D, x: D) -> D {
    let one = D::of(1.0);
    let (m, e) = number.mantissa_exponent();
    // Near one, x has digits that the sum has lost.
    let f = D::select(e.is(D::of(0.0)), x, m - one);
    let s = f / (D::of(2.0) + f);
    let z = s * s;
    let v = e * D::of(LN_2) + D::of(2.0) * (s + s * z * polynomial(&LN, z));
    let inside = D::of(0.0).lt(number).and(number.finite());
    if inside.all() {
        return v;
    }
    let zero = number.is(D::of(0.0));
    let outside = D::select(zero, D::of(f64::NEG_INFINITY), D::of(f64::NAN));
    let outside = D::select(number.is(D::of(f64::INFINITY)), number, outside);
    D::select(inside, v, outside)
}

#[inline(always)]
pub(crate) fn ln<D: Double>(x: D) -> D {
    logarithm(x, x - D::of(1.0))
}

#[inline(always)]
pub(crate) fn ln_1p<D: Double>(x: D) -> D {
    logarithm(x + D::of(1.0), x).copysign(x)
}

#[inline(always)]
pub(crate) fn cbrt<D: Double>(x: D) -> D {
    exp(ln(x.abs()) * D::of(1.0 / 3.0)).copysign(x)
}

#[inline(always)]
pub(crate) fn hypot<D: Double>(x: D, y: D) -> D {
    let infinity = D::of(f64::INFINITY);
    let infinite = x.abs().is(infinity).or(y.abs().is(infinity));
    D::select(infinite, infinity, (x * x + y * y).sqrt())
}

/// IEEE 754's `pow`, special cases included.
#[inline(always)]
pub(crate) fn powf<D: Double>(x: D, y: D) -> D {
    let [zero, one, infinity] = [0.0, 1.0, f64::INFINITY].map(D::of);
    let v = exp(y * ln(x.abs()));
    if zero.lt(x).and(x.finite()).and(y.finite()).all() {
        return v;
    }
    // From 2^24 on all numbers in single precision are even.
    let even = |y: D| D::of(16_777_216.0).le(y.abs()).or(y.is(y.round()));
    let (whole, half) = (even(y), even(y * D::of(0.5)));
    let minus = one.copysign(x).lt(zero);
    let v = D::select(minus.and(whole).and(half.not()), -v, v);
    let imaginary = x.lt(zero).and(whole.not()).and((-infinity).lt(x)).and(y.is(y));
    let v = D::select(imaginary, D::of(f64::NAN), v);
    let unit = x.abs().is(one).and(y.abs().is(infinity));
    D::select(unit.or(x.is(one)).or(y.is(zero)), one, v)
}

#[inline(always)]
pub(crate) fn sinh<D: Double>(x: D) -> D {
    let e = exp_m1(x.abs());
    (D::of(0.5) * (e + e / (e + D::of(1.0)))).copysign(x)
}

#[inline(always)]
pub(crate) fn cosh<D: Double>(x: D) -> D {
    let e = exp(x.abs());
    D::of(0.5) * (e + D::of(1.0) / e)
}

#[inline(always)]
pub(crate) fn tanh<D: Double>(x: D) -> D {
    let e = exp_m1(D::of(2.0) * x.abs());
    (e / (e + D::of(2.0))).copysign(x)
}

#[inline(always)]
pub(crate) fn asinh<D: Double>(x: D) -> D {
    let (a, one) = (x.abs(), D::of(1.0));
    // An infinite argument would be ∞ / ∞.
    let a = a.at_most(1e60);
    let v = ln_1p(a + a * a / (one + (one + a * a).sqrt()));
    D::select(x.abs().is(D::of(f64::INFINITY)), x.abs(), v).copysign(x)
}

#[inline(always)]
pub(crate) fn acosh<D: Double>(x: D) -> D {
    let t = x - D::of(1.0);
    let v = ln_1p(t + (t * (t + D::of(2.0))).sqrt());
    D::select(D::of(1.0).le(x), v, D::of(f64::NAN))
}

#[inline(always)]
pub(crate) fn atanh<D: Double>(x: D) -> D {
    let t = x.abs();
    (D::of(0.5) * ln_1p(D::of(2.0) * t / (D::of(1.0) - t))).copysign(x)
}
