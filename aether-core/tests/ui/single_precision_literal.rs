// A literal with a suffix. The same body runs in every precision, so literals have none.
use aether_core::prelude::*;

#[sampler]
fn scaled(u: [Uniform; 1], k: f64) -> f64 {
    let half = 0.5f32;
    k * u[0]
}

fn main() {}
