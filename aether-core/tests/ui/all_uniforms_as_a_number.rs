// The array of uniforms where one of them is meant.
use aether_core::prelude::*;

#[sampler]
fn probability(u: [Uniform; 1]) -> f64 {
    normal_cdf(u)
}

fn main() {}
