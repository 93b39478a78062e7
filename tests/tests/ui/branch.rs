use aether_core::prelude::*;

#[sampler]
fn tent(u: [Uniform; 1]) -> f64 {
    if u[0] < 0.5 { (2.0 * u[0]).sqrt() - 1.0 } else { 1.0 - (2.0 - 2.0 * u[0]).sqrt() }
}

fn main() {}
