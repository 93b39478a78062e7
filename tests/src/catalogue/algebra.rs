//! Samplers that need most of the functions of the language, and two whose inverses are numerical.

use aether_core::prelude::*;

/// Row 9: the Epanechnikov kernel, a cubic solved by trigonometry.
#[sampler]
pub fn epanechnikov(u: [Uniform; 1]) -> f64 {
    2.0 * ((2.0 * u[0] - 1.0).asin() / 3.0).sin()
}

/// Row 10: the logistic distribution.
#[sampler(s in 1e-3..)]
pub fn logistic(u: [Uniform; 1], s: f64) -> f64 {
    s * (u[0].ln() - (-u[0]).ln_1p())
}

/// Row 11: the logistic distribution between a and b, by probabilities of both tails. Exponentials are those of
/// negative numbers, which do not overflow: 1 / (1 + exp(-a / s)) is exp((a - |a|) / 2 s) / (1 + exp(-|a| / s)).
#[sampler(s in 1e-3..)]
pub fn truncated_logistic(u: [Uniform; 1], s: f64, a: f64, b: f64) -> f64 {
    let at_a = 1.0 + (-a.abs() / s).exp();
    let at_b = 1.0 + (-b.abs() / s).exp();
    let below_a = ((a - a.abs()) / (2.0 * s)).exp() / at_a;
    let below_b = ((b - b.abs()) / (2.0 * s)).exp() / at_b;
    let above_a = ((-a - a.abs()) / (2.0 * s)).exp() / at_a;
    let above_b = ((-b - b.abs()) / (2.0 * s)).exp() / at_b;
    let below = (1.0 - u[0]) * below_a + u[0] * below_b;
    let above = (1.0 - u[0]) * above_a + u[0] * above_b;
    s * (below / above).ln()
}

/// Row 11 as printed. Further out, probabilities next to one are one in single precision.
// A narrow range loses digits, which is known.
#[allow(deprecated)]
#[sampler(s in 0.5..=10.0, a in -4.0..=4.0, b in -4.0..=4.0)]
pub fn truncated_logistic_as_printed(u: [Uniform; 1], s: f64, a: f64, b: f64) -> f64 {
    let below_a = 1.0 / (1.0 + (-a / s).exp());
    let below_b = 1.0 / (1.0 + (-b / s).exp());
    let p = (1.0 - u[0]) * below_a + u[0] * below_b;
    s * (p / (1.0 - p)).ln()
}

/// Row 14: Cauchy by the cotangent.
#[sampler(g in 1e-3..)]
pub fn cauchy(u: [Uniform; 1], g: f64) -> f64 {
    -g / (PI * u[0]).tan()
}

/// Row 14 again, by the tangent.
#[sampler(g in 1e-3..)]
pub fn cauchy_by_tangent(u: [Uniform; 1], g: f64) -> f64 {
    g * (PI * (u[0] - 0.5)).tan()
}

/// Row 20: generalised Pareto.
#[sampler(s in 1e-3..)]
pub fn pareto(u: [Uniform; 1], m: f64, s: f64, xi: f64) -> f64 {
    m + s * (-xi * (-u[0]).ln_1p()).exp_m1() / xi
}

/// Row 21: Kumaraswamy.
#[sampler(a in 0.1..=100.0, b in 0.1..=1e7)]
pub fn kumaraswamy(u: [Uniform; 1], a: f64, b: f64) -> f64 {
    (-((-u[0]).ln_1p() / b).exp_m1()).powf(1.0 / a)
}

/// Row 22: a power law between a and b.
#[sampler(a in 1e-6..=1.0, b in 1.5..=1e6)]
pub fn power_law(u: [Uniform; 1], a: f64, b: f64, p: f64) -> f64 {
    let k = 1.0 - p;
    a * ((u[0] * (k * (b / a).ln()).exp_m1()).ln_1p() / k).exp()
}

/// Row 24: sinh-arcsinh of a logistic variable.
#[sampler(d in 0.1..=10.0)]
pub fn sinh_arcsinh(u: [Uniform; 1], e: f64, d: f64) -> f64 {
    let z = u[0].ln() - (-u[0]).ln_1p();
    ((z.asinh() + e) * d).sinh()
}

/// Row 25: heavy tails of Lambert's W, over a logistic variable.
#[sampler(h in 1e-12..=0.5)]
pub fn heavy_tails(u: [Uniform; 1], h: f64) -> f64 {
    let z = u[0].ln() - (-u[0]).ln_1p();
    z * (0.5 * h * z * z).exp()
}

/// Row 26: distances along a ray that see a light at distance d under equal angles.
#[sampler(d in 1e-9..)]
pub fn equiangular(u: [Uniform; 1], d: f64, a: f64, b: f64) -> f64 {
    let width = ((b - a) * d).atan2(d * d + a * b);
    d * (a.atan2(d) + u[0] * width).tan()
}

/// Row 26 as printed: Kulla and Fajardo, "Importance Sampling Techniques for Path Tracing in Participating Media" (2012).
#[sampler(d in 1e-9..)]
pub fn equiangular_as_printed(u: [Uniform; 1], d: f64, a: f64, b: f64) -> f64 {
    let theta_a = (a / d).atan();
    let theta_b = (b / d).atan();
    d * ((1.0 - u[0]) * theta_a + u[0] * theta_b).tan()
}

/// Row 27: wavelengths as the eye sees them.
#[sampler]
pub fn wavelength(u: [Uniform; 1]) -> f64 {
    538.0 - 138.888889 * (0.85691062 - 1.82750197 * u[0]).atanh()
}

/// Row 28: free flight where the extinction grows linearly.
#[sampler(a in 0.0.., b in 1e-15..)]
pub fn linear_extinction(u: [Uniform; 1], a: f64, b: f64) -> f64 {
    let tau = -(-u[0]).ln_1p();
    2.0 * tau / (a + (a * a + 2.0 * b * tau).sqrt())
}

/// Row 29: free flight where the extinction falls exponentially; some of it leaves.
#[sampler(k in 1e-9.., h in 1e-13..)]
pub fn falling_extinction(u: [Uniform; 1], k: f64, h: f64) -> f64 {
    -(h * (-u[0]).ln_1p() / k).ln_1p() / h
}

/// Row 33: the cosine of a uniform angle.
#[sampler]
pub fn arcsine(u: [Uniform; 1]) -> f64 {
    (TAU * u[0]).cos()
}

/// Row 108: directions about +z whose angle is distributed evenly in its logarithm.
#[sampler(r1 in 1e-9..=1.5, r2 in 1e-9..=1.5, where r1 < r2)]
pub fn small_angles(u: [Uniform; 2], r1: f64, r2: f64) -> Direction {
    let theta = r1 * (r2 / r1).powf(u[0]);
    let phi = TAU * u[1];
    Direction::new(theta.sin() * phi.cos(), theta.sin() * phi.sin(), theta.cos())
}

/// Row 85: normals of GGX that are visible from w, as they were first printed: Heitz, "Sampling the GGX Distribution of
/// Visible Normals" (2018).
#[sampler(alpha in 1e-3..=1.0)]
pub fn visible_normals_as_printed(u: [Uniform; 2], alpha: f64, w: Direction) -> Direction {
    let v = Vec3::new(alpha * w.x, alpha * w.y, w.z).normalize();
    let t1 = Vec3::new(-v.y, v.x, 0.0).normalize();
    let t2 = v.cross(t1);
    let r = u[0].sqrt();
    let phi = TAU * u[1];
    let a = r * phi.cos();
    let s = 0.5 * (1.0 + v.z);
    let b = (1.0 - s) * (1.0 - a * a).sqrt() + s * r * phi.sin();
    let n = a * t1 + b * t2 + (1.0 - a * a - b * b).sqrt() * v;
    Direction::from_vec(Vec3::new(alpha * n.x, alpha * n.y, n.z).normalize())
}

/// Row 85 with two roughnesses, as they were first printed.
#[sampler(alpha_x in 1e-3..=1.0, alpha_y in 1e-3..=1.0)]
pub fn anisotropic_normals_as_printed(
    u: [Uniform; 2],
    alpha_x: f64,
    alpha_y: f64,
    w: Direction,
) -> Direction {
    let v = Vec3::new(alpha_x * w.x, alpha_y * w.y, w.z).normalize();
    let t1 = Vec3::new(-v.y, v.x, 0.0).normalize();
    let t2 = v.cross(t1);
    let r = u[0].sqrt();
    let phi = TAU * u[1];
    let a = r * phi.cos();
    let s = 0.5 * (1.0 + v.z);
    let b = (1.0 - s) * (1.0 - a * a).sqrt() + s * r * phi.sin();
    let n = a * t1 + b * t2 + (1.0 - a * a - b * b).sqrt() * v;
    Direction::from_vec(Vec3::new(alpha_x * n.x, alpha_y * n.y, n.z).normalize())
}

/// Row 39: a sum of three increasing functions; only the inverse is numerical.
#[sampler(k in 0.0..=100.0)]
pub fn quintic(u: [Uniform; 1], k: f64) -> f64 {
    u[0] + k * u[0].powi(5) + u[0].ln_1p()
}

/// Row 115: a planar flow of a pair of normal variables; the coordinates are coupled through w · z.
#[sampler(k in 0.0..=10.0)]
pub fn planar_flow(u: [Uniform; 2], k: f64, w: Vec2, b: f64) -> Vec2 {
    let r = (-2.0 * (-u[0]).ln_1p()).sqrt();
    let phi = TAU * u[1];
    let z = Vec2::new(r * phi.cos(), r * phi.sin());
    z + k * (w.dot(z) + b).tanh() * w
}
