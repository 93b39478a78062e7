// Changing a name that is not `mut`.
use aether_core::prelude::*;

#[sampler]
fn sum(u: [Uniform; 1], k: f64) -> f64 {
    let x = u[0];
    x += k;
    x
}

fn main() {}
