// A name of the language that means something else around the item.
use aether_core::prelude::*;

const PI: f64 = 3.0;

fn normal_cdf(x: f64) -> f64 {
    0.5 * x
}

#[sampler]
fn turned(u: [Uniform; 1]) -> f64 {
    PI * u[0]
}

#[sampler]
fn halved(u: [Uniform; 1]) -> f64 {
    normal_cdf(2.0 * u[0])
}

fn main() {
    let (_, _) = (turned(), halved());
    let _ = (PI, normal_cdf(1.0));
}
