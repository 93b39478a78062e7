// References and lifetimes. Points and parameters are values.
use aether_core::prelude::*;

#[sampler]
fn nearest<'a>(u: [Uniform; 1], k: &'a f64) -> &'a f64 {
    k
}

#[sampler]
fn along(u: [Uniform; 1], axis: &Vec3) -> Curve {
    Curve::from_vec(u[0] * axis)
}

fn main() {}
