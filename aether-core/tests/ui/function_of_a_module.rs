// A function of another module, with the name of one of the language.
use aether_core::prelude::*;

mod mine {
    pub fn erf(x: f64) -> f64 {
        x
    }
}

#[sampler]
fn rough(u: [Uniform; 1]) -> f64 {
    mine::erf(u[0])
}

fn main() {}
