// Bit operations and other operators without an inverse.
use aether_core::prelude::*;

#[sampler]
fn masked(u: [Uniform; 1]) -> f64 {
    const N: u32 = 6 ^ 2;
    N as f64 * u[0]
}

fn main() {}
