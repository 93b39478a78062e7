// Maps that turn back too often, or of which there is no proof how often they do.
use aether_core::prelude::*;

// The larger the parameter, the more often.
#[sampler]
fn waves(u: [Uniform; 1], k: f64) -> f64 {
    u[0] + (k * u[0]).sin()
}

// More pieces than are built.
#[sampler]
fn shaken(u: [Uniform; 1]) -> f64 {
    u[0] + (40.0 * u[0]).sin()
}

// Four turning points at most, which all are one place where the parameter is zero.
#[sampler(k in -0.5..=0.5)]
fn flat(u: [Uniform; 1], k: f64) -> f64 {
    (u[0] - 0.3).powi(5) + 0.1 * k * (u[0].powi(2).sin() + u[0])
}

fn main() {}
