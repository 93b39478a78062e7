// A branch that is never taken, which is more than the compiler can prove.
use aether_core::prelude::*;

#[sampler(k in 0.0..)]
fn switched(u: [Uniform; 1], k: f64) -> f64 {
    if k > k.exp() { u[0] * k } else { u[0] / (1.0 + k) }
}

fn main() {}
