use aether_core::prelude::*;

#[sampler]
fn mixed(u: [Uniform; 1]) -> f64 {
    u[0] + u[0].exp()
}

#[sampler]
fn cubic(u: [Uniform; 1]) -> f64 {
    u[0].powi(3) + u[0]
}

fn main() {}
