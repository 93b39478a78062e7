// A domain as a comparison, without `where`.
use aether_core::prelude::*;

#[sampler(alpha > 0.0)]
fn scaled(u: [Uniform; 1], alpha: f64) -> f64 {
    alpha * u[0]
}

fn main() {}
