// A map of the unit square that does not say so.
use aether_core::prelude::*;

#[map]
fn spread(p: Vec2) -> Vec2 {
    Vec2::new(p.x.asin(), (p.y / (1.0 - p.y)).ln())
}

fn main() {}
