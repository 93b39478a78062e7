// `%`, bit operations and other operators without an inverse.
use aether_core::prelude::*;

#[sampler]
fn wrapped(u: [Uniform; 1]) -> f64 {
    (u[0] + 0.25) % 1.0
}

fn main() {}
