// Generics. An item is generic over its number type by itself.
use aether_core::prelude::*;

#[sampler]
fn scaled<R: Real>(u: [Uniform; 1], k: R) -> R {
    k * u[0]
}

fn main() {}
