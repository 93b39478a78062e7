// A loop up to a number that is not known. How many turns there are decides which formula it is.
use aether_core::prelude::*;

#[sampler]
fn powers(u: [Uniform; 1], n: usize) -> f64 {
    let mut x = u[0];
    for _ in 0..n {
        x *= x;
    }
    x
}

fn main() {}
