// An index that is not known. Which number is meant decides which formula it is.
use aether_core::prelude::*;

#[sampler]
fn picked(u: [Uniform; 2], i: usize) -> Vec2 {
    Vec2::new(u[0], 2.0 * u[i])
}

fn main() {}
