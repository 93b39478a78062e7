// A function of parameters only, at a sampled point.
use aether_core::prelude::*;

#[sampler]
fn gamma(u: [Uniform; 1]) -> f64 {
    ln_gamma(2.0 + u[0])
}

fn main() {}
