// Equations that may have several solutions, and one that cannot be read.
use aether_core::prelude::*;

#[sampler]
fn kepler(u: [Uniform; 1], e: f64) -> f64 {
    solve(|a| a - e * a.sin(), 0.0..TAU, TAU * u[0])
}

#[sampler(e in 0.0..=1.5)]
fn hyperbolic(u: [Uniform; 1], e: f64) -> f64 {
    solve(|a| a - e * a.sin(), 0.0..TAU, TAU * u[0])
}

fn function(x: f64) -> f64 {
    x.exp()
}

#[sampler]
fn elsewhere(u: [Uniform; 1]) -> f64 {
    solve(function, 0.0..1.0, u[0])
}

fn main() {}
