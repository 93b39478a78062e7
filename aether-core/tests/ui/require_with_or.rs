// `require` with an alternative. It takes comparisons that hold all at once.
use aether_core::prelude::*;

#[map]
fn hit(w: Direction, height: f64) -> Vec2 {
    let t = height / w.z;
    require(t > 0.0 || w.x > 0.5);
    Vec2::new(t * w.x, t * w.y)
}

fn main() {}
