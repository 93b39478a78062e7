// A sampler without uniforms.
use aether_core::prelude::*;

#[sampler]
fn constant_direction(normal: Direction) -> Direction {
    normal
}

fn main() {}
