// A frame about a vector that may have any length.
use aether_core::prelude::*;

#[sampler]
fn about(u: [Uniform; 2], axis: Vec3) -> Direction {
    let z = 1.0 - 2.0 * u[0];
    let r = (1.0 - z * z).sqrt();
    let phi = TAU * u[1];
    Frame::around(axis) * Direction::new(r * phi.cos(), r * phi.sin(), z)
}

fn main() {}
