// Two coordinates that are one and the same: the points lie on a line of the plane.
use aether_core::prelude::*;

#[sampler]
fn diagonal(u: [Uniform; 2]) -> Vec2 {
    Vec2::new(u[0] + u[1], u[0] + u[1])
}

fn main() {}
