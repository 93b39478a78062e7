// A semicolon after the result.
use aether_core::prelude::*;

#[sampler]
fn scaled(u: [Uniform; 1], k: f64) -> f64 {
    k * u[0];
}

fn main() {}
