// A random number or a clock in a body. A sampler is a function of its uniforms alone.
use aether_core::prelude::*;

#[sampler]
fn jittered(u: [Uniform; 1]) -> f64 {
    u[0] + rand::random::<f64>()
}

fn main() {}
