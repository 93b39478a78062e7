// Strategies that hand over to another one too late, or in the middle.
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

#[strategy]
fn step(path: &PathView<Spot>, start: f64) -> Spot {
    let x = draw(unit(start));
    Spot(x)
}

#[strategy]
fn after_a_draw(path: &PathView<Spot>, start: f64) -> Spot {
    let w = draw(unit(0.0));
    if w < 0.5 { delegate(step(start)) } else { Spot(w) }
}

#[strategy]
fn made_of_a_local_value(path: &PathView<Spot>) -> Spot {
    let here = given(path.last());
    delegate(step(here.0))
}

#[strategy]
fn in_the_middle(path: &PathView<Spot>) -> Spot {
    let next = delegate(step(0.0));
    Spot(next.0 + 1.0)
}

fn main() {}
