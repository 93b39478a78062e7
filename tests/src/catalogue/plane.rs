//! The plane.

use aether_core::prelude::*;

/// Row 43: uniform on the disk, by concentric squares.
#[sampler]
pub fn concentric_disk(u: [Uniform; 2]) -> Vec2 {
    let (a, b) = (2.0 * u[0] - 1.0, 2.0 * u[1] - 1.0);
    let (r, theta) = if a.abs() > b.abs() {
        (a, PI / 4.0 * (b / a))
    } else {
        (b, PI / 2.0 - PI / 4.0 * (a / b))
    };
    Vec2::new(r * theta.cos(), r * theta.sin())
}

/// Row 44: uniform on a sector of an annulus with radii a and b, from the angle p over the angle d.
#[sampler(a in 0.0.., b in 1e-9.., d in 1e-6..=6.283185307179586)]
pub fn annular_sector(u: [Uniform; 2], a: f64, b: f64, p: f64, d: f64) -> Vec2 {
    let r = ((1.0 - u[0]) * a * a + u[0] * b * b).sqrt();
    let theta = p + d * u[1];
    Vec2::new(r * theta.cos(), r * theta.sin())
}

/// Row 50: a normal variable of the plane, by its Cholesky factor.
#[sampler(l11 in 1e-9.., l22 in 1e-9..)]
pub fn bivariate_normal(u: [Uniform; 2], l11: f64, l21: f64, l22: f64) -> Vec2 {
    let r = (-2.0 * (-u[0]).ln_1p()).sqrt();
    let phi = TAU * u[1];
    let (x, y) = (r * phi.cos(), r * phi.sin());
    Vec2::new(l11 * x, l21 * x + l22 * y)
}

/// Row 51: slopes of GGX microfacets.
#[sampler(alpha in 1e-6..)]
pub fn ggx_slopes(u: [Uniform; 2], alpha: f64) -> Vec2 {
    let r = alpha * (u[0] / (1.0 - u[0])).sqrt();
    let phi = TAU * u[1];
    Vec2::new(r * phi.cos(), r * phi.sin())
}

/// Row 54: a quadrilateral, by bilinear interpolation of its corners.
#[sampler]
pub fn bilinear_quad(u: [Uniform; 2], a: Vec2, b: Vec2, c: Vec2, d: Vec2) -> Vec2 {
    let (s, t) = (u[0], u[1]);
    (1.0 - s) * (1.0 - t) * a + s * (1.0 - t) * b + s * t * c + (1.0 - s) * t * d
}

/// Row 56: the complex square of a disk, written in polar coordinates; two preimages.
#[sampler]
pub fn complex_square(u: [Uniform; 2]) -> Vec2 {
    let phi = TAU * u[1];
    Vec2::new(u[0] * (2.0 * phi).cos(), u[0] * (2.0 * phi).sin())
}

/// Row 116: a radial flow of a normal variable.
#[sampler(alpha in 1e-3.., beta in 0.0..)]
pub fn radial_flow(u: [Uniform; 2], alpha: f64, beta: f64) -> Vec2 {
    let r = (-2.0 * (-u[0]).ln_1p()).sqrt();
    let phi = TAU * u[1];
    let z = Vec2::new(r * phi.cos(), r * phi.sin());
    (1.0 + beta / (alpha + r)) * z
}

/// Row 117: an affine coupling of two logistic variables.
#[sampler]
pub fn affine_coupling(u: [Uniform; 2], s: f64, t: f64) -> Vec2 {
    let a = (u[0] / (1.0 - u[0])).ln();
    let b = (u[1] / (1.0 - u[1])).ln();
    Vec2::new(a, b * (s * a.tanh()).exp() + t * a * a)
}

/// Row 52: uniform on a regular pentagon, by a wedge and a triangle.
#[sampler]
pub fn pentagon(u: [Uniform; 2]) -> Vec2 {
    let wedge = 5.0 * u[1];
    let k = wedge.floor();
    let t = wedge - k;
    let (a, b) = (TAU * k / 5.0, TAU * (k + 1.0) / 5.0);
    let r = u[0].sqrt();
    Vec2::new(r * ((1.0 - t) * a.cos() + t * b.cos()), r * ((1.0 - t) * a.sin() + t * b.sin()))
}

/// Row 52: uniform on a regular polygon, by a wedge and a triangle.
#[sampler(n in 3..=8)]
pub fn regular_polygon(u: [Uniform; 2], n: f64) -> Vec2 {
    let k = (n * u[1]).floor();
    let t = n * u[1] - k;
    let (a, b) = (TAU * k / n, TAU * (k + 1.0) / n);
    let r = u[0].sqrt();
    Vec2::new(r * ((1.0 - t) * a.cos() + t * b.cos()), r * ((1.0 - t) * a.sin() + t * b.sin()))
}

/// Row 46: a disk, by the elliptical grid.
#[sampler]
pub fn elliptical_grid(u: [Uniform; 2]) -> Vec2 {
    let (a, b) = (2.0 * u[0] - 1.0, 2.0 * u[1] - 1.0);
    Vec2::new(a * (1.0 - b * b / 2.0).sqrt(), b * (1.0 - a * a / 2.0).sqrt())
}

/// Row 53: density proportional to the bilinear interpolation of four corners.
#[sampler(w00 in 0.0.., w10 in 0.0.., w01 in 0.0.., w11 in 0.0..)]
pub fn bilinear_density(u: [Uniform; 2], w00: f64, w10: f64, w01: f64, w11: f64) -> Vec2 {
    let (a, b) = (w00 + w10, w01 + w11);
    let y = u[1] * (a + b) / (a + ((1.0 - u[1]) * a * a + u[1] * b * b).sqrt());
    let (c, d) = ((1.0 - y) * w00 + y * w01, (1.0 - y) * w10 + y * w11);
    let x = u[0] * (c + d) / (c + ((1.0 - u[0]) * c * c + u[0] * d * d).sqrt());
    Vec2::new(x, y)
}

/// Row 56: the complex square of a uniform disk, in Cartesian coordinates; two preimages.
#[sampler]
pub fn complex_square_xy(u: [Uniform; 2]) -> Vec2 {
    let r = u[0].sqrt();
    let phi = TAU * u[1];
    let (x, y) = (r * phi.cos(), r * phi.sin());
    Vec2::new(x * x - y * y, 2.0 * x * y)
}
