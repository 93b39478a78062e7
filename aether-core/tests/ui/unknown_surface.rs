// A point on a surface whose identity is computed.
use aether_core::prelude::*;

#[sampler]
fn square(u: [Uniform; 2]) -> SurfacePoint {
    SurfacePoint::new(Vec3::new(u[0], u[1], 0.0), 7)
}

fn main() {}
