// A constant or a static of one's own. A macro sees its name, not its value.
use aether_core::prelude::*;

const RADIUS: f64 = 2.0;

#[sampler]
fn scaled(u: [Uniform; 1]) -> f64 {
    RADIUS * u[0]
}

fn main() {}
