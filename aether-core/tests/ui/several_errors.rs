// Several mistakes in one body. All of them are reported.
use aether_core::prelude::*;

#[sampler]
fn wrong(u: [Uniform; 2]) -> Vec2 {
    let x = u[0].round();
    let y = u[2] + unknown;
    Vec2::new(x, y)
}

fn main() {}
