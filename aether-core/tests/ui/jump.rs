// A function that jumps, with an unknown number of jumps.
use aether_core::prelude::*;

#[sampler]
fn sawtooth(u: [Uniform; 1], k: f64) -> f64 {
    (k * u[0]).fract()
}

fn main() {}
