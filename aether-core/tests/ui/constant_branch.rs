// A branch with a constant: `min` maps half of the uniforms to a single point.
use aether_core::prelude::*;

#[sampler]
fn clamped(u: [Uniform; 1]) -> f64 {
    u[0].min(0.5)
}

fn main() {}
