// More uniforms than the space has dimensions: the density would be a marginal.
use aether_core::prelude::*;

#[sampler]
fn direction(u: [Uniform; 3]) -> Direction {
    let z = u[0] * u[2];
    let r = (1.0 - z * z).sqrt();
    let phi = TAU * u[1];
    Direction::new(r * phi.cos(), r * phi.sin(), z)
}

fn main() {}
