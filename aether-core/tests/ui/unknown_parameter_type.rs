// A parameter that is neither a number nor a vector nor a matrix.
use aether_core::prelude::*;

#[sampler]
fn scaled(u: [Uniform; 1], name: &str) -> f64 {
    u[0]
}

fn main() {}
