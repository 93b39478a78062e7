// A method that the language does not know.
use aether_core::prelude::*;

#[sampler]
fn smooth(u: [Uniform; 1]) -> f64 {
    u[0].smoothstep()
}

fn main() {}
