// A relation with what is sampled. It would be a branch of the body.
use aether_core::prelude::*;

#[sampler(where u < a)]
fn half(u: [Uniform; 1], a: f64) -> f64 {
    u[0] * a
}

fn main() {}
