// Adding densities with respect to different measures.
use aether_core::prelude::*;

#[sampler]
fn cosine_hemisphere(u: [Uniform; 2]) -> Direction {
    let r = u[0].sqrt();
    let phi = TAU * u[1];
    Direction::new(r * phi.cos(), r * phi.sin(), (1.0 - u[0]).sqrt())
}

#[sampler]
fn square(u: [Uniform; 2], k: f64) -> Surface {
    Surface::new(k * u[0], k * u[1], 0.0)
}

fn sum(w: &Direction, x: &Surface) -> f64 {
    (cosine_hemisphere().pdf(w) + square(2.0).pdf(x)).value()
}

fn main() {}
