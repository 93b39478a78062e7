// A result of another space than the signature promises.
use aether_core::prelude::*;

#[sampler]
fn disk(u: [Uniform; 2]) -> Direction {
    let r = u[0].sqrt();
    let phi = TAU * u[1];
    Vec2::new(r * phi.cos(), r * phi.sin())
}

fn main() {}
