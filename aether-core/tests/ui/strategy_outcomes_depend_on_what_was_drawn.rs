// A choice whose outcomes, and not only their probabilities, depend on what was drawn.
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
use aether_core::discrete::Cdf;

#[map]
fn shift(x: f64, distance: f64) -> f64 {
    x + distance
}

fn lobes(w: f64) -> Cdf<f64> {
    Cdf::new(&[w, 1.0 - w]).unwrap()
}

#[strategy]
fn scatter(path: &PathView<Spot>) -> Spot {
    let w = draw(unit(0.0));
    let lobe = choose(lobes(w));
    Spot(shift(lobe as f64).apply(&w))
}

fn main() {}
