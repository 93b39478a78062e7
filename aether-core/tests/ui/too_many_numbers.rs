// A function of more parameters than an item may keep.
use aether_core::prelude::*;

#[sampler]
fn many(
    u: [Uniform; 1], a: Mat3, b: Mat3, c: Mat3, d: Mat3, e: Mat3, f: Mat3, g: Mat3, h: Mat3, i: Mat3,
    j: Mat3, k: Mat3, l: Mat3, m: Mat3, n: Mat3, o: Mat3,
) -> f64 {
    u[0] + a.x.x
}

fn main() {}
