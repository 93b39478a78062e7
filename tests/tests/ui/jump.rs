use aether_core::prelude::*;

#[sampler]
fn sawtooth(u: [Uniform; 1]) -> f64 {
    let x = 3.0 * u[0];
    x - x.floor()
}

fn main() {}
