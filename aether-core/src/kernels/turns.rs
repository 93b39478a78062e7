//! Sines and cosines of π x, where x is a fraction of a turn.
//!
//! A turn is 2 in x, so that a whole number of quarters is subtracted without rounding; what is left is at most an
//! eighth of a turn. One polynomial each, then the quarters exchange the two and their signs, without branches:
//! which quarter an angle lies in is as good as random. The only branch is that for |x| >= 2^50.

use super::{Double, SinglePrecision, polynomial};

/// (sin(π r) / r - π) / r² in r², for |r| <= 1/4, to 2^-36 of the sine.
const SIN: [f64; 4] =
    [-5.167712779178267, 2.5501635935099567, -0.5992287960538701, 0.08122957450924484];

/// (cos(π r) - 1 + π² r² / 2) / r⁴ in r², for |r| <= 1/4, to 2^-40 of the cosine.
const COS: [f64; 4] =
    [4.058712126188299, -1.3352626518658208, 0.2353212658958232, -0.025566815236695704];

/// The same to 2^-56, after the lower half of π.
const SIN_DOUBLE: [f64; 7] = [
    PI_LOW,
    -5.167712780049969,
    2.5501640398766154,
    -0.5992645291845385,
    0.08214587730641625,
    -0.0073701436435937495,
    0.00046221110224187623,
];

/// The same to 2^-58, after the lower half of π² / 2.
const COS_DOUBLE: [f64; 7] = [
    -HALF_SQUARE_LOW,
    4.0587121264167685,
    -1.335262768854446,
    0.23533063033212023,
    -0.025806889561764343,
    0.0019295178624859266,
    -0.00010383432148459687,
];

/// π = PI + PI_LOW.
const PI: f64 = core::f64::consts::PI;
const PI_LOW: f64 = 1.2246467991473532e-16;
/// π² / 2 = HALF_SQUARE + HALF_SQUARE_LOW.
const HALF_SQUARE: f64 = 4.934802200544679;
const HALF_SQUARE_LOW: f64 = 3.1326477543698557e-16;

/// 3/2 2^51: the sum with a smaller number is a whole number of halves, which its lowest bits count.
const SHIFT: f64 = 3_377_699_720_527_872.0;
/// From here on the sum is rounded to something else.
const LARGE: f64 = 1_125_899_906_842_624.0;

/// sin(π x) and cos(π x) in single precision, rounded once.
#[inline(always)]
pub(crate) fn sin_cos_pi<S: SinglePrecision>(x: S) -> (S, S) {
    let (sin, cos) = by_quarters(x.widen(), |r| {
        let z = r * r;
        let sin = r * (S::Wide::of(PI) + z * polynomial(&SIN, z));
        let cos = (S::Wide::of(1.0) - S::Wide::of(HALF_SQUARE) * z) + z * z * polynomial(&COS, z);
        (sin, cos)
    });
    (S::narrow(sin), S::narrow(cos))
}

/// sin(π x) and cos(π x), to 1.6 units in the last place of double precision, and mostly to less than one.
#[inline(always)]
pub(crate) fn sin_cos_pi_double(x: f64) -> (f64, f64) {
    by_quarters(x, |r| {
        let z = r * r;
        let sin = r * PI + r * polynomial(&SIN_DOUBLE, z);
        // One less something is rounded, and what that has lost is told by two differences that are exact.
        let square = HALF_SQUARE * z;
        let near = 1.0 - square;
        let cos = near + (((1.0 - near) - square) + z * polynomial(&COS_DOUBLE, z));
        (sin, cos)
    })
}

#[inline(always)]
fn by_quarters<D: Double>(x: D, near_zero: impl Fn(D) -> (D, D)) -> (D, D) {
    let x = x.replace(D::of(LARGE).le(x.abs()), x, |x| x % 2.0);
    let shifted = x + D::of(SHIFT);
    let (sin, cos) = near_zero(x - (shifted - D::of(SHIFT)));
    D::turned(shifted, sin, cos)
}
