// Casting to a precision. Numbers are real, and generic over their precision; a cast would fix one.
use aether_core::prelude::*;

#[sampler]
fn wedges(u: [Uniform; 1], n: f64) -> f64 {
    (n * u[0]) as f32 as f64
}

fn main() {}
