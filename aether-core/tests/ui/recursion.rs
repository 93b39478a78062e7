// A sampler that calls itself.
use aether_core::prelude::*;

#[sampler]
fn nested(u: [Uniform; 1], k: f64) -> f64 {
    if u[0] < 0.5 { k * u[0] } else { nested(2.0 * k) }
}

fn main() {}
