// Maps that turn back, or of which there is no proof that they do not.
use aether_core::prelude::*;

// Turns twice inside.
#[sampler]
fn twice(u: [Uniform; 1]) -> f64 {
    u[0].powi(5) - 1.5 * u[0].powi(2) + 0.5625 * u[0]
}

// Increases for positive factors only.
#[sampler]
fn quintic(u: [Uniform; 1], k: f64) -> f64 {
    u[0] + k * u[0].powi(5)
}

fn main() {}
