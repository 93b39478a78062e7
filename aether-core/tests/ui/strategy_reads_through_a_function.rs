// A strategy that hands its path to a function: what is read of it could not be seen.
use aether_core::PathView;
use aether_core::prelude::*;
use aether_core::strategy::Vertex;

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

fn centre(path: &PathView<Spot>) -> f64 {
    path.last().map_or(0.0, |spot| spot.0)
}

#[strategy]
fn around(path: &PathView<Spot>) -> Spot {
    let x = draw(unit(centre(path)));
    Spot(x)
}

#[strategy]
fn back(path: &PathView<Spot>, steps: usize) -> Spot {
    let there = given(path.back(steps));
    let x = draw(unit(there.0));
    Spot(x)
}

fn main() {}
