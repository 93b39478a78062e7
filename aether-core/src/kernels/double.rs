//! Sines, cosines and the angle of a point in double precision, for one number: they cost less here than in the host's
//! library.
//!
//! They have no tables and become part of what calls them, so that a sine and a cosine share their reduction and nothing
//! is saved around a call. Sines and cosines are off by less than one unit in the last place, the angle by less
//! than two, and all by less than [`f64::EPSILON`] of their value. Arguments that are rare go to the host.
//!
//! Reductions are those of single precision, but what they lose is kept: π/2 has three parts, and the products of two of
//! them with n are exact (Cody and Waite 1980); a sum whose first number is the larger one tells what it has rounded
//! away (Dekker 1971). An inverse tangent is that of the difference to 0, 1/2 or 1. Polynomials are minimax
//! approximations (Remez), computed with 60 digits.

use core::f64::consts::{FRAC_2_PI, FRAC_PI_2, PI};

use super::{Double, ROUND_SHIFT, outside, polynomial};

/// (sin(r) / r - 1) / r² in r², for |r| <= π/4, to 2^-58 of the sine.
const SIN: [f64; 6] = [
    -0.16666666666666632,
    0.008333333333322554,
    -0.00019841269829898723,
    2.7557313718807547e-06,
    -2.5050761813369086e-08,
    1.5896987886260394e-10,
];

/// (cos(r) - 1 + r²/2) / r⁴ in r², for |r| <= π/4, to 2^-64.
const COS: [f64; 6] = [
    0.041666666666666616,
    -0.0013888888888876133,
    2.4801587290576307e-05,
    -2.7557314634395224e-07,
    2.0875758065987046e-09,
    -1.1361303322942938e-11,
];

/// (atan(t) / t - 1) / t² in t², for |t| <= 0.27, to 2^-61.
const ATAN: [f64; 9] = [
    -0.33333333333333304,
    0.19999999999978985,
    -0.14285714281296413,
    0.11111110672224185,
    -0.09090884846015666,
    0.07691504997756841,
    -0.06650309289449473,
    0.05679933357305761,
    -0.03839857825270327,
];

/// π/2 = HIGH + MIDDLE + LOW; the first two have 42 bits.
const HIGH: f64 = 1.570796326794607;
const MIDDLE: f64 = 2.8960739716218175e-13;
const LOW: f64 = 1.6446256936324258e-26;
/// Below this angle n has 11 bits.
const LARGE: f64 = 3000.0;

/// The inverse tangent of 1/2, and what that of 1 has more.
const ATAN_HALF: f64 = 0.4636476090008061;
const ATAN_MORE: f64 = 0.3217505543966422;

/// The sine and cosine of an angle in radians, to less than one unit in the last place.
#[inline(always)]
pub(crate) fn sin_cos(x: f64) -> (f64, f64) {
    if x.abs() < LARGE { moderate(x) } else { (outside(x, f64::sin), outside(x, f64::cos)) }
}

#[inline(always)]
fn moderate(x: f64) -> (f64, f64) {
    let shifted = x * FRAC_2_PI + ROUND_SHIFT;
    let n = shifted - ROUND_SHIFT;
    // Exact: of numbers that differ by less than their half.
    let a = x - n * HIGH;
    let r = a - n * MIDDLE;
    // The angle is r - lost.
    let lost = n * LOW + (n * MIDDLE - (a - r));
    let z = r * r;
    let sin = r - (lost - r * z * polynomial(&SIN, z));
    let half = 0.5 * z;
    let near = 1.0 - half;
    let cos = near + (((1.0 - near) - half) + (z * z * polynomial(&COS, z) + r * lost));
    f64::turned(shifted, sin, cos)
}

/// The angle of the point (x, y) from the x axis, to less than two units in the last place.
#[inline(always)]
pub(crate) fn atan2(y: f64, x: f64) -> f64 {
    let (a, b) = (y.abs(), x.abs());
    let steep = b < a;
    let (low, high) = if steep { (b, a) } else { (a, b) };
    if !(high < 1e300 && high > 1e-300) || low.is_nan() {
        return beyond(y, x);
    }
    // Differences to multiples by 1/2 and 1 of numbers as near as this are exact.
    let (second, third) = (low > 0.265 * high, low > 0.7 * high);
    let number = |mask: bool, x: f64| if mask { x } else { 0.0 };
    let c = number(second, 0.5) + number(third, 0.5);
    let t = (low - c * high) / (high + c * low);
    let z = t * t;
    let v =
        (number(second, ATAN_HALF) + number(third, ATAN_MORE)) + (t + t * z * polynomial(&ATAN, z));
    let v = if steep { FRAC_PI_2 - v } else { v };
    let v = if x < 0.0 { PI - v } else { v };
    v.copysign(y)
}

#[cold]
fn beyond(y: f64, x: f64) -> f64 {
    y.atan2(x)
}
