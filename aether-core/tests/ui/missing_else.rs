// An `if` without `else`: on one way the name has no value.
use aether_core::prelude::*;

#[sampler]
fn half(u: [Uniform; 1]) -> f64 {
    let x = if u[0] < 0.5 {
        2.0 * u[0]
    };
    x
}

fn main() {}
