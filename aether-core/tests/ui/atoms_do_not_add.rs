// Adding a density with atoms to one without.
use aether_core::prelude::*;

#[sampler]
fn clamped(u: [Uniform; 1]) -> Mixed {
    if u[0] < 0.5 { Mixed::Continuous(u[0]) } else { Mixed::Atom(0, 0.5) }
}

#[sampler]
fn whole(u: [Uniform; 1]) -> f64 {
    2.0 * u[0]
}

fn sum(x: f64) -> f64 {
    (clamped().pdf(&Mixed::Continuous(x)) + whole().pdf(&x)).value()
}

fn main() {}
