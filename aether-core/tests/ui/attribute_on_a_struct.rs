// The attribute on something that is no function.
use aether_core::prelude::*;

#[sampler]
struct Lobe {
    k: f64,
}

fn main() {}
