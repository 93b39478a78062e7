// A function of one's own, at a sampled point.
use aether_core::prelude::*;

fn warp(x: f64) -> f64 {
    x * x
}

#[sampler]
fn warped(u: [Uniform; 1], k: f64) -> f64 {
    k * warp(u[0])
}

fn main() {}
