// A guard against rounding that some parameters make a branch, since their domain is not declared.
use aether_core::prelude::*;

#[sampler]
fn cone(u: [Uniform; 2], cos_max: f64) -> Direction {
    let c = 1.0 - u[0] + u[0] * cos_max;
    let s = (1.0 - c * c).max(0.0).sqrt();
    let phi = TAU * u[1];
    Direction::new(s * phi.cos(), s * phi.sin(), c)
}

fn main() {}
