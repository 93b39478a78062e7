// A map of a point of a surface that only its sampler knows.
use aether_core::prelude::*;

#[map]
fn lift(x: Surface, h: f64) -> Surface {
    Surface::from_vec(x.vec() + Vec3::new(0.0, 0.0, h))
}

fn main() {}
