// Comparing real numbers for equality.
use aether_core::prelude::*;

#[sampler]
fn halves(u: [Uniform; 1]) -> f64 {
    if u[0] == 0.5 { 0.0 } else { u[0] }
}

fn main() {}
