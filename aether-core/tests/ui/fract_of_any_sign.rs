// `fract` of a number that may be negative, which turns round at zero.
use aether_core::prelude::*;

#[sampler(k in -1.0..=1.0)]
fn turned(u: [Uniform; 1], k: f64) -> f64 {
    (u[0] + k).fract()
}

fn main() {}
