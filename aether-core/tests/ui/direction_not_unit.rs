// A direction whose coordinates do not have length one.
use aether_core::prelude::*;

#[sampler]
fn hemisphere(u: [Uniform; 2]) -> Direction {
    let phi = TAU * u[1];
    Direction::new(u[0] * phi.cos(), u[0] * phi.sin(), (1.0 - u[0]).sqrt())
}

fn main() {}
