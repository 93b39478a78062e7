// A sampler that is `async`, `const`, `unsafe` or `extern`.
use aether_core::prelude::*;

#[sampler]
async fn later(u: [Uniform; 1]) -> f64 {
    u[0]
}

#[sampler]
const fn early(u: [Uniform; 1]) -> f64 {
    u[0]
}

#[sampler]
unsafe fn daring(u: [Uniform; 1]) -> f64 {
    u[0]
}

#[map]
extern "C" fn foreign(x: f64) -> f64 {
    2.0 * x
}

fn main() {}
