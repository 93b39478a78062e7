// A relation with a name that is no parameter.
use aether_core::prelude::*;

#[sampler(where near < far)]
fn between(u: [Uniform; 1], near: f64, distance: f64) -> f64 {
    near + (distance - near) * u[0]
}

fn main() {}
