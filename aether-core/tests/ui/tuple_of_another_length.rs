// Two points where the signature promises three.
use aether_core::prelude::*;

#[sampler]
fn pair(u: [Uniform; 3]) -> (f64, f64, f64) {
    (u[0], 2.0 * u[1])
}

fn main() {}
