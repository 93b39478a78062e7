// A literal with a suffix. The same body runs in every precision, so literals have none.
use aether_core::prelude::*;

#[sampler]
fn halved(u: [Uniform; 1]) -> f64 {
    0.5f32 * u[0]
}

fn main() {}
