// `powi` with a parameter.
use aether_core::prelude::*;

#[sampler]
fn power(u: [Uniform; 1], n: f64) -> f64 {
    u[0].powi(n)
}

fn main() {}
