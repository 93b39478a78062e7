// A vertex that is made from twice the point that was drawn.
use aether_core::prelude::*;
use aether_core::{PathView, strategy::Vertex};

#[derive(Clone, Copy, Debug)]
struct Spot(f64);

impl Vertex for Spot {
    type Real = f64;
    type Point = f64;
    fn point(&self) -> f64 {
        self.0
    }
}

#[sampler]
fn unit(u: [Uniform; 1]) -> f64 {
    u[0]
}

#[strategy]
fn wrong(path: &PathView<Spot>) -> Spot {
    let x = draw(unit());
    Spot(2.0 * x)
}

fn main() {}
