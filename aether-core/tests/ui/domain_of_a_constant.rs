// A domain with an end that is a constant. The compiler does not know its value.
use aether_core::prelude::*;

const MAX: f64 = 4.0;

#[sampler(alpha in 1.0..=MAX)]
fn scaled(u: [Uniform; 1], alpha: f64) -> f64 {
    alpha * u[0]
}

fn main() {}
