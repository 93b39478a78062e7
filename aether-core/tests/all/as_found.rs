//! Samplers as they stand in renderers, with the idioms of those who wrote them: constants and functions within, names that
//! change, loops over arrays, guards against rounding. The battery checks each, and some against what the same renderer has for
//! a density.

use aether_core::prelude::*;
use aether_core::{DomainError, battery};

// pbrt-v4, `util/sampling.h`.

/// `SampleLinear`.
#[sampler(a in 1e-2..=1e2, b in 1e-2..=1e2)]
fn linear(u: [Uniform; 1], a: f64, b: f64) -> f64 {
    const ONE_MINUS_EPSILON: f64 = 1.0 - f64::EPSILON / 2.0;
    let lerp = |x: f64, a: f64, b: f64| (1.0 - x) * a + x * b;
    if u[0] == 0.0 && a == 0.0 {
        return 0.0;
    }
    let x = u[0] * (a + b) / (a + lerp(u[0], a * a, b * b).sqrt());
    x.min(ONE_MINUS_EPSILON)
}

/// `SampleTent`.
#[sampler(r in 1e-2..=1e2)]
fn tent(u: [Uniform; 1], r: f64) -> f64 {
    let mut u = u[0];
    let sign;
    if u < 0.5 {
        u = 2.0 * u;
        sign = -1.0;
    } else {
        u = 2.0 * (u - 0.5);
        sign = 1.0;
    }
    // `SampleLinear(u, 1, 0)`
    sign * r * (1.0 - (1.0 - u).sqrt())
}

/// `SampleExponential`.
#[sampler(a in 1e-2..=1e2)]
fn exponential(u: [Uniform; 1], a: f64) -> f64 {
    debug_assert!(a > 0.0, "rate {a}");
    -(1.0 - u[0]).ln() / a
}

/// `SampleTrimmedExponential`.
#[sampler(c in 1e-1..=1e1, x_max in 1e-1..=1e1)]
fn trimmed_exponential(u: [Uniform; 1], c: f64, x_max: f64) -> f64 {
    (1.0 - u[0] * (1.0 - (-c * x_max).exp())).ln() / -c
}

/// `SampleNormal`.
#[sampler(sigma in 1e-2..=1e2)]
fn normal(u: [Uniform; 1], mu: f64, sigma: f64) -> f64 {
    mu + SQRT_2 * sigma * erf_inv(2.0 * u[0] - 1.0)
}

/// `SampleTwoNormal`, by Box and Muller.
#[sampler(sigma in 1e-2..=1e2)]
fn two_normal(u: [Uniform; 2], mu: f64, sigma: f64) -> Vec2 {
    let r2 = -2.0 * (1.0 - u[0]).ln();
    let r = r2.sqrt();
    let (sin, cos) = (2.0 * PI * u[1]).sin_cos();
    Vec2::new(mu + sigma * (r * cos), mu + sigma * (r * sin))
}

/// `SampleLogistic`.
#[sampler(s in 1e-2..=1e2)]
fn logistic(u: [Uniform; 1], s: f64) -> f64 {
    -s * (1.0 / u[0] - 1.0).ln()
}

/// `SampleTrimmedLogistic`.
#[sampler(s in 0.2..=5.0, a in -4.0..=0.0, b in 0.5..=4.0)]
fn trimmed_logistic(u: [Uniform; 1], s: f64, a: f64, b: f64) -> f64 {
    let invert_logistic_sample = |x: f64, s: f64| 1.0 / (1.0 + (-x / s).exp());
    let p = |x: f64| invert_logistic_sample(x, s);
    let u = (1.0 - u[0]) * p(a) + u[0] * p(b);
    let x = -s * (1.0 / u - 1.0).ln();
    x.clamp(a, b)
}

/// `SampleSmoothStep`, whose root pbrt finds by bisection and Newton's method.
#[sampler(b in 0.5..=2.0)]
fn smooth_step(u: [Uniform; 1], b: f64) -> f64 {
    // pbrt's `SmoothStep` integrated, in units of its width.
    let cdf = |t: f64| 2.0 * (t.powi(3) - t.powi(4) / 2.0);
    b * solve(cdf, 0.0..1.0, u[0])
}

/// `SampleBilinear`.
#[sampler(a in 0.1..=4.0, b in 0.1..=4.0, c in 0.1..=4.0, d in 0.1..=4.0)]
fn bilinear(u: [Uniform; 2], a: f64, b: f64, c: f64, d: f64) -> Vec2 {
    let w = [a, b, c, d];
    fn sample_linear(u: f64, a: f64, b: f64) -> f64 {
        u * (a + b) / (a + ((1.0 - u) * a * a + u * b * b).sqrt())
    }
    let lerp = |x: f64, a: f64, b: f64| (1.0 - x) * a + x * b;
    let mut p = Vec2::ZERO;
    p.y = sample_linear(u[1], w[0] + w[1], w[2] + w[3]);
    p.x = sample_linear(u[0], lerp(p.y, w[0], w[2]), lerp(p.y, w[1], w[3]));
    p
}

/// `SampleCatmullRom` between two knots with values f0, f1 and no slope at either: the integral is a polynomial.
#[sampler(f0 in 0.5..=2.0, f1 in 0.5..=2.0)]
fn catmull_rom(u: [Uniform; 1], f0: f64, f1: f64) -> f64 {
    let (d0, d1) = (0.0, 0.0);
    let coefficients = [
        f0,
        0.5 * d0,
        (1.0 / 3.0) * (-2.0 * d0 - d1) + f1 - f0,
        0.25 * (d0 + d1) + 0.5 * (f0 - f1),
    ];
    let integral = |t: f64| {
        let mut sum = 0.0;
        for c in coefficients.iter().rev() {
            sum = t * (c + sum);
        }
        sum
    };
    let total = 0.5 * (f0 + f1);
    solve(|t| integral(t), 0.0..1.0, u[0] * total)
}

/// `SampleUniformDiskPolar`, and what is made of it: `SampleCosineHemisphere` of older editions.
#[sampler]
fn cosine_hemisphere(u: [Uniform; 2]) -> Direction {
    let uniform_disk_polar = |u: [f64; 2]| {
        let r = u[0].sqrt();
        let theta = 2.0 * PI * u[1];
        Vec2::new(r * theta.cos(), r * theta.sin())
    };
    let d = uniform_disk_polar(u);
    let z = (1.0 - d.x * d.x - d.y * d.y).max(0.0).sqrt();
    Direction::new(d.x, d.y, z)
}

/// `SampleUniformDiskConcentric`.
#[sampler]
fn concentric(u: [Uniform; 2]) -> Vec2 {
    const PI_OVER_4: f64 = PI / 4.0;
    const PI_OVER_2: f64 = PI / 2.0;
    let u_offset = 2.0 * Vec2::new(u[0], u[1]) - Vec2::splat(1.0);
    if u_offset.x == 0.0 && u_offset.y == 0.0 {
        return Vec2::ZERO;
    }
    let (theta, r);
    if u_offset.x.abs() > u_offset.y.abs() {
        r = u_offset.x;
        theta = PI_OVER_4 * (u_offset.y / u_offset.x);
    } else {
        r = u_offset.y;
        theta = PI_OVER_2 - PI_OVER_4 * (u_offset.x / u_offset.y);
    }
    r * Vec2::new(theta.cos(), theta.sin())
}

/// `SampleCosineHemisphere`, from a disk by Shirley and Chiu.
#[sampler]
fn malley(u: [Uniform; 2]) -> Direction {
    let offset = Vec2::new(2.0 * u[0] - 1.0, 2.0 * u[1] - 1.0);
    if offset == Vec2::ZERO {
        return Direction::new(0.0, 0.0, 1.0);
    }
    let (r, theta) = if offset.x.abs() > offset.y.abs() {
        (offset.x, PI / 4.0 * (offset.y / offset.x))
    } else {
        (offset.y, PI / 2.0 - PI / 4.0 * (offset.x / offset.y))
    };
    let d = Vec2::new(r * theta.cos(), r * theta.sin());
    Direction::new(d.x, d.y, (1.0 - d.x * d.x - d.y * d.y).max(0.0).sqrt())
}

/// `SampleUniformTriangle`, after Heitz.
#[sampler]
fn triangle(u: [Uniform; 2], p0: Vec3, p1: Vec3, p2: Vec3) -> Surface {
    let (b0, b1);
    if u[0] < u[1] {
        b0 = u[0] / 2.0;
        b1 = u[1] - b0;
    } else {
        b1 = u[1] / 2.0;
        b0 = u[0] - b1;
    }
    let b = [b0, b1, 1.0 - b0 - b1];
    let mut p = Vec3::ZERO;
    for (corner, weight) in [p0, p1, p2].into_iter().zip(b) {
        p += corner * weight;
    }
    Surface::from_vec(p)
}

/// `SampleUniformCone`.
#[sampler(cos_theta_max in -1.0..=0.99)]
fn cone(u: [Uniform; 2], cos_theta_max: f64) -> Direction {
    let cos_theta = (1.0 - u[0]) + u[0] * cos_theta_max;
    let sin_theta = (1.0 - cos_theta * cos_theta).max(0.0).sqrt();
    let phi = u[1] * 2.0 * PI;
    Direction::new(phi.cos() * sin_theta, phi.sin() * sin_theta, cos_theta)
}

/// `HenyeyGreenstein::Sample_p`, in the frame of the ray.
#[sampler(g in -0.95..=0.95)]
fn henyey_greenstein(u: [Uniform; 2], g: f64) -> Direction {
    let cos_theta = if g.abs() < 1e-3 {
        1.0 - 2.0 * u[0]
    } else {
        -1.0 / (2.0 * g) * (1.0 + g * g - ((1.0 - g * g) / (1.0 + g - 2.0 * g * u[0])).powi(2))
    };
    let sin_theta = (1.0 - cos_theta * cos_theta).max(0.0).sqrt();
    let (sin_phi, cos_phi) = (2.0 * PI * u[1]).sin_cos();
    Direction::new(sin_theta * cos_phi, sin_theta * sin_phi, cos_theta)
}

// Mitsuba 3, `warp.h`, and Nori.

/// `square_to_uniform_sphere`.
#[sampler]
fn sphere(u: [Uniform; 2]) -> Direction {
    let z = (-2.0f64).mul_add(u[1], 1.0);
    let r = (1.0 - z.powi(2)).max(0.0).sqrt();
    let (s, c) = (TAU * u[0]).sin_cos();
    Direction::new(r * c, r * s, z)
}

/// `square_to_beckmann`.
#[sampler(alpha in 0.05..=1.0)]
fn beckmann(u: [Uniform; 2], alpha: f64) -> Direction {
    let phi = u[1] * TAU;
    let tan_theta_m_sqr = -(alpha * alpha) * (1.0 - u[0]).ln();
    let cos_theta_m = 1.0 / (1.0 + tan_theta_m_sqr).sqrt();
    let sin_theta_m = (1.0 - cos_theta_m * cos_theta_m).max(0.0).sqrt();
    Direction::new(sin_theta_m * phi.cos(), sin_theta_m * phi.sin(), cos_theta_m)
}

/// `interval_to_tent`.
#[sampler]
fn mitsuba_tent(u: [Uniform; 1]) -> f64 {
    let mut sample = u[0] - 0.5;
    let abs_sample = sample.abs();
    sample = (1.0 - (1.0 - 2.0 * abs_sample).sqrt()).copysign(sample);
    sample
}

/// `square_to_uniform_square_concentric`, the disk of Dave Cline.
#[sampler]
fn cline(u: [Uniform; 2]) -> Vec2 {
    let x = 2.0 * u[0] - 1.0;
    let y = 2.0 * u[1] - 1.0;
    let quadrant_1_or_3 = x.abs() < y.abs();
    let r = if quadrant_1_or_3 { y } else { x };
    let rp = if quadrant_1_or_3 { x } else { y };
    let mut phi = 0.25 * PI * rp / r;
    if quadrant_1_or_3 {
        phi = 0.5 * PI - phi;
    }
    let (s, c) = phi.sin_cos();
    Vec2::new(r * c, r * s)
}

/// `squareToUniformTriangle` of Nori: barycentric coordinates, by folding.
#[sampler]
fn folded(mut u: [Uniform; 2]) -> Vec2 {
    if u[0] + u[1] > 1.0 {
        u[0] = 1.0 - u[0];
        u[1] = 1.0 - u[1];
    }
    let [a, b] = u;
    Vec2::new(a, b)
}

/// Shirley's tent filter in two dimensions.
#[sampler]
fn shirley_tent(u: [Uniform; 2]) -> Vec2 {
    fn axis(u: f64) -> f64 {
        let r = 2.0 * u;
        if r < 1.0 { r.sqrt() - 1.0 } else { 1.0 - (2.0 - r).sqrt() }
    }
    Vec2::from_array(u.map(axis))
}

/// Arvo's spherical triangle has its own place in the catalogue; this is Turk's planar one.
#[sampler]
fn turk(u: [Uniform; 2], v: Vec3, e1: Vec3, e2: Vec3) -> Surface {
    let t = 1.0 - (1.0 - u[0]).sqrt();
    let (beta, gamma) = ((1.0 - t) * u[1], t);
    let mut p = v;
    p += beta * e1;
    p += gamma * e2;
    Surface::from_vec(p)
}

// Discrete choices by a uniform that is used again.

/// A table of three bins.
#[sampler]
fn tabulated(u: [Uniform; 1]) -> f64 {
    const WEIGHTS: [f64; 3] = [0.2, 0.5, 0.3];
    let mut rest = u[0];
    let mut bin = WEIGHTS.len() - 1;
    for (i, &w) in WEIGHTS.iter().enumerate() {
        if rest < w {
            bin = i;
            break;
        }
        rest -= w;
    }
    let offset = rest / WEIGHTS[bin];
    (bin as f64 + offset) / WEIGHTS.len() as f64
}

/// A face of a cube, and a point of it.
#[sampler]
fn stratum(u: [Uniform; 2]) -> Vec2 {
    const N: usize = 4;
    let cell = ((u[0] * N as f64) as usize).min(N - 1);
    let inner = u[0] * N as f64 - cell as f64;
    Vec2::new((cell % 2) as f64 + inner, (cell / 2) as f64 + u[1])
}

/// Two lobes of a phase function, one of which is chosen.
#[sampler(w in 0.05..=0.95)]
fn two_lobes(u: [Uniform; 2], w: f64) -> Direction {
    let mut v = u[0];
    let g: f64;
    if v < w {
        v /= w;
        g = 0.7;
    } else {
        v = (v - w) / (1.0 - w);
        g = -0.3;
    }
    let sqr = |x: f64| x * x;
    let cos = (1.0 + g * g - sqr((1.0 - g * g) / (1.0 - g + 2.0 * g * v))) / (2.0 * g);
    let sin = (1.0 - cos * cos).max(0.0).sqrt();
    let phi = TAU * u[1];
    Direction::new(sin * phi.cos(), sin * phi.sin(), cos)
}

/// Whether the battery finds nothing wrong.
macro_rules! passes {
    ($($sampler:expr),* $(,)?) => {
        $(battery::check(&$sampler).assert_ok();)*
    };
}

#[test]
fn of_a_line() -> Result<(), DomainError> {
    passes!(linear(0.5, 3.0)?, linear(4.0, 0.1)?, tent(2.0)?, exponential(3.0)?);
    passes!(trimmed_exponential(2.0, 1.5)?, normal(1.0, 0.5)?, logistic(0.7)?);
    passes!(trimmed_logistic(0.5, -2.0, 1.0)?, smooth_step(1.5)?, catmull_rom(0.5, 2.0)?);
    passes!(mitsuba_tent(), tabulated());
    Ok(())
}

#[test]
fn of_the_plane() -> Result<(), DomainError> {
    passes!(two_normal(0.5, 2.0)?, bilinear(0.5, 1.0, 3.0, 2.0)?, concentric(), cline());
    passes!(folded(), shirley_tent(), stratum());
    Ok(())
}

#[test]
fn of_directions_and_surfaces() -> Result<(), DomainError> {
    passes!(cosine_hemisphere(), cone(0.3)?, henyey_greenstein(0.6)?, sphere(), beckmann(0.4)?);
    passes!(two_lobes(0.3)?, malley());
    assert_eq!(malley().sample([0.5f64, 0.5]).value(), Direction::new(0.0, 0.0, 1.0));
    assert_eq!(concentric().sample([0.5f64, 0.5]).value(), Vec2::ZERO);
    let corner = Vec3::new(0.5, -1.0, 2.0);
    passes!(triangle(corner, 2.0 * Vec3::X, Vec3::Y), turk(corner, 2.0 * Vec3::X, Vec3::Y));
    Ok(())
}

/// The densities that the same places state.
#[test]
fn densities_are_those_of_the_same_renderers() -> Result<(), DomainError> {
    let close = |found: f64, expected: f64| {
        assert!((found / expected - 1.0).abs() < 1e-12, "{found} for {expected}");
    };
    // `LinearPDF`
    close(linear(0.5, 3.0)?.pdf(&0.25).value(), 2.0 * (0.75 * 0.5 + 0.25 * 3.0) / 3.5);
    // `TentPDF`
    close(tent(2.0)?.pdf(&-0.5).value(), 0.5 - 0.5 / 4.0);
    // `TrimmedExponentialPDF`
    let scale = 2.0 / (1.0 - (-3.0f64).exp());
    close(trimmed_exponential(2.0, 1.5)?.pdf(&0.4).value(), scale * (-0.8f64).exp());
    // `TrimmedLogisticPDF`
    let logistic = |x: f64| (-x / 0.5).exp() / (0.5 * (1.0 + (-x / 0.5f64).exp()).powi(2));
    let cdf = |x: f64| 1.0 / (1.0 + (-x / 0.5f64).exp());
    let expected = logistic(0.3) / (cdf(1.0) - cdf(-2.0));
    close(trimmed_logistic(0.5, -2.0, 1.0)?.pdf(&0.3).value(), expected);
    // `SmoothStepPDF`
    let t = 0.6 / 1.5;
    close(smooth_step(1.5)?.pdf(&0.6).value(), 2.0 / 1.5 * (3.0 * t * t - 2.0 * t * t * t));
    // `BilinearPDF`
    let (x, y) = (0.3, 0.8);
    let value = 0.5 * (1.0 - x) * (1.0 - y) + x * (1.0 - y) + 3.0 * (1.0 - x) * y + 2.0 * x * y;
    close(bilinear(0.5, 1.0, 3.0, 2.0)?.pdf(&Vec2::new(x, y)).value(), 4.0 * value / 6.5);
    // `HenyeyGreenstein`, whose direction is turned round
    let phase =
        |g: f64, cos: f64| (1.0 - g * g) / (2.0 * TAU * (1.0 + g * g - 2.0 * g * cos).powf(1.5));
    let w = Direction::from_vec(Vec3::new(0.3, 0.4, 0.5).normalize());
    close(henyey_greenstein(0.6)?.pdf(&w).value(), phase(-0.6, w.z));
    close(two_lobes(0.3)?.pdf(&w).value(), 0.3 * phase(0.7, w.z) + 0.7 * phase(-0.3, w.z));
    // A table of three bins
    close(tabulated().pdf(&0.5).value(), 1.5);
    close(tabulated().pdf(&0.9).value(), 0.9);
    Ok(())
}
