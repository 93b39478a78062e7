// A strategy whose signature is that of another kind of function.
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

#[strategy]
fn no_path(start: f64) -> Spot {
    return stop();
}

#[strategy]
fn no_vertex(path: &PathView<Spot>) {
    return stop();
}

#[strategy]
fn drawing(path: &PathView<Spot>, draw: f64) -> Spot {
    return stop();
}

fn main() {}
