// `let … else` and `if let`: every value of a body exists.
use aether_core::prelude::*;

#[sampler]
fn tested(u: [Uniform; 1], k: f64) -> f64 {
    let Some(x) = Some(u[0]) else { return k };
    x
}

#[sampler]
fn matched(u: [Uniform; 1], k: f64) -> f64 {
    if let Some(x) = Some(u[0]) { x } else { k * u[0] }
}

fn main() {}
