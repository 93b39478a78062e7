// Mistakes in strategies that yield several vertices with one draw.
use aether_core::prelude::*;
use aether_core::PathView;
use aether_core::strategy::{Recall, Vertex};

#[derive(Clone, Copy, Debug)]
struct Spot(f64);

impl Vertex for Spot {
    type Real = f64;
    type Point = f64;
    fn point(&self) -> f64 {
        self.0
    }
}

impl Recall<u8> for Spot {
    fn recall(&self) -> Option<u8> {
        Some(self.0 as u8)
    }
}

#[sampler]
fn square(u: [Uniform; 2]) -> (f64, f64) {
    (u[0], u[1])
}

#[strategy]
fn a_tuple(path: &PathView<Spot>) -> (Spot, Spot) {
    let x = draw(square());
    (Spot(x.0), Spot(x.1))
}

#[strategy]
fn of_any_number<const N: usize>(path: &PathView<Spot>) -> [Spot; N] {
    stop()
}

#[strategy]
fn atoms(path: &PathView<Spot>) -> [Spot; 2] {
    let lamp = constant(Some(1));
    [Spot(f64::from(lamp)), Spot(0.0)]
}

#[strategy]
fn in_another_order(path: &PathView<Spot>) -> [Spot; 2] {
    let x = draw(square());
    [Spot(x.1), Spot(x.0)]
}

fn both(x: (f64, f64)) -> [Spot; 2] {
    [Spot(x.0), Spot(x.1)]
}

#[strategy]
fn made_elsewhere(path: &PathView<Spot>) -> [Spot; 2] {
    let x = draw(square());
    both(x)
}

#[strategy]
fn kept_by_none(path: &PathView<Spot>) -> [Spot; 2] {
    let x = draw(square());
    let wall: u8 = constant(Some(x.0 as u8));
    if wall == 0 {
        return stop();
    }
    [Spot(x.0), Spot(x.1)]
}

#[strategy]
fn of_another(path: &PathView<Spot>) -> [Spot; 2] {
    delegate(made_elsewhere())
}

fn main() {}
