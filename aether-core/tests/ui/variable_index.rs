// An index that is computed.
use aether_core::prelude::*;

#[sampler]
fn picked(u: [Uniform; 2], k: f64) -> Vec2 {
    let i = 1;
    Vec2::new(u[0], k * u[i])
}

fn main() {}
