//! The error function, its relatives, Lambert's W and ln Γ in double-double.
//!
//! Relative errors are below 1e-28 except next to a zero of ln Γ and next to the branch point of W,
//! where the errors are as small against one.

use super::Dd;
use super::constants::PI;
use crate::number::Number;

/// 2/√π.
const TWO_OVER_ROOT_PI: Dd = Dd { hi: std::f64::consts::FRAC_2_SQRT_PI, lo: 1.533545961316588e-17 };
/// 1/e.
const INVERSE_E: Dd = Dd { hi: 0.36787944117144233, lo: -1.2428753672788363e-17 };
/// ln(2π) / 2.
const HALF_LN_TAU: Dd = Dd { hi: 0.9189385332046728, lo: -3.8782941580672414e-17 };

/// From here on erfc is a continued fraction, and below it one minus a series.
const BORDER: f64 = 2.0;

/// erf(x) = 2/√π exp(-x²) x Σ (2x²)ⁿ / (1 · 3 ⋯ (2n + 1)), whose terms are all positive.
fn erf_series(x: Dd) -> Dd {
    let square = x * x;
    let twice = square.times_power(2.0);
    let (mut term, mut sum, mut odd) = (Dd::ONE, Dd::ONE, 3.0);
    while term.hi > 1e-34 * sum.hi {
        term = term * twice / Dd::of(odd);
        sum = sum + term;
        odd += 2.0;
    }
    TWO_OVER_ROOT_PI * (-square).exp() * x * sum
}

/// exp(x²) erfc(x) = 1/√π / (x + (1/2)/(x + 1/(x + (3/2)/(x + …)))), for x >= 2.
fn scaled_erfc(x: Dd) -> Dd {
    let terms = 30 + (720.0 / (x.hi * x.hi)) as u32;
    let rest = (1..=terms).rev().fold(Dd::ZERO, |rest, n| Dd::of(0.5 * f64::from(n)) / (x + rest));
    TWO_OVER_ROOT_PI.times_power(0.5) / (x + rest)
}

/// erfc(x), for x >= 2.
fn erfc_fraction(x: Dd) -> Dd {
    (-(x * x)).exp() * scaled_erfc(x)
}

pub(super) fn erf(x: Dd) -> Dd {
    if x.is_nan() || x.hi == 0.0 {
        return x;
    }
    if x.hi.abs() < BORDER {
        return erf_series(x);
    }
    // Beyond this erfc vanishes.
    let tail = if x.hi.abs() > 28.0 { Dd::ZERO } else { erfc_fraction(x.abs()) };
    if x.hi < 0.0 { tail - Dd::ONE } else { Dd::ONE - tail }
}

pub(super) fn erfc(x: Dd) -> Dd {
    if (BORDER..=28.0).contains(&x.hi) { erfc_fraction(x) } else { Dd::ONE - erf(x) }
}

/// The inverse of erf for |x| <= 1/2: Newton's method, at last on a residual in double-double.
fn erf_inv_small(x: Dd) -> Dd {
    if x.hi == 0.0 {
        return x;
    }
    let reciprocal_slope = |w: f64| libm::exp(w * w) / TWO_OVER_ROOT_PI.hi;
    let mut w = x.hi * 0.9;
    for _ in 0..6 {
        w += (x.hi - libm::erf(w)) * reciprocal_slope(w);
    }
    Dd::sum(w, (x - erf_series(Dd::of(w))).hi * reciprocal_slope(w))
}

/// The inverse of erfc for 0 < y <= 1/2: Newton's method on ln erfc, which is concave, and then two
/// of Halley's steps.
fn erfc_inv_small(y: Dd) -> Dd {
    let log = y.ln().hi;
    let mut w = libm::sqrt(-log);
    for _ in 0..40 {
        let e = libm::erfc(w);
        let step = (libm::log(e) - log) * e * libm::exp(w * w) / TWO_OVER_ROOT_PI.hi;
        if e == 0.0 || step.is_nan() {
            w *= 0.99;
            continue;
        }
        w += step;
        if step.abs() < 1e-14 * w {
            break;
        }
    }
    (0..2).fold(Dd::of(w), |w, _| {
        let slope = TWO_OVER_ROOT_PI * (-(w * w)).exp();
        let r = (erfc(w) - y) / slope;
        if r.is_finite() { w + r + w * r * r } else { w }
    })
}

pub(super) fn erf_inv(x: Dd) -> Dd {
    if x.hi < 0.0 {
        return -erf_inv(-x);
    }
    if x.hi <= 0.5 { erf_inv_small(x) } else { erfc_inv(Dd::ONE - x) }
}

pub(super) fn erfc_inv(y: Dd) -> Dd {
    if y.hi < 0.0 || y.is_nan() || y > Dd::of(2.0) {
        return Dd::NAN;
    }
    if y.hi == 0.0 {
        return Dd::INFINITY;
    }
    if y.hi > 1.0 {
        return -erfc_inv(Dd::of(2.0) - y);
    }
    if y.hi > 0.5 { erf_inv_small(Dd::ONE - y) } else { erfc_inv_small(y) }
}

pub(super) fn ln_erfc(x: Dd) -> Dd {
    match x.hi {
        ..0.5 => (-erf(x)).ln_1p(),
        ..BORDER => erfc(x).ln(),
        _ => scaled_erfc(x).ln() - x * x,
    }
}

/// The inverse of erfc of exp(l), which may be smaller than any number: there by Newton's method on ln erfc.
pub(super) fn erfc_inv_exp(l: Dd) -> Dd {
    if l.hi > -0.5 {
        return erf_inv(-l.exp_m1());
    }
    if l.hi >= -600.0 || l.is_nan() {
        return erfc_inv(l.exp());
    }
    let start = libm::sqrt(-l.hi - 0.5 * libm::log(-PI.hi * l.hi));
    (0..4).fold(Dd::of(start), |w, _| {
        let step = (ln_erfc(w) - l) * scaled_erfc(w) / TWO_OVER_ROOT_PI;
        if step.is_finite() { w + step } else { w }
    })
}

pub(super) fn lambert_w(x: Dd) -> Dd {
    if x.is_nan() || x.hi.abs() < 1e-33 || x.hi == f64::INFINITY {
        return x;
    }
    let above = x + INVERSE_E;
    if above < Dd::ZERO {
        return Dd::NAN;
    }
    let p = (above.times_power(2.0) / INVERSE_E).sqrt();
    if p.hi == 0.0 {
        return -Dd::ONE;
    }
    let start = if x.hi < -0.25 {
        // The series about the branch point, cut off.
        let c = [-1.0 / 3.0, 11.0 / 72.0, -43.0 / 540.0, 769.0 / 17280.0];
        let rest = c.iter().rev().fold(0.0, |s, c| s * p.hi + c);
        p - Dd::ONE + p * p * Dd::of(rest)
    } else {
        let l = libm::log1p(x.hi);
        Dd::of(l * (1.0 - libm::log1p(l) / (2.0 + l)))
    };
    // Steps of fourth order of Fritsch, Shafer and Crowley (1973).
    (0..4).fold(start, |w, _| {
        let z = (x / w).ln() - w;
        let one = w + Dd::ONE;
        let q = one.times_power(2.0) * (one + z * Dd::of_ratio(2, 3));
        let next = w + w * (z / one) * ((q - z) / (q - z.times_power(2.0)));
        if next.is_finite() { next } else { w }
    })
}

/// The Bernoulli numbers B₂, B₄, …, B₃₀.
const BERNOULLI: [(i128, i128); 15] = [
    (1, 6),
    (-1, 30),
    (1, 42),
    (-1, 30),
    (5, 66),
    (-691, 2730),
    (7, 6),
    (-3617, 510),
    (43867, 798),
    (-174611, 330),
    (854513, 138),
    (-236364091, 2730),
    (8553103, 6),
    (-23749461029, 870),
    (8615841276005, 14322),
];

/// Stirling's series at an argument of at least 24, and the recurrence below.
pub(super) fn ln_gamma(x: Dd) -> Dd {
    if x.is_nan() || x.hi == f64::INFINITY {
        return x;
    }
    if x.hi < 0.0 {
        // ln |Γ| by reflection; a pole at the negative integers.
        let s = (PI * (x - x.floor())).sin().abs();
        return (PI / s).ln() - ln_gamma(Dd::ONE - x);
    }
    if x.hi == 0.0 {
        return Dd::INFINITY;
    }
    let (mut z, mut product) = (x, Dd::ONE);
    while z.hi < 24.0 {
        product = product * z;
        z = z + Dd::ONE;
    }
    let inverse = Dd::ONE / z;
    let square = inverse * inverse;
    let terms = BERNOULLI.iter().enumerate().rev().map(|(i, &(n, d))| {
        let k = i as i128 + 1;
        Dd::of_ratio(n, d * 2 * k * (2 * k - 1))
    });
    let series = terms.fold(Dd::ZERO, |sum, c| sum * square + c) * inverse;
    (z - Dd::of(0.5)) * z.ln() - z + HALF_LN_TAU + series - product.ln()
}
