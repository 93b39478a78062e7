// Two draws for one vertex: the density would be a marginal, an integral over one of them.
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

#[strategy]
fn sum(path: &PathView<Spot>) -> Spot {
    let x = draw(unit(0.0));
    let y = draw(unit(x));
    Spot(y)
}

fn main() {}
