// A branch that the declared domain excludes, where that is more than the compiler can prove.
use aether_core::prelude::*;

#[sampler(k in 1.0..=2.0)]
fn switched(u: [Uniform; 1], k: f64) -> f64 {
    if (k * u[0]).sin() + (u[0] / k).exp() > 3.9 { u[0] * k } else { u[0] / k }
}

fn main() {}
