// What a `#[cfg]` leaves out is still there when the body is read.
use aether_core::prelude::*;

#[sampler]
fn either(u: [Uniform; 1]) -> f64 {
    #[cfg(feature = "wide")]
    let s = 3.0;
    #[cfg(not(feature = "wide"))]
    let s = 2.0;
    s * u[0]
}

#[sampler]
fn chain(u: [Uniform; 1]) -> f64 {
    #[cfg(feature = "wide")]
    let k = 3.0;
    scaled(2.0).sample(u)
}

#[sampler]
fn scaled(u: [Uniform; 1], k: f64) -> f64 {
    k * u[0]
}

fn main() {}
