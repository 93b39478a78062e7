// A mixture of samplers whose points live in different spaces, and of a single one.
use aether_core::discrete::coin;
use aether_core::mixture::mixture;
use aether_core::prelude::*;

#[sampler]
fn unit(u: [Uniform; 1], a: f64) -> f64 {
    a + u[0]
}

#[sampler]
fn square(u: [Uniform; 2]) -> Vec2 {
    Vec2::new(u[0], u[1])
}

fn main() {
    let line_or_square = mixture((unit(0.0), square()), coin(0.5));
    let single = mixture(unit(0.0), coin(0.5));
}
