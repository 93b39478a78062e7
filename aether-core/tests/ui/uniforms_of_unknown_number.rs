// As many uniforms as a constant says. The number of unknowns must be known to the macro.
use aether_core::prelude::*;

const N: usize = 2;

#[sampler]
fn square(u: [Uniform; N]) -> Vec2 {
    Vec2::new(u[0], u[1])
}

#[sampler]
fn any(u: &[Uniform]) -> Vec2 {
    Vec2::new(u[0], u[1])
}

#[sampler]
fn apart(u: Uniform, v: Uniform) -> Vec2 {
    Vec2::new(u, v)
}

fn main() {}
