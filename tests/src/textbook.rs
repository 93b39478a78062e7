//! Densities as textbooks and renderers write them, for comparison: no care for the last digits, and no
//! test of the support.

use aether_core::Real;
use core::f64::consts::{FRAC_1_PI, PI, TAU};

use crate::registry::Which;

/// The density of a sampler with the parameters `p` at the coordinates `x`, if there is a usual form.
pub fn textbook<R: Real>(which: Which, p: &[R], x: &[R]) -> Option<R> {
    let c = R::of;
    let one = R::ONE;
    let density = match which {
        Which::Affine => (p[1] - p[0]).recip(),
        Which::Power => p[0] * x[0].powf(p[0] - one),
        Which::Exponential => p[0] * (-p[0] * x[0]).exp(),
        Which::TruncatedExponential => p[0] * (-p[0] * x[0]).exp() / (one - (-p[0] * p[1]).exp()),
        Which::Linear => c(2.0) * (p[0] + (p[1] - p[0]) * x[0]) / (p[0] + p[1]),
        Which::Tent => (one - x[0].abs() / p[0]) / p[0],
        Which::Laplace => (-x[0].abs() / p[0]).exp() / (c(2.0) * p[0]),
        Which::Student2 => (c(2.0) + x[0] * x[0]).powf(c(-1.5)),
        Which::Weibull => {
            let t = x[0] / p[0];
            p[1] / p[0] * t.powf(p[1] - one) * (-t.powf(p[1])).exp()
        }
        Which::Gumbel => {
            let z = (x[0] - p[0]) / p[1];
            (-(z + (-z).exp())).exp() / p[1]
        }
        Which::SoftplusLogistic => (-x[0]).exp(),
        Which::PolarDisk => (c(PI) * p[0] * p[0]).recip(),
        Which::ConcentricDisk => c(FRAC_1_PI),
        Which::UniformSphere => c(0.25 * FRAC_1_PI),
        Which::UniformHemisphere | Which::ConcentricHemisphere => c(0.5 * FRAC_1_PI),
        Which::CosineHemisphere | Which::DiffuseLobe => x[2] * c(FRAC_1_PI),
        Which::Equirectangular => (c(2.0 * PI * PI) * (one - x[2] * x[2]).sqrt()).recip(),
        Which::PowerCosine => (p[0] + one) / c(TAU) * x[2].powf(p[0]),
        Which::SphereSurface => (c(4.0 * PI) * p[3] * p[3]).recip(),
        Which::Cone => (c(TAU) * p[0]).recip(),
        Which::VonMisesFisher | Which::VonMisesFisherAsPrinted => {
            p[0] * (p[0] * (x[2] - one)).exp() / (c(TAU) * (one - (c(-2.0) * p[0]).exp()))
        }
        Which::HenyeyGreenstein | Which::HenyeyGreensteinAsPrinted => {
            let g = p[0];
            let d = one + g * g - c(2.0) * g * x[2];
            (one - g * g) / (c(4.0 * PI) * d * d.sqrt())
        }
        Which::Rayleigh => c(3.0 / (16.0 * PI)) * (one + x[2] * x[2]),
        Which::Beckmann => {
            let (c2, a2) = (x[2] * x[2], p[0] * p[0]);
            let t2 = (one - c2) / c2;
            (-t2 / a2).exp() / (c(PI) * a2 * c2 * x[2])
        }
        Which::Ggx => {
            let a2 = p[0] * p[0];
            let d = x[2] * x[2] * (a2 - one) + one;
            a2 * x[2] / (c(PI) * d * d)
        }
        Which::AnisotropicGgx => {
            let (a, b) = (x[0] / p[0], x[1] / p[1]);
            let d = a * a + b * b + x[2] * x[2];
            x[2] / (c(PI) * p[0] * p[1] * d * d)
        }
        Which::Sheen => {
            let sine = (one - x[2] * x[2]).sqrt();
            (c(2.0) + p[0].recip()) * sine.powf(p[0].recip()) * x[2] / c(TAU)
        }
        Which::Triangle | Which::TriangleHeitz | Which::TriangleFold | Which::TriangleLight => {
            let edge = |k: usize| [0, 1, 2].map(|i| p[3 * k + i] - p[i]);
            let ([a, b, d], [e, f, g]) = (edge(1), edge(2));
            let n = [b * g - d * f, d * e - a * g, a * f - b * e];
            c(2.0) / (n[0] * n[0] + n[1] * n[1] + n[2] * n[2]).sqrt()
        }
        _ => return None,
    };
    Some(density)
}
