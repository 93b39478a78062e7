// A piece that is a single point. It has a probability, not a density.
use aether_core::prelude::*;

#[sampler(p in 0.1..=0.9)]
fn mostly_zero(u: [Uniform; 1], p: f64) -> f64 {
    if u[0] < p { 0.0 } else { u[0] }
}

fn main() {}
