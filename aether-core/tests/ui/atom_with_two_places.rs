// One number for two different points.
use aether_core::prelude::*;

#[sampler]
fn ends(u: [Uniform; 1]) -> Mixed {
    if u[0] < 0.25 {
        Mixed::Atom(0, -1.0)
    } else if u[0] > 0.75 {
        Mixed::Atom(0, 1.0)
    } else {
        Mixed::Continuous(u[0])
    }
}

fn main() {}
