// A return type that is no space.
use aether_core::prelude::*;

#[sampler]
fn scaled(u: [Uniform; 1]) -> String {
    String::from("two")
}

fn main() {}
