//! The line.

use core::f64::consts::{FRAC_1_PI, TAU};

use super::{by_hand, quotient};

/// A density that grows by no more than e to this keeps its digits as it is printed.
const GROWTH: f64 = 30.0;

/// A number next to zero for zero, whose products are no smaller than numbers are.
#[inline(always)]
fn not_zero(s: f64) -> f64 {
    if s == 0.0 { 1e-150 } else { s }
}

/// The larger one of two numbers, or the second, if the first is none.
#[inline(always)]
pub(super) fn larger(x: f64, y: f64) -> f64 {
    if x > y { x } else { y }
}

/// A linear density between two ends, at a uniform: the place, and the density there. Of ends of any size, next to which their
/// squares need not be numbers, the larger one is taken as one; either may be zero, and between two of zero there is no density.
#[inline(always)]
pub(super) fn linear(u: f64, a: f64, b: f64) -> (f64, f64) {
    let m = larger(a, b);
    let (p, q) = (a / m, b / m);
    let s = ((1.0 - u) * p * p + u * q * q).sqrt();
    (u * (p + q) / larger(p + s, f64::MIN_POSITIVE), larger(2.0 * s / (p + q), 0.0))
}

by_hand! {
    /// Row 1: uniform on an interval.
    Affine(a: f64, b: f64): [1] => f64;
    sample(u) { a + (b - a) * u[0] }
    pdf(x) {
        let t = (x - a) / (b - a);
        if (0.0..=1.0).contains(&t) { 1.0 / (b - a).abs() } else { 0.0 }
    }
    draw(u) { (a + (b - a) * u[0], 1.0 / (b - a).abs()) }

    /// Row 2: a power, of either sign: samples lie below one or above it.
    Power(k: f64): [1] => f64;
    sample(u) { u[0].powf(1.0 / k) }
    pdf(x) {
        if *x >= 0.0 && (x - 1.0) * k <= 0.0 { k.abs() * x.powf(k - 1.0) } else { 0.0 }
    }
    draw(u) {
        let x = u[0].powf(1.0 / k);
        // x to the power of k - 1.
        (x, k.abs() * quotient(u[0], x, || x.powf(k - 1.0)))
    }

    /// Row 3: free flight.
    Exponential(s: f64): [1] => f64;
    sample(u) { -(-u[0]).ln_1p() / s }
    pdf(x) { if *x >= 0.0 && x.is_finite() { s * (-s * x).exp() } else { 0.0 } }
    draw(u) { (-(-u[0]).ln_1p() / s, s * (1.0 - u[0])) }

    /// Row 4: free flight within a distance. Nothing is declared of the rate and the distance: the rate may be zero, where there
    /// is a limit, and either may be negative. Where the density grows by more than numbers hold it is that of the flight back.
    TruncatedExponential(s: f64, d: f64): [1] => f64;
    sample(u) {
        let s = not_zero(s);
        let k = s * d;
        if k > -GROWTH {
            -(u[0] * (-k).exp_m1()).ln_1p() / s
        } else {
            d - (u[0] + (1.0 - u[0]) * k.exp()).ln() / s
        }
    }
    pdf(x) {
        let s = not_zero(s);
        let (t, k) = (x / d, s * d);
        if !(0.0..=1.0).contains(&t) {
            return 0.0;
        }
        if k > -GROWTH {
            (s * (-s * x).exp() / (-k).exp_m1()).abs()
        } else {
            (s * (k - s * x).exp() / k.exp_m1()).abs()
        }
    }
    draw(u) {
        let s = not_zero(s);
        let k = s * d;
        if k > -GROWTH {
            let mass = (-k).exp_m1();
            let t = u[0] * mass;
            (-t.ln_1p() / s, (s * (1.0 + t) / mass).abs())
        } else {
            let e = u[0] + (1.0 - u[0]) * k.exp();
            (d - e.ln() / s, (s * e / k.exp_m1()).abs())
        }
    }

    /// Row 5: a line.
    Linear(a: f64, b: f64): [1] => f64;
    sample(u) { linear(u[0], a, b).0 }
    pdf(x) {
        if !(0.0..=1.0).contains(x) {
            return 0.0;
        }
        larger(2.0 * ((1.0 - x) * a + x * b) / (a + b), 0.0)
    }
    draw(u) { linear(u[0], a, b) }

    /// Row 6: a tent.
    Tent(r: f64): [1] => f64;
    sample(u) {
        if u[0] < 0.5 {
            r * ((2.0 * u[0]).sqrt() - 1.0)
        } else {
            r * (1.0 - (2.0 * (1.0 - u[0])).sqrt())
        }
    }
    pdf(x) {
        let t = x.abs() / r;
        if t <= 1.0 { (1.0 - t) / r } else { 0.0 }
    }
    draw(u) {
        if u[0] < 0.5 {
            let s = (2.0 * u[0]).sqrt();
            (r * (s - 1.0), s / r)
        } else {
            let s = (2.0 * (1.0 - u[0])).sqrt();
            (r * (1.0 - s), s / r)
        }
    }

    /// Row 15: Student's t with two degrees of freedom.
    Student2(): [1] => f64;
    sample(u) { (2.0 * u[0] - 1.0) / (2.0 * u[0] * (1.0 - u[0])).sqrt() }
    pdf(x) {
        if !x.is_finite() {
            return 0.0;
        }
        let s = 2.0 + x * x;
        1.0 / (s * s.sqrt())
    }
    draw(u) {
        let v = 2.0 * u[0] * (1.0 - u[0]);
        let r = v.sqrt();
        // 2 + x² is 1 / v.
        ((2.0 * u[0] - 1.0) / r, v * r)
    }

    /// Row 17: Laplace.
    Laplace(b: f64): [1] => f64;
    sample(u) {
        if u[0] < 0.5 { b * (2.0 * u[0]).ln() } else { -b * (2.0 * (1.0 - u[0])).ln() }
    }
    pdf(x) { if x.is_finite() { (-x.abs() / b).exp() / (2.0 * b) } else { 0.0 } }
    draw(u) {
        if u[0] < 0.5 {
            (b * (2.0 * u[0]).ln(), u[0] / b)
        } else {
            (-b * (2.0 * (1.0 - u[0])).ln(), (1.0 - u[0]) / b)
        }
    }

    /// Row 18: Weibull.
    Weibull(l: f64, k: f64): [1] => f64;
    sample(u) { l * (-(-u[0]).ln_1p()).powf(1.0 / k) }
    pdf(x) {
        if *x >= 0.0 && x.is_finite() {
            let t = x / l;
            let p = t.powf(k - 1.0);
            k / l * p * (-p * t).exp()
        } else {
            0.0
        }
    }
    draw(u) {
        let e = -(-u[0]).ln_1p();
        let t = e.powf(1.0 / k);
        (l * t, k / l * quotient(e, t, || t.powf(k - 1.0)) * (1.0 - u[0]))
    }

    /// Row 33: the cosine of a uniform angle.
    Cosine(): [1] => f64;
    sample(u) { (TAU * u[0]).cos() }
    pdf(x) {
        if x.abs() <= 1.0 { FRAC_1_PI / ((1.0 - x) * (1.0 + x)).sqrt() } else { 0.0 }
    }
    draw(u) {
        let (s, c) = (TAU * u[0]).sin_cos();
        (c, FRAC_1_PI / s.abs())
    }
}
