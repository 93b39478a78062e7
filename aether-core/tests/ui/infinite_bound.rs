// Infinity as a number.
use aether_core::prelude::*;

#[sampler]
fn positive(u: [Uniform; 1], k: f64) -> f64 {
    (k * u[0]).clamp(0.0, f64::INFINITY)
}

fn main() {}
