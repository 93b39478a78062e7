// Two unknowns that cannot be told apart one after the other.
use aether_core::prelude::*;

#[sampler]
fn coupled(u: [Uniform; 2]) -> Vec2 {
    let (a, b) = (u[0], u[1]);
    Vec2::new(a + b.exp() * (4.0 * a).sin(), b + (a * b).cos())
}

fn main() {}
