// Changing a number through a reference to it.
use aether_core::prelude::*;

#[sampler]
fn bumped(u: [Uniform; 1]) -> f64 {
    fn bump(x: &mut f64) {
        *x += 1.0;
    }
    let mut x = u[0];
    bump(&mut x);
    x
}

fn main() {}
