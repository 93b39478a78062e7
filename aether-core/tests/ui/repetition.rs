// A loop.
use aether_core::prelude::*;

#[sampler]
fn series(u: [Uniform; 1]) -> f64 {
    let x = u[0];
    for _ in 0..3 {
        x.sin();
    }
    x
}

fn main() {}
