// A branch that the declared domain excludes.
use aether_core::prelude::*;

#[sampler(k in 1.0..=2.0)]
fn switched(u: [Uniform; 1], k: f64) -> f64 {
    if k + 1.0 / k > 2.9 { u[0] * k } else { u[0] / k }
}

fn main() {}
