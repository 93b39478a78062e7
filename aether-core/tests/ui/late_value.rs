// A name without its value, or used before it has one.
use aether_core::prelude::*;

#[sampler]
fn late(u: [Uniform; 1], k: f64) -> f64 {
    let x;
    x = k * u[0];
    x
}

fn main() {}
