// Branches that multiply.
use aether_core::prelude::*;

#[sampler]
fn crumbs(u: [Uniform; 3]) -> Vec3 {
    let x = (8.0 * u[0]).fract();
    let y = (8.0 * u[1]).fract();
    Vec3::new(x, y, u[2])
}

fn main() {}
