// A function whose type has a name that derived code uses.
use aether_core::prelude::*;

#[sampler]
fn option(u: [Uniform; 1], k: f64) -> f64 {
    k * u[0]
}

fn main() {}
