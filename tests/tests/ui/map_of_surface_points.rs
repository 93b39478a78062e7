use aether_core::prelude::*;

#[map]
fn lift(x: Surface, h: f64) -> Surface {
    Surface::from_vec(x.vec() + Vec3::new(0.0, 0.0, h))
}

fn main() {}
