// Two vertices that are made from a single point.
use aether_core::PathView;
use aether_core::prelude::*;
use aether_core::strategy::Vertex;

#[derive(Clone, Copy, Debug)]
struct Spot(Vec2);

impl Vertex for Spot {
    type Real = f64;
    type Point = Vec2;
    fn point(&self) -> Vec2 {
        self.0
    }
}

#[sampler]
fn intervals(u: [Uniform; 2]) -> (f64, f64) {
    (u[0], u[1])
}

#[strategy]
fn diagonal(path: &PathView<Spot>) -> [Spot; 2] {
    let x = draw(intervals());
    [Spot(Vec2::new(x.0, x.0)), Spot(Vec2::new(x.1, x.1))]
}

fn main() {}
