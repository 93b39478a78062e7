// An option that the attribute does not know.
use aether_core::prelude::*;

#[sampler(verbose)]
fn scaled(u: [Uniform; 1], k: f64) -> f64 {
    k * u[0]
}

fn main() {}
