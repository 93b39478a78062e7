// A manifold in a space of more dimensions than there are.
use aether_core::prelude::*;

#[sampler]
fn products(u: [Uniform; 3]) -> Embedded<3, 9> {
    let [a, b, c] = u;
    Embedded([a, b, c, a * a, a * b, a * c, b * b, b * c, c * c])
}

fn main() {}
