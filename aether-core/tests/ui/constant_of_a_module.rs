// A constant of another module, by the name of one of `std`.
use aether_core::prelude::*;

mod mine {
    pub const PI: f64 = 3.0;
}

#[sampler]
fn rough(u: [Uniform; 1]) -> f64 {
    mine::PI * u[0] + std::f64::consts::PI
}

fn main() {}
