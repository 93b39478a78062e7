// Comparing vectors. Vectors have no order.
use aether_core::prelude::*;

#[sampler]
fn corner(u: [Uniform; 2], low: Vec2) -> Vec2 {
    let x = Vec2::new(u[0], u[1]);
    if x < low { x } else { low + x }
}

fn main() {}
