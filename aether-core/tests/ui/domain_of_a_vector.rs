// A range of numbers for a vector.
use aether_core::prelude::*;

#[sampler(offset in 0.0..=1.0)]
fn shifted(u: [Uniform; 2], offset: Vec2) -> Vec2 {
    offset + Vec2::new(u[0], u[1])
}

fn main() {}
