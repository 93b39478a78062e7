// Comparing parameters that are real numbers for equality.
use aether_core::prelude::*;

#[sampler]
fn between(u: [Uniform; 1], a: f64, b: f64) -> f64 {
    if a == b { u[0] } else { a + (b - a) * u[0] }
}

fn main() {}
