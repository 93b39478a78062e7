// A vertex made from a point of another space than its own.
use aether_core::prelude::*;
use aether_core::PathView;
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

#[sampler]
fn square(u: [Uniform; 2]) -> Vec2 {
    Vec2::new(u[0], u[1])
}

#[strategy]
fn scatter(path: &PathView<Spot>) -> Spot {
    let w = draw(square());
    Spot(w.x)
}

fn main() {}
