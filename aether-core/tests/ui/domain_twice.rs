// Two domains of one parameter.
use aether_core::prelude::*;

#[sampler(k in 1.0..=2.0, k in 0.5..=4.0)]
fn scaled(u: [Uniform; 1], k: f64) -> f64 {
    k * u[0]
}

fn main() {}
