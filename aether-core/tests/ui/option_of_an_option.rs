// An option of an option. A point exists, or it does not.
use aether_core::prelude::*;

#[sampler]
fn maybe(u: [Uniform; 1]) -> Option<f64> {
    let inner = if u[0] < 0.5 { Some(u[0]) } else { None };
    let outer = Some(inner);
    if let Some(x) = outer { x } else { None }
}

fn main() {}
