use aether_core::prelude::*;

#[sampler]
fn clamped(u: [Uniform; 1]) -> f64 {
    u[0].min(0.5)
}

fn main() {}
