// A refused sampler whose constructor may fail: that it is unwrapped is no second mistake.
use aether_core::prelude::*;

#[sampler(k in 0.5..=2.0)]
fn odd(u: [Uniform; 1], k: f64) -> f64 {
    k.next_up() * u[0]
}

fn main() {
    let _ = odd(1.0).unwrap();
}
