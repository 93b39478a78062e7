// Fewer uniforms than the space has dimensions: a circle is no part of the plane's area.
use aether_core::prelude::*;

#[sampler]
fn circle(u: [Uniform; 1]) -> Vec2 {
    let phi = TAU * u[0];
    Vec2::new(phi.cos(), phi.sin())
}

fn main() {}
