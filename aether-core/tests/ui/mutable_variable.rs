// Changing a variable.
use aether_core::prelude::*;

#[sampler]
fn scaled(u: [Uniform; 1], k: f64) -> f64 {
    let mut x = u[0];
    x = k * x;
    x
}

// Both names are known after it.
#[sampler]
fn swapped(u: [Uniform; 2]) -> Vec2 {
    let (mut s, t) = (u[0], u[1]);
    Vec2::new(t, s)
}

fn main() {}
