// A map follows a sampler of the space that it maps from, or one with atoms in it.

use aether_core::prelude::*;

/// Free flight that ends at a wall, if it gets there.
#[sampler(wall in 0.0..=1e3)]
fn flight(u: [Uniform; 1], wall: f64) -> Mixed {
    let t = -(-u[0]).ln_1p();
    if t < wall { Mixed::Continuous(t) } else { Mixed::Atom(0, wall) }
}

/// A direction about +z.
#[sampler]
fn cosine_hemisphere(u: [Uniform; 2]) -> Direction {
    let r = u[0].sqrt();
    let phi = TAU * u[1];
    Direction::new(r * phi.cos(), r * phi.sin(), (1.0 - u[0]).sqrt())
}

/// Another scale.
#[map]
fn stretch(x: f64, scale: f64) -> f64 {
    scale * x
}

/// A direction given in a frame, in world coordinates.
#[map]
fn rotate(w: Direction, frame: Frame) -> Direction {
    Direction::from_vec(frame.to_world(w))
}

fn main() {
    let frame = Frame::around(Direction::new(0.0, 0.6, 0.8));
    let _ = flight(3.0).unwrap().then(stretch(2.0)).sample([0.5]);
    let _ = cosine_hemisphere().then(rotate(frame)).sample([0.5, 0.5]);
    let _ = flight(3.0).unwrap().then(rotate(frame));
    let _ = cosine_hemisphere().then(stretch(2.0));
}
