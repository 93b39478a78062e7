// Whether more or fewer uniforms lead to the wall depends on the sign of a parameter, of which nothing is declared.
use aether_core::prelude::*;

#[sampler]
fn flight(u: [Uniform; 1], extinction: f64, wall: f64) -> Mixed {
    let t = -(-u[0]).ln_1p() / extinction;
    if t < wall { Mixed::Continuous(t) } else { Mixed::Atom(0, wall) }
}

fn main() {}
