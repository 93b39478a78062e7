// A domain of a name that is no parameter, here misspelt.
use aether_core::prelude::*;

#[sampler(aplha in 0.0..=1.0)]
fn scaled(u: [Uniform; 1], alpha: f64) -> f64 {
    alpha * u[0]
}

fn main() {}
