// More than half of the digits are lost where a probability is next to one; a warning, which is an error here.
#![deny(deprecated)]

use aether_core::prelude::*;

#[sampler(s in 0.5..=10.0, a in -4.0..=4.0, b in -4.0..=4.0)]
fn truncated_logistic(u: [Uniform; 1], s: f64, a: f64, b: f64) -> f64 {
    let below_a = 1.0 / (1.0 + (-a / s).exp());
    let below_b = 1.0 / (1.0 + (-b / s).exp());
    let p = (1.0 - u[0]) * below_a + u[0] * below_b;
    s * (p / (1.0 - p)).ln()
}

/// The same, as it is known.
#[allow(deprecated)]
#[sampler(s in 0.5..=10.0, a in -4.0..=4.0, b in -4.0..=4.0)]
fn known(u: [Uniform; 1], s: f64, a: f64, b: f64) -> f64 {
    let below_a = 1.0 / (1.0 + (-a / s).exp());
    let below_b = 1.0 / (1.0 + (-b / s).exp());
    let p = (1.0 - u[0]) * below_a + u[0] * below_b;
    s * (p / (1.0 - p)).ln()
}

fn main() {}
