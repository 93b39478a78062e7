//! Rows that one formula undoes.

use aether_core::prelude::*;

/// Row 1: uniform on [a, b].
#[sampler]
pub fn affine(u: [Uniform; 1], a: f64, b: f64) -> f64 {
    a + (b - a) * u[0]
}

/// Row 2: density proportional to a power.
#[sampler]
pub fn power(u: [Uniform; 1], k: f64) -> f64 {
    u[0].powf(1.0 / k)
}

/// Row 3: free flight through a homogeneous medium with extinction s.
#[sampler]
pub fn exponential(u: [Uniform; 1], s: f64) -> f64 {
    -(-u[0]).ln_1p() / s
}

/// Row 4: free flight conditioned on an event before the distance d.
#[sampler]
pub fn truncated_exponential(u: [Uniform; 1], s: f64, d: f64) -> f64 {
    -(u[0] * (-s * d).exp_m1()).ln_1p() / s
}

/// Row 5: density proportional to the line from a at 0 to b at 1.
#[sampler(a in 0.0.., b in 0.0..)]
pub fn linear(u: [Uniform; 1], a: f64, b: f64) -> f64 {
    let s = ((1.0 - u[0]) * a * a + u[0] * b * b).sqrt();
    u[0] * (a + b) / (a + s)
}

/// Row 18: Weibull with scale l and shape k.
#[sampler]
pub fn weibull(u: [Uniform; 1], l: f64, k: f64) -> f64 {
    l * (-(-u[0]).ln_1p()).powf(1.0 / k)
}

/// Row 19: Gumbel with mode m and scale b.
#[sampler]
pub fn gumbel(u: [Uniform; 1], m: f64, b: f64) -> f64 {
    m - b * (-u[0].ln()).ln()
}

/// Row 23: softplus of a logistic variable, an exponential one in disguise.
#[sampler]
pub fn softplus_logistic(u: [Uniform; 1]) -> f64 {
    let logistic = (u[0] / (1.0 - u[0])).ln();
    logistic.exp().ln_1p()
}

/// Row 42: uniform on a disk, by polar coordinates.
#[sampler]
pub fn polar_disk(u: [Uniform; 2], radius: f64) -> Vec2 {
    let r = radius * u[0].sqrt();
    let phi = TAU * u[1];
    Vec2::new(r * phi.cos(), r * phi.sin())
}

/// Row 57: an affine map of two logistic variables.
#[sampler]
pub fn affine_logistics(u: [Uniform; 2], a: f64, b: f64, c: f64, d: f64, t0: f64, t1: f64) -> Vec2 {
    let x = (u[0] / (1.0 - u[0])).ln();
    let y = (u[1] / (1.0 - u[1])).ln();
    Vec2::new(t0 + a * x + b * y, t1 + c * x + d * y)
}

/// Row 60: uniform on the sphere.
#[sampler]
pub fn uniform_sphere(u: [Uniform; 2]) -> Direction {
    let z = 1.0 - 2.0 * u[0];
    let r = (1.0 - z * z).sqrt();
    let phi = TAU * u[1];
    Direction::new(r * phi.cos(), r * phi.sin(), z)
}

/// Row 61: uniform in the angles of an equirectangular map.
#[sampler]
pub fn equirectangular(u: [Uniform; 2]) -> Direction {
    let theta = PI * u[0];
    let phi = TAU * u[1];
    Direction::new(theta.sin() * phi.cos(), theta.sin() * phi.sin(), theta.cos())
}

/// Row 62: uniform on the hemisphere.
#[sampler]
pub fn uniform_hemisphere(u: [Uniform; 2]) -> Direction {
    let z = u[0];
    let r = (1.0 - z * z).sqrt();
    let phi = TAU * u[1];
    Direction::new(r * phi.cos(), r * phi.sin(), z)
}

/// Row 63: directions about +z, distributed as cos(theta) / pi.
#[sampler]
pub fn cosine_hemisphere(u: [Uniform; 2]) -> Direction {
    let r = u[0].sqrt();
    let phi = TAU * u[1];
    Direction::new(r * phi.cos(), r * phi.sin(), (1.0 - u[0]).sqrt())
}

/// Row 64: directions about +z, distributed as a power of the cosine.
#[sampler]
pub fn power_cosine(u: [Uniform; 2], n: f64) -> Direction {
    let z = u[0].powf(1.0 / (n + 1.0));
    let r = (1.0 - z * z).sqrt();
    let phi = TAU * u[1];
    Direction::new(r * phi.cos(), r * phi.sin(), z)
}

/// Row 93: uniform on a sphere's surface in space.
#[sampler]
pub fn sphere_surface(u: [Uniform; 2], centre: Vec3, radius: f64) -> Surface {
    let z = 1.0 - 2.0 * u[0];
    let r = (1.0 - z * z).sqrt();
    let phi = TAU * u[1];
    Surface::from_vec(centre + radius * Vec3::new(r * phi.cos(), r * phi.sin(), z))
}

/// Row 107: a point of the graph of a height field, uniform in its parameters.
#[sampler]
pub fn height_field(u: [Uniform; 2], h: f64) -> Surface {
    let (x, y) = (u[0], u[1]);
    Surface::new(x, y, h * (PI * x).sin() * (PI * y).sin())
}
