//! The plane.

use core::f64::consts::{FRAC_1_PI, FRAC_PI_2, FRAC_PI_4, TAU};

use aether_core::prelude::Vec2;

use super::line::{larger, linear};
use super::{by_hand, finite};

/// The point of the unit disk at a place of the square, by concentric squares.
#[inline(always)]
pub(super) fn concentric(u: [f64; 2]) -> (f64, f64) {
    let (a, b) = (2.0 * u[0] - 1.0, 2.0 * u[1] - 1.0);
    if a.abs() > b.abs() {
        (a, FRAC_PI_4 * (b / a))
    } else if b != 0.0 {
        (b, FRAC_PI_2 - FRAC_PI_4 * (a / b))
    } else {
        (0.0, 0.0)
    }
}

by_hand! {
    /// Row 42: uniform on a disk.
    PolarDisk(radius: f64): [2] => Vec2;
    sample(u) {
        let r = radius * u[0].sqrt();
        let (s, c) = (TAU * u[1]).sin_cos();
        Vec2::new(r * c, r * s)
    }
    pdf(x) {
        let square = radius * radius;
        if x.x * x.x + x.y * x.y <= square { FRAC_1_PI / square } else { 0.0 }
    }
    draw(u) {
        let r = radius * u[0].sqrt();
        let (s, c) = (TAU * u[1]).sin_cos();
        (Vec2::new(r * c, r * s), FRAC_1_PI / (radius * radius))
    }

    /// Row 43: uniform on the disk, by concentric squares.
    ConcentricDisk(): [2] => Vec2;
    sample(u) {
        let (r, theta) = concentric(u);
        let (s, c) = theta.sin_cos();
        Vec2::new(r * c, r * s)
    }
    pdf(x) { if x.x * x.x + x.y * x.y <= 1.0 { FRAC_1_PI } else { 0.0 } }
    draw(u) {
        let (r, theta) = concentric(u);
        let (s, c) = theta.sin_cos();
        (Vec2::new(r * c, r * s), FRAC_1_PI)
    }

    /// Row 44: uniform on a sector of an annulus.
    AnnularSector(a: f64, b: f64, p: f64, d: f64): [2] => Vec2;
    sample(u) {
        let r = ((1.0 - u[0]) * a * a + u[0] * b * b).sqrt();
        let (s, c) = (p + d * u[1]).sin_cos();
        Vec2::new(r * c, r * s)
    }
    pdf(x) {
        let square = x.x * x.x + x.y * x.y;
        if !(square >= a * a && square <= b * b) {
            return 0.0;
        }
        let angle = x.y.atan2(x.x) - p;
        let angle = angle - TAU * (angle / TAU).floor();
        if angle <= d { 2.0 / (d * (b * b - a * a)) } else { 0.0 }
    }
    draw(u) {
        let (a2, b2) = (a * a, b * b);
        let r = ((1.0 - u[0]) * a2 + u[0] * b2).sqrt();
        let (s, c) = (p + d * u[1]).sin_cos();
        (Vec2::new(r * c, r * s), 2.0 / (d * (b2 - a2)))
    }

    /// Row 50: normal.
    BivariateNormal(l11: f64, l21: f64, l22: f64): [2] => Vec2;
    sample(u) {
        let r = (-2.0 * (-u[0]).ln_1p()).sqrt();
        let (s, c) = (TAU * u[1]).sin_cos();
        Vec2::new(l11 * (r * c), l21 * (r * c) + l22 * (r * s))
    }
    pdf(x) {
        let p = x.x / l11;
        let q = (x.y - l21 * p) / l22;
        let density = (-0.5 * (p * p + q * q)).exp() / (TAU * l11 * l22);
        if finite([x.x, x.y]) { density } else { 0.0 }
    }
    draw(u) {
        let r = (-2.0 * (-u[0]).ln_1p()).sqrt();
        let (s, c) = (TAU * u[1]).sin_cos();
        (Vec2::new(l11 * (r * c), l21 * (r * c) + l22 * (r * s)), (1.0 - u[0]) / (TAU * l11 * l22))
    }

    /// Row 51: slopes of GGX.
    GgxSlopes(alpha: f64): [2] => Vec2;
    sample(u) {
        let r = alpha * (u[0] / (1.0 - u[0])).sqrt();
        let (s, c) = (TAU * u[1]).sin_cos();
        Vec2::new(r * c, r * s)
    }
    pdf(x) {
        if !finite([x.x, x.y]) {
            return 0.0;
        }
        let square = alpha * alpha;
        let d = square + (x.x * x.x + x.y * x.y);
        FRAC_1_PI * square / (d * d)
    }
    draw(u) {
        let rest = 1.0 - u[0];
        let r = alpha * (u[0] / rest).sqrt();
        let (s, c) = (TAU * u[1]).sin_cos();
        (Vec2::new(r * c, r * s), FRAC_1_PI * rest * rest / (alpha * alpha))
    }

    /// Row 53: bilinear.
    BilinearDensity(w00: f64, w10: f64, w01: f64, w11: f64): [2] => Vec2;
    sample(u) {
        let (y, _) = linear(u[1], w00 + w10, w01 + w11);
        let (x, _) = linear(u[0], (1.0 - y) * w00 + y * w01, (1.0 - y) * w10 + y * w11);
        Vec2::new(x, y)
    }
    pdf(p) {
        let inside = p.x >= 0.0 && p.x <= 1.0 && p.y >= 0.0 && p.y <= 1.0;
        if !inside {
            return 0.0;
        }
        let low = (1.0 - p.x) * w00 + p.x * w10;
        let high = (1.0 - p.x) * w01 + p.x * w11;
        larger(4.0 * ((1.0 - p.y) * low + p.y * high) / (w00 + w10 + w01 + w11), 0.0)
    }
    draw(u) {
        let (y, by) = linear(u[1], w00 + w10, w01 + w11);
        let (x, bx) = linear(u[0], (1.0 - y) * w00 + y * w01, (1.0 - y) * w10 + y * w11);
        (Vec2::new(x, y), bx * by)
    }
}
