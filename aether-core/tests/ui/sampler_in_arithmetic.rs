// Computing with what another sampler draws. A composition passes points on, and nothing else.
use aether_core::prelude::*;

#[sampler]
fn unit(u: [Uniform; 1]) -> f64 {
    u[0]
}

#[sampler]
fn doubled(u: [Uniform; 1]) -> f64 {
    2.0 * unit().sample(u)
}

#[sampler]
fn shifted(u: [Uniform; 1], k: f64) -> f64 {
    let x = unit().sample(u);
    let y = k + x;
    y
}

fn main() {}
