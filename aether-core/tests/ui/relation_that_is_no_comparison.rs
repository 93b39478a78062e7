// A relation by a function. What it says could not be made use of.
use aether_core::prelude::*;

#[sampler(where a.is_finite())]
fn scaled(u: [Uniform; 1], a: f64) -> f64 {
    a * u[0]
}

fn main() {}
