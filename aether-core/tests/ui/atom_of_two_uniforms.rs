// An atom whose probability is an integral: the comparison that leads to it looks at two uniforms.
use aether_core::prelude::*;

#[sampler(r in 0.0..=1.0)]
fn corner(u: [Uniform; 2], r: f64) -> Mixed<Vec2> {
    if u[0] + u[1] < r { Mixed::Atom(0, Vec2::new(0.0, 0.0)) } else { Mixed::Continuous(Vec2::new(u[0], u[1])) }
}

fn main() {}
