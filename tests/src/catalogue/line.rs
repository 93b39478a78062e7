//! The line.

use aether_core::prelude::*;

/// Row 6: a tent of half width r around zero.
#[sampler(r in 1e-6..)]
pub fn tent(u: [Uniform; 1], r: f64) -> f64 {
    if u[0] < 0.5 {
        r * ((2.0 * u[0]).sqrt() - 1.0)
    } else {
        r * (1.0 - (2.0 * (1.0 - u[0])).sqrt())
    }
}

/// Row 7: a triangle over [a, c] with its peak at b.
#[sampler]
pub fn triangular(u: [Uniform; 1], a: f64, b: f64, c: f64) -> f64 {
    if u[0] * (c - a) < b - a {
        a + (u[0] * (c - a) * (b - a)).sqrt()
    } else {
        c - ((1.0 - u[0]) * (c - a) * (c - b)).sqrt()
    }
}

/// Row 15: Student's t with two degrees of freedom.
#[sampler]
pub fn student_2(u: [Uniform; 1]) -> f64 {
    (2.0 * u[0] - 1.0) / (2.0 * u[0] * (1.0 - u[0])).sqrt()
}

/// Row 16: Student's t with nu degrees of freedom, by the quantile of nu / (nu + x²) in the tails and of
/// the rest to one in the middle.
#[sampler(nu in 0.5..=1e6)]
pub fn student(u: [Uniform; 1], nu: f64) -> f64 {
    if u[0] < 0.25 {
        let y = beta_inc_inv(0.5 * nu, 0.5, 2.0 * u[0]);
        -(nu * (1.0 - y) / y).sqrt()
    } else if u[0] > 0.75 {
        let y = beta_inc_inv(0.5 * nu, 0.5, 2.0 * (1.0 - u[0]));
        (nu * (1.0 - y) / y).sqrt()
    } else {
        let p = 2.0 * u[0] - 1.0;
        let z = beta_inc_inv(0.5, 0.5 * nu, p.abs());
        (nu * z / (1.0 - z)).sqrt().copysign(p)
    }
}

/// Row 17: Laplace with scale b.
#[sampler(b in 1e-6..)]
pub fn laplace(u: [Uniform; 1], b: f64) -> f64 {
    if u[0] < 0.5 { b * (2.0 * u[0]).ln() } else { -b * (2.0 * (1.0 - u[0])).ln() }
}

/// Row 32: a segment of a rational-quadratic spline of slope s, with the derivatives d0 and d1 at
/// its ends.
#[sampler(s in 0.1..=10.0, d0 in 0.1..=10.0, d1 in 0.1..=10.0)]
pub fn rational_quadratic(u: [Uniform; 1], s: f64, d0: f64, d1: f64) -> f64 {
    let t = u[0];
    s * (s * t * t + d0 * t * (1.0 - t)) / (s + (d1 + d0 - 2.0 * s) * t * (1.0 - t))
}

/// Row 33: the cosine of a uniform angle; two preimages.
#[sampler]
pub fn cosine(u: [Uniform; 1]) -> f64 {
    (TAU * u[0]).cos()
}

/// Row 34: a parabola; two preimages.
#[sampler]
pub fn parabola(u: [Uniform; 1]) -> f64 {
    4.0 * u[0] * (1.0 - u[0])
}

/// Row 34: a square about the middle; two preimages.
#[sampler]
pub fn square(u: [Uniform; 1]) -> f64 {
    (2.0 * u[0] - 1.0).powi(2)
}

/// Row 34: a fold in the middle; two preimages.
#[sampler]
pub fn fold(u: [Uniform; 1]) -> f64 {
    (2.0 * u[0] - 1.0).abs()
}

/// Row 35: a sawtooth with k teeth, of which the last may be cut short; a preimage on each.
#[sampler(k in 0.5..=4.0)]
pub fn sawtooth(u: [Uniform; 1], k: f64) -> f64 {
    k * u[0] - (k * u[0]).floor()
}

/// Row 36: a cubic that turns twice; three preimages.
#[sampler]
pub fn cubic(u: [Uniform; 1]) -> f64 {
    u[0].powi(3) - 1.5 * u[0].powi(2) + 0.5625 * u[0]
}

/// Row 12: the normal distribution.
#[sampler(s in 1e-3..)]
pub fn normal(u: [Uniform; 1], m: f64, s: f64) -> f64 {
    m + s * normal_quantile(u[0])
}

/// Row 13: the normal distribution in its upper tail, between a and b.
#[sampler]
pub fn upper_normal(u: [Uniform; 1], a: f64, b: f64) -> f64 {
    -normal_quantile((1.0 - u[0]) * normal_cdf(-a) + u[0] * normal_cdf(-b))
}

/// Row 13 again, in the lower tail.
#[sampler]
pub fn lower_normal(u: [Uniform; 1], a: f64, b: f64) -> f64 {
    normal_quantile((1.0 - u[0]) * normal_cdf(a) + u[0] * normal_cdf(b))
}
