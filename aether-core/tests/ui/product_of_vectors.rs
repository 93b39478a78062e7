// A product of vectors. There are three, and each has a name.
use aether_core::prelude::*;

#[sampler]
fn squared(u: [Uniform; 2], k: Vec2) -> Vec2 {
    Vec2::new(u[0], u[1]) * k
}

fn main() {}
