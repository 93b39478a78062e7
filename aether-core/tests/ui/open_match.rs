// A `match` whose last arm has a condition.
use aether_core::prelude::*;

#[sampler]
fn thirds(u: [Uniform; 1]) -> f64 {
    match u[0] {
        x if x < 0.25 => 2.0 * x,
        x if x < 0.5 => 1.0 - x,
    }
}

fn main() {}
