// A parameter in single precision.
use aether_core::prelude::*;

#[sampler]
fn scaled(u: [Uniform; 1], k: f32) -> f64 {
    u[0]
}

fn main() {}
