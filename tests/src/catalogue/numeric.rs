//! Samplers of which a step of the forward map has no closed form: distributions that are inverted numerically.

use aether_core::prelude::*;

/// Row 8: a density like the smoothstep, by inverting its distribution.
#[sampler]
pub fn smoothstep(u: [Uniform; 1], a: f64, b: f64) -> f64 {
    let t = solve(|t| 2.0 * t.powi(3) - t.powi(4), 0.0..1.0, u[0]);
    a + (b - a) * t
}

/// Row 37: Kepler's equation.
#[sampler(e in 0.0..=1.0)]
pub fn kepler(u: [Uniform; 1], e: f64) -> f64 {
    solve(|a| a - e * a.sin(), 0.0..TAU, TAU * u[0])
}

/// Row 38: a mixture of two exponentials with a single uniform, by its distribution.
#[sampler(p in 0.0..=1.0, l in 1e-3..=1e3, m in 1e-3..=1e3)]
pub fn hyperexponential(u: [Uniform; 1], p: f64, l: f64, m: f64) -> f64 {
    solve(|x| -p * (-l * x).exp_m1() - (1.0 - p) * (-m * x).exp_m1(), 0.0.., u[0])
}
