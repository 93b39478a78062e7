//! The line.

use aether_core::Real;
use aether_core::special::{lambert_w, ln_gamma, normal_cdf};
use core::f64::consts::{PI, TAU};

use super::{logistic, truncated_exponential};
use crate::registry::Which;

/// The density of a sampler of the line.
pub fn density<R: Real>(which: Which, p: &[R], x: R) -> Option<R> {
    distribution(which, p, x)
        .or_else(|| heavy_tailed(which, p, x))
        .or_else(|| flight(which, p, x))
        .or_else(|| several_to_one(which, p, x))
}

/// Distributions of statistics.
fn distribution<R: Real>(which: Which, p: &[R], x: R) -> Option<R> {
    let c = R::of;
    let one = R::ONE;
    let density = match which {
        Which::Affine => (p[1] - p[0]).abs().recip(),
        Which::Power => p[0] * x.powf(p[0] - one),
        Which::Linear => c(2.0) * (p[0] + (p[1] - p[0]) * x) / (p[0] + p[1]),
        Which::Tent => (one - x.abs() / p[0]) / p[0],
        Which::Triangular => {
            let [a, b, e] = [p[0], p[1], p[2]];
            let rising = c(2.0) * (x - a) / ((e - a) * (b - a));
            let falling = c(2.0) * (e - x) / ((e - a) * (e - b));
            R::select(x.lt(b), rising, falling)
        }
        Which::Epanechnikov => c(0.75) * (one - x * x),
        Which::Logistic => logistic(x / p[0]) / p[0],
        Which::TruncatedLogistic | Which::TruncatedLogisticAsPrinted => {
            let below = |x: R| (one + (-x / p[0]).exp()).recip();
            logistic(x / p[0]) / (p[0] * (below(p[2]) - below(p[1])))
        }
        Which::Laplace => (-x.abs() / p[0]).exp() / (c(2.0) * p[0]),
        Which::Weibull => {
            let t = x / p[0];
            p[1] / p[0] * t.powf(p[1] - one) * (-t.powf(p[1])).exp()
        }
        Which::Gumbel => {
            let z = (x - p[0]) / p[1];
            (-(z + (-z).exp())).exp() / p[1]
        }
        Which::Kumaraswamy => {
            let [a, b] = [p[0], p[1]];
            a * b * x.powf(a - one) * (one - x.powf(a)).powf(b - one)
        }
        Which::Normal => bell((x - p[0]) / p[1]) / p[1],
        Which::LowerNormal | Which::UpperNormal => {
            bell(x) / (normal_cdf(p[1]) - normal_cdf(p[0])).abs()
        }
        Which::Smoothstep => {
            let width = p[1] - p[0];
            let t = (x - p[0]) / width;
            t * t * (c(6.0) - c(4.0) * t) / width.abs()
        }
        Which::RationalQuadratic => spline_segment(p[0], p[1], p[2], x),
        _ => return None,
    };
    Some(density)
}

/// The density of the standard normal distribution.
fn bell<R: Real>(z: R) -> R {
    (-R::of(0.5) * z * z).exp() / R::of(TAU.sqrt())
}

/// A segment of width one (Durkan, Bekasov, Murray and Papamakarios, "Neural Spline Flows", 2019): the inverse by
/// the conjugate root, and one over the derivative there.
fn spline_segment<R: Real>(s: R, d0: R, d1: R, y: R) -> R {
    let two = R::of(2.0);
    let bend = d1 + d0 - two * s;
    let a = s * (s - d0) + y * bend;
    let b = s * d0 - y * bend;
    let c = -s * y;
    let t = two * c / (-b - (b * b - R::of(4.0) * a * c).sqrt());
    let q = R::ONE - t;
    let below = s + bend * t * q;
    below * below / (s * s * (d1 * t * t + two * s * t * q + d0 * q * q))
}

/// Distributions with heavy tails.
fn heavy_tailed<R: Real>(which: Which, p: &[R], x: R) -> Option<R> {
    let c = R::of;
    let one = R::ONE;
    let half = c(0.5);
    let density = match which {
        Which::Cauchy | Which::CauchyByTangent => p[0] / (c(PI) * (p[0] * p[0] + x * x)),
        Which::Student2 => (c(2.0) + x * x).powf(c(-1.5)),
        Which::Student => {
            let nu = p[0];
            let more = half * (nu + one);
            let scale = (ln_gamma(more) - ln_gamma(half * nu)).exp() / (nu * c(PI)).sqrt();
            scale * (one + x * x / nu).powf(-more)
        }
        Which::Pareto => {
            let z = (x - p[0]) / p[1];
            (one + p[2] * z).powf(-one / p[2] - one) / p[1]
        }
        Which::PowerLaw => {
            let k = one - p[2];
            k * x.powf(-p[2]) / (p[1].powf(k) - p[0].powf(k))
        }
        // Jones and Pewsey, "Sinh-arcsinh distributions" (2009).
        Which::SinhArcsinh => {
            let t = x.asinh() / p[1] - p[0];
            logistic(t.sinh()) * t.cosh() / (p[1] * (one + x * x).sqrt())
        }
        // Goerg, "The Lambert Way to Gaussianize heavy-tailed data" (2015).
        Which::HeavyTails => {
            let w = lambert_w(p[0] * x * x);
            let z = (w / p[0]).sqrt().copysign(x);
            logistic(z) * z / (x * (one + w))
        }
        _ => return None,
    };
    Some(density)
}

/// Distances along rays, and wavelengths.
fn flight<R: Real>(which: Which, p: &[R], x: R) -> Option<R> {
    let c = R::of;
    let density = match which {
        Which::Exponential => p[0] * (-p[0] * x).exp(),
        Which::TruncatedExponential => truncated_exponential(p[0], p[1], x),
        Which::SoftplusLogistic => (-x).exp(),
        // Kulla and Fajardo, "Importance Sampling Techniques for Path Tracing in Participating Media" (2012).
        Which::Equiangular | Which::EquiangularAsPrinted => {
            let d = p[0];
            let angle = (p[2] / d).atan() - (p[1] / d).atan();
            d / (angle * (d * d + x * x))
        }
        // With the digits of Pharr, Jakob and Humphreys, "Physically Based Rendering".
        Which::Wavelength => c(0.0039398042) / (c(0.0072) * (x - c(538.0))).cosh().powi(2),
        Which::LinearExtinction => {
            let depth = p[0] * x + p[1] * x * x * c(0.5);
            (p[0] + p[1] * x) * (-depth).exp()
        }
        Which::FallingExtinction => {
            let left = (-p[1] * x).exp();
            p[0] * left * (-p[0] / p[1] * (R::ONE - left)).exp()
        }
        // Of two media, one of which is chosen.
        Which::Hyperexponential => {
            let [q, l, m] = [p[0], p[1], p[2]];
            q * l * (-l * x).exp() + (R::ONE - q) * m * (-m * x).exp()
        }
        Which::Kepler => (R::ONE - p[0] * x.cos()) / c(TAU),
        _ => return None,
    };
    Some(density)
}

/// Folded maps: sums over the preimages.
fn several_to_one<R: Real>(which: Which, p: &[R], x: R) -> Option<R> {
    let c = R::of;
    let one = R::ONE;
    let density = match which {
        Which::Cosine | Which::Arcsine => (c(PI) * (one - x * x).sqrt()).recip(),
        Which::Parabola => (c(2.0) * (one - x).sqrt()).recip(),
        Which::Square => (c(2.0) * x.sqrt()).recip(),
        Which::Fold => one,
        // As many teeth as are higher.
        Which::Sawtooth => -(x - p[0]).floor() / p[0],
        // Three real roots by Viète's cosines.
        Which::Cubic => {
            let angle = (c(32.0) * x - one).acos();
            let slope = |turn: f64| {
                let u = c(0.5) + c(0.5) * ((angle + c(turn * TAU)) / c(3.0)).cos();
                (c(3.0) * u * u - c(3.0) * u + c(0.5625)).abs()
            };
            slope(0.0).recip() + slope(1.0).recip() + slope(2.0).recip()
        }
        _ => return None,
    };
    Some(density)
}
