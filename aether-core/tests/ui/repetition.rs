// A loop that goes on until something holds.
use aether_core::prelude::*;

#[sampler]
fn series(u: [Uniform; 1]) -> f64 {
    let mut x = u[0];
    while x < 1.0 {
        x = 2.0 * x;
    }
    x
}

fn main() {}
