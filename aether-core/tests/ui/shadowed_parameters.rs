// Names that stand for something else than what is read later; a constant as a pattern.
use aether_core::prelude::*;

#[sampler(k in 0.5..=4.0)]
fn stepped(u: [Uniform; 1], k: f64) -> f64 {
    let k = 2.0 * k;
    let m = precomputed(k.trunc());
    m * u[0] + k
}

#[sampler]
fn scaled(u: [Uniform; 1], k: f64) -> f64 {
    k * u[0]
}

#[map]
fn shifted(p: f64, x: f64) -> f64 {
    p * 3.0 + x
}

#[sampler]
fn chain(u: [Uniform; 1], k: f64) -> f64 {
    let x = scaled(k).sample(u);
    let k = 5.0;
    shifted(k).apply(&x)
}

#[sampler]
fn matched(u: [Uniform; 1]) -> f64 {
    match u[0] {
        PI => 1.0,
        x => x,
    }
}

fn main() {}
