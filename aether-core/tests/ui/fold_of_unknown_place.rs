// A fold at a place that depends on an undeclared parameter.
use aether_core::prelude::*;

#[sampler]
fn folded(u: [Uniform; 1], k: f64) -> f64 {
    (k * u[0]).sin()
}

fn main() {}
