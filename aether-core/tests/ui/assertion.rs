// An assertion. What has to hold of parameters is declared, and asked for when the sampler is made.
use aether_core::prelude::*;

#[sampler]
fn scaled(u: [Uniform; 1], k: f64) -> f64 {
    assert!(k > 0.0, "k is {k}");
    k * u[0]
}

fn main() {}
