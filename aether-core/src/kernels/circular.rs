//! Trigonometric functions and their inverses.

use core::f64::consts::{FRAC_2_PI, FRAC_PI_2, FRAC_PI_4, PI};

use super::{Double, polynomial};
use crate::real::Mask;

/// (sin(r) / r - 1) / r² in r², for |r| <= π/4, to 2^-36.
const SIN: [f64; 4] =
    [-0.1666666666385529, 0.008333331874710208, -0.00019840086735384846, 2.724992580305979e-06];

/// (cos(r) - 1 + r²/2) / r⁴ in r², for |r| <= π/4, to 2^-39.
const COS: [f64; 4] =
    [0.0416666666643212, -0.001388888767201679, 2.480060037715673e-05, -2.730095920390147e-07];

/// (atan(t) / t - 1) / t² in t², for |t| <= tan(π/8), to 2^-43.
const ATAN: [f64; 8] = [
    -0.33333333333266196,
    0.19999999949854794,
    -0.142857081103604,
    0.11110819716745676,
    -0.09084101895346429,
    0.07604800046078292,
    -0.06027307460946675,
    0.03295679541870136,
];

/// π/2 = HIGH + LOW, where HIGH has 33 bits.
const HIGH: f64 = 1.570_796_326_734_125_6;
const LOW: f64 = 6.077_100_506_506_192e-11;
/// Above this, n HIGH would be rounded.
const LARGE: f64 = 1_048_576.0;

/// tan(π/8).
const EIGHTH: f64 = 0.414_213_562_373_095_03;

/// x less n quarters of a turn, and n.
#[inline(always)]
fn reduced<D: Double>(x: D) -> (D, D) {
    let n = (x * D::of(FRAC_2_PI)).round();
    ((x - n * D::of(HIGH)) - n * D::of(LOW), n)
}

#[inline(always)]
fn near_zero<D: Double>(r: D) -> (D, D) {
    let (z, one) = (r * r, D::of(1.0));
    let sin = r * (one + z * polynomial(&SIN, z));
    let cos = (one - D::of(0.5) * z) + z * z * polynomial(&COS, z);
    (sin, cos)
}

/// sin(x + quarters π/2) of a moderate angle.
#[inline(always)]
fn wave<D: Double>(x: D, quarters: f64) -> D {
    let (r, n) = reduced(x);
    let (sin, cos) = near_zero(r);
    let (odd, minus) = (n + D::of(quarters)).lowest_bits();
    let v = D::select(odd, cos, sin);
    D::select(minus, -v, v)
}

#[inline(always)]
pub(crate) fn sin<D: Double>(x: D) -> D {
    wave(x, 0.0).replace(D::of(LARGE).le(x.abs()), x, libm::sin)
}

#[inline(always)]
pub(crate) fn cos<D: Double>(x: D) -> D {
    wave(x, 1.0).replace(D::of(LARGE).le(x.abs()), x, libm::cos)
}

#[inline(always)]
pub(crate) fn tan<D: Double>(x: D) -> D {
    let (r, n) = reduced(x);
    let (sin, cos) = near_zero(r);
    let (odd, _) = n.lowest_bits();
    let v = D::select(odd, -cos, sin) / D::select(odd, sin, cos);
    v.replace(D::of(LARGE).le(x.abs()), x, libm::tan)
}

/// The inverse tangent of `low / high`, two numbers that are not negative, `low` not the larger one
/// and `high` not zero.
#[inline(always)]
fn eighth<D: Double>(low: D, high: D) -> D {
    let shifted = (high * D::of(EIGHTH)).lt(low);
    let t = D::select(shifted, low - high, low) / D::select(shifted, low + high, high);
    let z = t * t;
    D::select(shifted, D::of(FRAC_PI_4), D::of(0.0)) + (t + t * z * polynomial(&ATAN, z))
}

/// The angle of a point in the first quadrant, finite and not zero, from the x axis.
#[inline(always)]
fn quarter<D: Double>(y: D, x: D) -> D {
    let steep = x.lt(y);
    let v = eighth(D::select(steep, x, y), D::select(steep, y, x));
    D::select(steep, D::of(FRAC_PI_2) - v, v)
}

/// An angle from the x axis, or from its negative half.
#[inline(always)]
fn turned<D: Double>(angle: D, x: D) -> D {
    D::select(D::of(1.0).copysign(x).lt(D::of(0.0)), D::of(PI) - angle, angle)
}

#[inline(always)]
pub(crate) fn atan2<D: Double>(y: D, x: D) -> D {
    let (a, b) = (y.abs(), x.abs());
    let ordinary = D::of(0.0).lt(a + b).and((a + b).finite());
    let v = if ordinary.all() {
        quarter(a, b)
    } else {
        // Large enough that a finite number is nothing beside it, small enough to divide; and an angle
        // of zero for the point zero.
        let (a, b) = (a.at_most(1e150), b.at_most(1e150));
        quarter(a, D::select((a + b).is(D::of(0.0)), D::of(1.0), b))
    };
    turned(v, x).copysign(y)
}

#[inline(always)]
pub(crate) fn atan<D: Double>(x: D) -> D {
    quarter(x.abs().at_most(1e150), D::of(1.0)).copysign(x)
}

/// √(1 - x²), exact to rounding.
#[inline(always)]
fn other_side<D: Double>(x: D) -> D {
    ((D::of(1.0) - x) * (D::of(1.0) + x)).sqrt()
}

#[inline(always)]
pub(crate) fn asin<D: Double>(x: D) -> D {
    quarter(x.abs(), other_side(x)).copysign(x)
}

#[inline(always)]
pub(crate) fn acos<D: Double>(x: D) -> D {
    turned(quarter(other_side(x), x.abs()), x)
}
