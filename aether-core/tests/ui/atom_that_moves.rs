// An atom whose place depends on a uniform.
use aether_core::prelude::*;

#[sampler]
fn moving(u: [Uniform; 1]) -> Mixed {
    if u[0] < 0.5 { Mixed::Atom(0, 2.0 * u[0]) } else { Mixed::Continuous(u[0]) }
}

fn main() {}
