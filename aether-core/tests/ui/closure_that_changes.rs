// A closure that changes what is outside of it. It stands for a formula.
use aether_core::prelude::*;

#[sampler]
fn walk(u: [Uniform; 1], k: f64) -> f64 {
    let mut x = u[0];
    let mut step = || x += k;
    step();
    step();
    x
}

fn main() {}
