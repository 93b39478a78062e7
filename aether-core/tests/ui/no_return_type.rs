// No return type, and so no space.
use aether_core::prelude::*;

#[sampler]
fn scaled(u: [Uniform; 1]) {
    2.0 * u[0];
}

fn main() {}
