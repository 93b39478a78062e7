// A parameter with the name of another, and one without a plain name.
use aether_core::prelude::*;

#[sampler]
fn pair(u: [Uniform; 2], (a, b): (f64, f64)) -> Vec2 {
    Vec2::new(a * u[0], b * u[1])
}

#[sampler]
fn twice([u, v]: [Uniform; 2], k: f64) -> Vec2 {
    Vec2::new(k * u, v)
}

fn main() {}
