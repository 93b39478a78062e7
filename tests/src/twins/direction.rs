//! Directions.

use core::f64::consts::{FRAC_1_PI, FRAC_PI_4, TAU};

use aether_core::prelude::{Direction, Vec3};

use super::plane::concentric;
use super::{by_hand, finite, quotient};

/// The direction with this sine and cosine of the angle from the pole, at a share of a turn.
#[inline(always)]
fn around(sine: f64, cosine: f64, turn: f64) -> Direction {
    let (s, c) = (TAU * turn).sin_cos();
    Direction::from_unit(Vec3::new(sine * c, sine * s, cosine))
}

/// The square of the sine of the angle from the pole.
#[inline(always)]
fn sine2(w: &Direction) -> f64 {
    w.x * w.x + w.y * w.y
}

/// The power of the cosine of a direction, next to the pole by the sine.
#[inline(always)]
fn power(w: &Direction, n: f64) -> f64 {
    if w.z > 0.5 { (n * (-sine2(w) / (1.0 + w.z)).ln_1p()).exp() } else { w.z.powf(n) }
}

/// e to minus 2 κ, and that less one: one from the other, where nothing cancels.
#[inline(always)]
fn decay(kappa: f64) -> (f64, f64) {
    if kappa > 0.35 {
        let whole = (-2.0 * kappa).exp();
        (whole, whole - 1.0)
    } else {
        let less = (-2.0 * kappa).exp_m1();
        (1.0 + less, less)
    }
}

/// Minus κ times the depth of von Mises and Fisher's direction below the pole at a uniform: next to the far pole as the logarithm of
/// what is small there.
#[inline(always)]
fn depth(kappa: f64, u: f64, (whole, less): (f64, f64)) -> f64 {
    let e = (1.0 - u) * less;
    if e > -0.5 {
        return e.ln_1p();
    }
    let far = (u + (1.0 - u) * whole).ln();
    if far > -2.0 * kappa { far } else { -2.0 * kappa }
}

/// What is left of two of that depth m; of a narrow lobe no sample comes near the far pole but that of zero.
#[inline(always)]
fn rest(kappa: f64, u: f64, m: f64) -> f64 {
    if m < 1.5 || kappa > 300.0 { 2.0 - m } else { (u * (2.0 * kappa).exp_m1()).ln_1p() / kappa }
}

by_hand! {
    /// Row 60: uniform on the sphere.
    UniformSphere(): [2] => Direction;
    sample(u) {
        let z = 1.0 - 2.0 * u[0];
        around((1.0 - z * z).sqrt(), z, u[1])
    }
    pdf(w) { if finite([w.x, w.y, w.z]) { 0.25 * FRAC_1_PI } else { 0.0 } }
    draw(u) {
        let z = 1.0 - 2.0 * u[0];
        (around((1.0 - z * z).sqrt(), z, u[1]), 0.25 * FRAC_1_PI)
    }

    /// Row 62: uniform on the hemisphere.
    UniformHemisphere(): [2] => Direction;
    sample(u) { around((1.0 - u[0] * u[0]).sqrt(), u[0], u[1]) }
    pdf(w) { if w.z >= 0.0 && finite([w.x, w.y, w.z]) { 0.5 * FRAC_1_PI } else { 0.0 } }
    draw(u) { (around((1.0 - u[0] * u[0]).sqrt(), u[0], u[1]), 0.5 * FRAC_1_PI) }

    /// Row 63: by the cosine.
    CosineHemisphere(): [2] => Direction;
    sample(u) { around(u[0].sqrt(), (1.0 - u[0]).sqrt(), u[1]) }
    pdf(w) { if w.z >= 0.0 && finite([w.x, w.y, w.z]) { w.z * FRAC_1_PI } else { 0.0 } }
    draw(u) {
        let z = (1.0 - u[0]).sqrt();
        (around(u[0].sqrt(), z, u[1]), z * FRAC_1_PI)
    }

    /// Row 64: by a power of the cosine. The sine is told by the logarithm of the cosine, for 1 - z² is lost next to the pole,
    /// where nearly all of a narrow lobe lies.
    PowerCosine(n: f64): [2] => Direction;
    sample(u) {
        let l = u[0].ln() / (n + 1.0);
        around((-(2.0 * l).exp_m1()).sqrt(), l.exp(), u[1])
    }
    pdf(w) {
        let inside = w.z >= 0.0 && finite([w.x, w.y, w.z]);
        if inside { (n + 1.0) / TAU * power(w, n) } else { 0.0 }
    }
    draw(u) {
        let l = u[0].ln() / (n + 1.0);
        let z = l.exp();
        let density = (n + 1.0) / TAU * quotient(u[0], z, || z.powf(n));
        (around((-(2.0 * l).exp_m1()).sqrt(), z, u[1]), density)
    }

    /// Row 65: uniform in a cone.
    Cone(m: f64): [2] => Direction;
    sample(u) {
        let h = m * u[0];
        around((h * (2.0 - h)).sqrt(), 1.0 - h, u[1])
    }
    pdf(w) {
        // 1 - cos, without losing digits at the pole.
        let h = if w.z > 0.0 { sine2(w) / (1.0 + w.z) } else { 1.0 - w.z };
        if h <= m && finite([w.x, w.y, w.z]) { 1.0 / (TAU * m) } else { 0.0 }
    }
    draw(u) {
        let h = m * u[0];
        (around((h * (2.0 - h)).sqrt(), 1.0 - h, u[1]), 1.0 / (TAU * m))
    }

    /// Row 67: uniform on the sphere, by an octahedron.
    EqualAreaOctahedral(): [2] => Direction;
    sample(u) {
        let (a, b) = (2.0 * u[0] - 1.0, 2.0 * u[1] - 1.0);
        let s = 1.0 - a.abs() - b.abs();
        let r = 1.0 - s.abs();
        let turn = if r == 0.0 { 1.0 } else { (b.abs() - a.abs()) / r + 1.0 };
        let (sine, cosine) = (FRAC_PI_4 * turn).sin_cos();
        let h = r * (2.0 - r * r).sqrt();
        let z = (1.0 - r * r).copysign(s);
        Direction::from_unit(Vec3::new((h * cosine).copysign(a), (h * sine).copysign(b), z))
    }
    pdf(w) { if finite([w.x, w.y, w.z]) { 0.25 * FRAC_1_PI } else { 0.0 } }
    draw(u) { (super::ByHand::sample(&EqualAreaOctahedral {}, u), 0.25 * FRAC_1_PI) }

    /// Row 66: uniform on the hemisphere, by concentric squares.
    ConcentricHemisphere(): [2] => Direction;
    sample(u) {
        let (r, theta) = concentric(u);
        let (s, c) = theta.sin_cos();
        let h = r * (2.0 - r * r).sqrt();
        Direction::from_unit(Vec3::new(h * c, h * s, 1.0 - r * r))
    }
    pdf(w) { if w.z >= 0.0 && finite([w.x, w.y, w.z]) { 0.5 * FRAC_1_PI } else { 0.0 } }
    draw(u) { (super::ByHand::sample(&ConcentricHemisphere {}, u), 0.5 * FRAC_1_PI) }

    /// Row 68: uniform in a window of height and azimuth.
    ZonalWindow(z0: f64, z1: f64, p: f64, d: f64): [2] => Direction;
    sample(u) {
        let z = (1.0 - u[0]) * z0 + u[0] * z1;
        let r = (1.0 - z * z).sqrt();
        let (s, c) = (p + d * u[1]).sin_cos();
        Direction::from_unit(Vec3::new(r * c, r * s, z))
    }
    pdf(w) {
        if !(w.z >= z0 && w.z <= z1 && finite([w.x, w.y])) {
            return 0.0;
        }
        let angle = w.y.atan2(w.x) - p;
        let angle = angle - TAU * (angle / TAU).floor();
        if angle <= d { 1.0 / ((z1 - z0) * d) } else { 0.0 }
    }
    draw(u) {
        let z = (1.0 - u[0]) * z0 + u[0] * z1;
        let r = (1.0 - z * z).sqrt();
        let (s, c) = (p + d * u[1]).sin_cos();
        (Direction::from_unit(Vec3::new(r * c, r * s, z)), 1.0 / ((z1 - z0) * d))
    }

    /// Row 74: von Mises and Fisher. Next to the far pole, where 2 - m loses its digits, that is had as the depth below the pole is.
    VonMisesFisher(kappa: f64): [2] => Direction;
    sample(u) {
        let m = -depth(kappa, u[0], decay(kappa)) / kappa;
        around((m * rest(kappa, u[0], m)).sqrt(), 1.0 - m, u[1])
    }
    pdf(w) {
        if !finite([w.x, w.y, w.z]) {
            return 0.0;
        }
        let m = if w.z > 0.0 { sine2(w) / (1.0 + w.z) } else { 1.0 - w.z };
        -kappa * (-kappa * m).exp() / (TAU * (-2.0 * kappa).exp_m1())
    }
    draw(u) {
        let (whole, less) = decay(kappa);
        let m = -depth(kappa, u[0], (whole, less)) / kappa;
        let density = -kappa * (u[0] + (1.0 - u[0]) * whole) / (TAU * less);
        (around((m * rest(kappa, u[0], m)).sqrt(), 1.0 - m, u[1]), density)
    }

    /// Row 75: Henyey and Greenstein.
    HenyeyGreenstein(g: f64): [2] => Direction;
    sample(u) {
        let (k, f) = (1.0 - g, 1.0 - g + 2.0 * g * u[0]);
        let q = k / f;
        let m = 2.0 * (q * q) * ((1.0 - u[0]) * (1.0 + g * u[0]));
        around((m * (2.0 - m)).sqrt(), 1.0 - m, u[1])
    }
    pdf(w) {
        if !finite([w.x, w.y, w.z]) {
            return 0.0;
        }
        let m = if w.z > 0.0 { sine2(w) / (1.0 + w.z) } else { 1.0 - w.z };
        let k = 1.0 - g;
        let d = k * k + 2.0 * g * m;
        0.25 * FRAC_1_PI * (k * (1.0 + g)) / (d * d.sqrt())
    }
    draw(u) {
        let (k, f) = (1.0 - g, 1.0 - g + 2.0 * g * u[0]);
        let q = k / f;
        let m = 2.0 * (q * q) * ((1.0 - u[0]) * (1.0 + g * u[0]));
        let square = k * (1.0 + g);
        let density = 0.25 * FRAC_1_PI * (f * f * f) / (square * square);
        (around((m * (2.0 - m)).sqrt(), 1.0 - m, u[1]), density)
    }

    /// Row 76: Rayleigh.
    Rayleigh(): [2] => Direction;
    sample(u) {
        let b = 4.0 * u[0] - 2.0;
        let t = (b + (b * b + 1.0).sqrt()).cbrt();
        let c = t - 1.0 / t;
        around((1.0 - c * c).sqrt(), c, u[1])
    }
    pdf(w) {
        let density = 3.0 / 16.0 * FRAC_1_PI * (1.0 + w.z * w.z);
        if finite([w.x, w.y, w.z]) { density } else { 0.0 }
    }
    draw(u) {
        let b = 4.0 * u[0] - 2.0;
        let t = (b + (b * b + 1.0).sqrt()).cbrt();
        let c = t - 1.0 / t;
        let square = c * c;
        (around((1.0 - square).sqrt(), c, u[1]), 3.0 / 16.0 * FRAC_1_PI * (1.0 + square))
    }

    /// Row 81: normals of Beckmann.
    Beckmann(alpha: f64): [2] => Direction;
    sample(u) {
        let t2 = -alpha * alpha * (-u[0]).ln_1p();
        let z = 1.0 / (1.0 + t2).sqrt();
        around(t2.sqrt() * z, z, u[1])
    }
    pdf(w) {
        if !(w.z > 0.0 && finite([w.x, w.y, w.z])) {
            return 0.0;
        }
        let (a2, c2) = (alpha * alpha, w.z * w.z);
        FRAC_1_PI * (-sine2(w) / (a2 * c2)).exp() / (a2 * c2 * w.z)
    }
    draw(u) {
        let a2 = alpha * alpha;
        let t2 = -a2 * (-u[0]).ln_1p();
        let c = 1.0 + t2;
        let z = 1.0 / c.sqrt();
        (around(t2.sqrt() * z, z, u[1]), FRAC_1_PI * (1.0 - u[0]) * c / (a2 * z))
    }

    /// Row 82: normals of GGX.
    Ggx(alpha: f64): [2] => Direction;
    sample(u) {
        let t2 = alpha * alpha * u[0] / (1.0 - u[0]);
        let z = 1.0 / (1.0 + t2).sqrt();
        around(t2.sqrt() * z, z, u[1])
    }
    pdf(w) {
        if !(w.z >= 0.0 && finite([w.x, w.y, w.z])) {
            return 0.0;
        }
        let a2 = alpha * alpha;
        let d = sine2(w) + a2 * (w.z * w.z);
        FRAC_1_PI * a2 * w.z / (d * d)
    }
    draw(u) {
        let (a2, rest) = (alpha * alpha, 1.0 - u[0]);
        let t2 = a2 * u[0] / rest;
        let c = 1.0 + t2;
        let z = 1.0 / c.sqrt();
        (around(t2.sqrt() * z, z, u[1]), FRAC_1_PI * rest * rest * c / (a2 * z))
    }

    /// Row 83: normals of anisotropic GGX.
    AnisotropicGgx(ax: f64, ay: f64): [2] => Direction;
    sample(u) {
        let r = (u[0] / (1.0 - u[0])).sqrt();
        let (s, c) = (TAU * u[1]).sin_cos();
        let (x, y) = (ax * r * c, ay * r * s);
        let z = 1.0 / (1.0 + (x * x + y * y)).sqrt();
        Direction::from_unit(Vec3::new(x * z, y * z, z))
    }
    pdf(w) {
        if !(w.z >= 0.0 && finite([w.x, w.y, w.z])) {
            return 0.0;
        }
        let (x, y) = (w.x / ax, w.y / ay);
        let d = x * x + y * y + w.z * w.z;
        FRAC_1_PI * w.z / (ax * ay * d * d)
    }
    draw(u) {
        let rest = 1.0 - u[0];
        let r = (u[0] / rest).sqrt();
        let (s, c) = (TAU * u[1]).sin_cos();
        let (x, y) = (ax * r * c, ay * r * s);
        let t = 1.0 + (x * x + y * y);
        let z = 1.0 / t.sqrt();
        let density = FRAC_1_PI * rest * rest * t / (ax * ay * z);
        (Direction::from_unit(Vec3::new(x * z, y * z, z)), density)
    }

    /// Row 86: normals of GGX that are visible.
    VisibleNormals(alpha: f64, w: Direction): [2] => Direction;
    sample(u) {
        let v = Vec3::new(alpha * w.x, alpha * w.y, w.z).normalize();
        let z = 1.0 - u[1] * (1.0 + v.z);
        let r = (1.0 - z * z).sqrt();
        let (s, c) = (TAU * u[0]).sin_cos();
        // Neither the sum nor the stretched normal needs unit length on the way.
        let m = Vec3::new(r * c + v.x, r * s + v.y, z + v.z);
        Direction::from_vec(Vec3::new(alpha * m.x, alpha * m.y, m.z))
    }
    pdf(h) {
        let cosine = h.x * w.x + h.y * w.y + h.z * w.z;
        if !(cosine >= 0.0 && h.z >= 0.0 && finite([h.x, h.y, h.z])) {
            return 0.0;
        }
        let a2 = alpha * alpha;
        let d = sine2(h) + a2 * (h.z * h.z);
        let shadowed = w.z + (a2 * sine2(&w) + w.z * w.z).sqrt();
        2.0 * FRAC_1_PI * a2 * cosine / (d * d * shadowed)
    }
    draw(u) {
        let a2 = alpha * alpha;
        let length = (a2 * sine2(&w) + w.z * w.z).sqrt();
        let scale = 1.0 / length;
        let v = Vec3::new(alpha * w.x * scale, alpha * w.y * scale, w.z * scale);
        let z = 1.0 - u[1] * (1.0 + v.z);
        let r = (1.0 - z * z).sqrt();
        let (s, c) = (TAU * u[0]).sin_cos();
        let m = Vec3::new(r * c + v.x, r * s + v.y, z + v.z);
        let h = Direction::from_vec(Vec3::new(alpha * m.x, alpha * m.y, m.z));
        let cosine = h.x * w.x + h.y * w.y + h.z * w.z;
        let d = sine2(&h) + a2 * (h.z * h.z);
        (h, 2.0 * FRAC_1_PI * a2 * cosine / (d * d * (w.z + length)))
    }

    /// Row 89: a viewer reflected about a normal of GGX.
    ReflectedGgx(alpha: f64, w: Direction): [2] => Direction;
    sample(u) {
        let r = alpha * (u[0] / (1.0 - u[0])).sqrt();
        let (s, c) = (TAU * u[1]).sin_cos();
        let z = 1.0 / (1.0 + r * r).sqrt();
        let h = Vec3::new(r * c * z, r * s * z, z);
        let twice = 2.0 * (h.x * w.x + h.y * w.y + h.z * w.z);
        Direction::from_unit(Vec3::new(twice * h.x - w.x, twice * h.y - w.y, twice * h.z - w.z))
    }
    pdf(v) {
        if !finite([v.x, v.y, v.z]) {
            return 0.0;
        }
        let (h, m) = (v.vec() + w.vec(), w.vec() - v.vec());
        // Of nearly opposite directions what is left is freed of what rounding has made of their lengths.
        let h = h - 0.25 * h.dot(m) * m;
        let square = h.x * h.x + h.y * h.y + h.z * h.z;
        let a2 = alpha * alpha;
        let d = h.x * h.x + h.y * h.y + a2 * (h.z * h.z);
        let cosine = (h.x * w.x + h.y * w.y + h.z * w.z).abs();
        // Of the half vector of unit length, h / √square.
        0.25 * FRAC_1_PI * a2 * h.z.abs() * (square * square) / (d * d * cosine)
    }
    draw(u) {
        let rest = 1.0 - u[0];
        let r = alpha * (u[0] / rest).sqrt();
        let (s, c) = (TAU * u[1]).sin_cos();
        let t = 1.0 + r * r;
        let z = 1.0 / t.sqrt();
        let h = Vec3::new(r * c * z, r * s * z, z);
        let cosine = h.x * w.x + h.y * w.y + h.z * w.z;
        let twice = 2.0 * cosine;
        let v = Vec3::new(twice * h.x - w.x, twice * h.y - w.y, twice * h.z - w.z);
        let density = 0.25 * FRAC_1_PI * (rest * rest) * t / (alpha * alpha * z * cosine.abs());
        (Direction::from_unit(v), density)
    }

    /// Row 91: a power cosine or a cosine.
    Mixture(p: f64, n: f64): [2] => Direction;
    sample(u) {
        if u[0] < p {
            let l = (u[0] / p).ln() / (n + 1.0);
            around((-(2.0 * l).exp_m1()).sqrt(), l.exp(), u[1])
        } else {
            let v = (u[0] - p) / (1.0 - p);
            around(v.sqrt(), (1.0 - v).sqrt(), u[1])
        }
    }
    pdf(w) {
        if !(w.z >= 0.0 && finite([w.x, w.y, w.z])) {
            return 0.0;
        }
        p * (n + 1.0) / TAU * power(w, n) + (1.0 - p) * (w.z * FRAC_1_PI)
    }
    draw(u) {
        if u[0] < p {
            let t = u[0] / p;
            let l = t.ln() / (n + 1.0);
            let z = l.exp();
            let lobe = quotient(t, z, || z.powf(n));
            let density = p * (n + 1.0) / TAU * lobe + (1.0 - p) * (z * FRAC_1_PI);
            (around((-(2.0 * l).exp_m1()).sqrt(), z, u[1]), density)
        } else {
            let v = (u[0] - p) / (1.0 - p);
            let z2 = 1.0 - v;
            // The power of the cosine by that of its square, of which next to the pole no less is known than of the sine.
            let lobe = if v < 0.5 { (0.5 * n * (-v).ln_1p()).exp() } else { z2.powf(0.5 * n) };
            let z = z2.sqrt();
            let density = p * (n + 1.0) / TAU * lobe + (1.0 - p) * (z * FRAC_1_PI);
            (around(v.sqrt(), z, u[1]), density)
        }
    }

    /// Row 92: sheen. The cosine is told by the logarithm of the sine, for 1 - s² is lost next to the horizon, where nearly all
    /// samples of a small roughness lie.
    Sheen(alpha: f64): [2] => Direction;
    sample(u) {
        let l = u[0].ln() * (alpha / (2.0 * alpha + 1.0));
        around(l.exp(), (-(2.0 * l).exp_m1()).sqrt(), u[1])
    }
    pdf(w) {
        if !(w.z >= 0.0 && finite([w.x, w.y, w.z])) {
            return 0.0;
        }
        let (e, z2) = (1.0 / alpha, w.z * w.z);
        // The power of the sine by the cosine, where that is small.
        let power = if z2 < 0.5 { (0.5 * e * (-z2).ln_1p()).exp() } else { sine2(w).powf(0.5 * e) };
        (2.0 + e) * power * w.z / TAU
    }
    draw(u) {
        let l = u[0].ln() * (alpha / (2.0 * alpha + 1.0));
        let s = l.exp();
        let z = (-(2.0 * l).exp_m1()).sqrt();
        // The sine to the power of one over alpha is u over its square.
        let power = quotient(u[0], s * s, || s.powf(1.0 / alpha));
        (around(s, z, u[1]), (2.0 + 1.0 / alpha) * power * z / TAU)
    }

    /// Row 99: a perspective camera.
    Perspective(t: f64, a: f64): [2] => Direction;
    sample(u) {
        let (x, y) = (t * (2.0 * u[0] - 1.0), t * a * (2.0 * u[1] - 1.0));
        let z = 1.0 / (x * x + y * y + 1.0).sqrt();
        Direction::from_unit(Vec3::new(x * z, y * z, z))
    }
    pdf(w) {
        let inside = w.z > 0.0 && w.x.abs() <= t * w.z && w.y.abs() <= t * a * w.z;
        if inside && w.z.is_finite() { 1.0 / (4.0 * t * t * a * (w.z * w.z * w.z)) } else { 0.0 }
    }
    draw(u) {
        let (x, y) = (t * (2.0 * u[0] - 1.0), t * a * (2.0 * u[1] - 1.0));
        let square = x * x + y * y + 1.0;
        let length = square.sqrt();
        let z = 1.0 / length;
        (Direction::from_unit(Vec3::new(x * z, y * z, z)), square * length / (4.0 * t * t * a))
    }
}
