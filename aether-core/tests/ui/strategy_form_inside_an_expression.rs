// A special form inside an expression, a loop or a closure.
use aether_core::prelude::*;
use aether_core::strategy::Vertex;
use aether_core::{PathView, coin};

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
fn unit(u: [Uniform; 1], a: f64) -> f64 {
    a + u[0]
}

#[strategy]
fn nested(path: &PathView<Spot>) -> Spot {
    Spot(draw(unit(0.0)))
}

#[strategy]
fn tried(path: &PathView<Spot>) -> Spot {
    let here = path.last()?;
    let x = draw(unit(here.0));
    Spot(x)
}

#[strategy]
fn repeated(path: &PathView<Spot>) -> Spot {
    for _ in 0..3 {
        let on = choose(coin(0.5));
    }
    let x = draw(unit(0.0));
    Spot(x)
}

fn main() {}
