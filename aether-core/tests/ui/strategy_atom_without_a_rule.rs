// Several atoms, and nothing that tells from a vertex which one it is.
use aether_core::prelude::*;
use aether_core::strategy::{Recall, Vertex};
use aether_core::{PathView, coin};

#[derive(Clone, Copy, Debug)]
struct Spot(u8);

impl Vertex for Spot {
    type Real = f64;
    type Point = u8;
    fn point(&self) -> u8 {
        self.0
    }
}

impl Recall<u8> for Spot {
    fn recall(&self) -> Option<u8> {
        Some(self.0)
    }
}

#[strategy]
fn lamp(path: &PathView<Spot>) -> Spot {
    let left = choose(coin(0.5));
    let lamp = constant(Some(if left { 1 } else { 2 }));
    Spot(lamp)
}

fn main() {}
