// A map of two points. A map takes one point to one point.
use aether_core::prelude::*;

#[map]
fn midpoint(ends: (Vec3, Vec3)) -> Vec3 {
    0.5 * (ends.0 + ends.1)
}

fn main() {}
