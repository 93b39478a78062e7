// A `Mixed` point that does not say whether it is an atom.
use aether_core::prelude::*;

#[sampler]
fn clamped(u: [Uniform; 1]) -> Mixed {
    if u[0] < 0.5 { u[0] } else { Mixed::Atom(0, 0.5) }
}

fn main() {}
