// A sampler as a method.
use aether_core::prelude::*;

struct Lobe {
    k: f64,
}

impl Lobe {
    #[sampler]
    fn scaled(&self, u: [Uniform; 1]) -> f64 {
        self.k * u[0]
    }
}

fn main() {}
