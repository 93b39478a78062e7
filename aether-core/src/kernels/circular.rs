//! Trigonometric functions and their inverses.

use core::f64::consts::{FRAC_2_PI, FRAC_PI_2, FRAC_PI_4, PI};

use super::{Double, polynomial};

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

/// n / 2, rounded down.
#[inline(always)]
fn half<D: Double>(n: D) -> D {
    (n * D::of(0.5) - D::of(0.25)).round()
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
    let n = n + D::of(quarters);
    let h = half(n);
    let odd = h.lt(n * D::of(0.5));
    let minus = half(h).lt(h * D::of(0.5));
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
    let odd = half(n).lt(n * D::of(0.5));
    let v = D::select(odd, -cos, sin) / D::select(odd, sin, cos);
    v.replace(D::of(LARGE).le(x.abs()), x, libm::tan)
}

/// The angle of the point (x, y) from the x axis, for y that is not negative.
#[inline(always)]
fn angle<D: Double>(y: D, x: D) -> D {
    // Large enough that a finite number is nothing beside it, small enough to divide.
    let (a, b) = (y.at_most(1e150), x.abs().at_most(1e150));
    let steep = b.lt(a);
    let low = D::select(steep, b, a);
    let high = D::select(steep, a, b);
    let high = D::select(high.is(D::of(0.0)), D::of(1.0), high);
    let shifted = (high * D::of(EIGHTH)).lt(low);
    let t = D::select(shifted, low - high, low) / D::select(shifted, low + high, high);
    let z = t * t;
    let v = t + t * z * polynomial(&ATAN, z);
    let v = D::select(shifted, D::of(FRAC_PI_4) + v, v);
    let v = D::select(steep, D::of(FRAC_PI_2) - v, v);
    D::select(D::of(1.0).copysign(x).lt(D::of(0.0)), D::of(PI) - v, v)
}

#[inline(always)]
pub(crate) fn atan2<D: Double>(y: D, x: D) -> D {
    angle(y.abs(), x).copysign(y)
}

#[inline(always)]
pub(crate) fn atan<D: Double>(x: D) -> D {
    atan2(x, D::of(1.0))
}

/// √(1 - x²), exact to rounding.
#[inline(always)]
fn other_side<D: Double>(x: D) -> D {
    ((D::of(1.0) - x) * (D::of(1.0) + x)).sqrt()
}

#[inline(always)]
pub(crate) fn asin<D: Double>(x: D) -> D {
    atan2(x, other_side(x))
}

#[inline(always)]
pub(crate) fn acos<D: Double>(x: D) -> D {
    angle(other_side(x), x)
}
