// A uniform that the result does not depend on.
use aether_core::prelude::*;

#[sampler]
fn slab(u: [Uniform; 2], k: f64) -> Vec2 {
    Vec2::new(u[0], k * u[0])
}

fn main() {}
