// Changing a variable.
use aether_core::prelude::*;

#[sampler]
fn scaled(u: [Uniform; 1], k: f64) -> f64 {
    let mut x = u[0];
    x = k * x;
    x
}

fn main() {}
