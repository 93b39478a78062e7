// A domain with its ends exchanged.
use aether_core::prelude::*;

#[sampler(alpha in 1.0..=0.0)]
fn scaled(u: [Uniform; 1], alpha: f64) -> f64 {
    alpha * u[0]
}

fn main() {}
