// The array of uniforms where one of them is meant.
use aether_core::prelude::*;

#[sampler]
fn scaled(u: [Uniform; 1], k: f64) -> f64 {
    k * u
}

fn main() {}
