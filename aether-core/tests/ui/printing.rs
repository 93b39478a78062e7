// Printing in a body. The body is mathematics; it is evaluated in several forms, or not at all.
use aether_core::prelude::*;

#[sampler]
fn printed(u: [Uniform; 1]) -> f64 {
    println!("{}", u[0]);
    2.0 * u[0]
}

fn main() {}
