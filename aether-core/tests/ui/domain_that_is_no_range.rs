// A domain in mathematical notation.
use aether_core::prelude::*;

#[sampler(alpha in [0, 1])]
fn scaled(u: [Uniform; 1], alpha: f64) -> f64 {
    (1.0 + alpha) * u[0]
}

fn main() {}
