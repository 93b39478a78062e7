//! What lies inside one piece of a table: samplers and maps whose densities are derived.

use crate::prelude::*;

/// Uniform on [a, b).
#[sampler]
pub fn uniform_interval(u: [Uniform; 1], a: f64, b: f64) -> f64 {
    a + (b - a) * u[0]
}

/// Density proportional to the line from `a` at zero to `b` at one.
#[sampler(a in 0.0..=1.0, b in 0.0..=1.0)]
pub fn linear(u: [Uniform; 1], a: f64, b: f64) -> f64 {
    let s = ((1.0 - u[0]) * a * a + u[0] * b * b).sqrt();
    u[0] * (a + b) / (a + s)
}

/// The unit interval stretched to [a, b].
#[map]
pub fn stretched(t: f64, a: f64, b: f64) -> f64 {
    a + (b - a) * t
}

/// Uniform on a rectangle.
#[sampler]
pub fn uniform_rectangle(u: [Uniform; 2], low: Vec2, high: Vec2) -> Vec2 {
    Vec2::new(low.x + (high.x - low.x) * u[0], low.y + (high.y - low.y) * u[1])
}

/// The unit square stretched to a rectangle.
#[map]
pub fn stretched_square(t: Vec2, low: Vec2, high: Vec2) -> Vec2 {
    Vec2::new(low.x + (high.x - low.x) * t.x, low.y + (high.y - low.y) * t.y)
}

/// The direction with polar angle πv and azimuth 2πu. There is none at the pole, where the azimuth
/// is lost, nor so close to it that the squares of coordinates vanish in `f32`; the least uniform above
/// zero is larger.
#[sampler]
pub fn latitude_longitude(u: [Uniform; 2]) -> Direction {
    require(u[1] > 1e-18);
    let theta = PI * u[1];
    let phi = TAU * u[0];
    Direction::new(theta.sin() * phi.cos(), theta.sin() * phi.sin(), theta.cos())
}

/// A piece of a monotone rational-quadratic spline on the unit square, with slopes `a` and `b` at
/// its ends.
#[sampler(a in 1e-3..=1e3, b in 1e-3..=1e3)]
pub fn rational_quadratic(u: [Uniform; 1], a: f64, b: f64) -> f64 {
    let t = u[0];
    (t * t + a * t * (1.0 - t)) / (1.0 + (a + b - 2.0) * t * (1.0 - t))
}
