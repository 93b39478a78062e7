//! The plane.

use aether_core::{Real, Vec2};
use core::f64::consts::{FRAC_1_PI, PI, TAU};

use super::logistic;
use crate::registry::Which;

/// The density of a sampler of the plane.
pub fn density<R: Real>(which: Which, p: &[R], x: &[R]) -> Option<R> {
    uniform(which, p, x).or_else(|| mapped(which, p, x)).or_else(|| variables(which, p, x))
}

/// One over an area.
fn uniform<R: Real>(which: Which, p: &[R], x: &[R]) -> Option<R> {
    let c = R::of;
    let density = match which {
        Which::PolarDisk | Which::Lens => (c(PI) * p[0] * p[0]).recip(),
        Which::ConcentricDisk => c(FRAC_1_PI),
        Which::AnnularSector => c(2.0) / (p[3] * (p[1] * p[1] - p[0] * p[0])),
        Which::Pentagon => c(2.0) / (c(5.0) * c(TAU / 5.0).sin()),
        Which::RegularPolygon => c(2.0) / (p[0] * (c(TAU) / p[0]).sin()),
        Which::BilinearQuad => bilinear_quad(p, x),
        _ => return None,
    };
    Some(density)
}

/// One over the Jacobian of the bilinear map, the root of the discriminant of the quadratic equation for the point.
fn bilinear_quad<R: Real>(p: &[R], x: &[R]) -> R {
    let corner = |k: usize| Vec2::new(p[2 * k], p[2 * k + 1]);
    let cross = |a: Vec2<R>, b: Vec2<R>| a.x * b.y - a.y * b.x;
    let (e, f) = (corner(1) - corner(0), corner(3) - corner(0));
    let g = corner(0) - corner(1) + corner(2) - corner(3);
    let h = Vec2::new(x[0], x[1]) - corner(0);
    let (k2, k1, k0) = (cross(g, f), cross(e, f) + cross(h, g), cross(h, e));
    (k1 * k1 - R::of(4.0) * k0 * k2).sqrt().recip()
}

/// Maps of squares and disks.
fn mapped<R: Real>(which: Which, p: &[R], x: &[R]) -> Option<R> {
    let c = R::of;
    let one = R::ONE;
    let density = match which {
        // Fong, "Analytical Methods for Squaring the Disc" (2015).
        Which::EllipticalGrid => {
            let half = c(0.5);
            let side = |x: R, y: R| {
                let (sum, step) = (c(2.0) + x * x - y * y, c(8.0).sqrt() * x);
                half * ((sum + step).sqrt() - (sum - step).sqrt())
            };
            let (a, b) = (side(x[0], x[1]), side(x[1], x[0]));
            let (a2, b2) = (half * a * a, half * b * b);
            ((one - a2) * (one - b2)).sqrt() / (c(4.0) * (one - a2 - b2))
        }
        Which::BilinearDensity => {
            let (s, t) = (x[0], x[1]);
            let below = (one - s) * p[0] + s * p[1];
            let above = (one - s) * p[2] + s * p[3];
            c(4.0) * ((one - t) * below + t * above) / (p[0] + p[1] + p[2] + p[3])
        }
        Which::ComplexSquare | Which::ComplexSquareXy => (c(TAU) * x[0].hypot(x[1])).recip(),
        _ => return None,
    };
    Some(density)
}

/// Pairs of random variables.
fn variables<R: Real>(which: Which, p: &[R], x: &[R]) -> Option<R> {
    let c = R::of;
    let one = R::ONE;
    let normal = |square: R| (-square * c(0.5)).exp() / c(TAU);
    let density = match which {
        Which::BivariateNormal => {
            let z1 = x[0] / p[0];
            let z2 = (x[1] - p[1] * z1) / p[2];
            normal(z1 * z1 + z2 * z2) / (p[0] * p[2])
        }
        Which::GgxSlopes => {
            let a2 = p[0] * p[0];
            let s = one + (x[0] * x[0] + x[1] * x[1]) / a2;
            (c(PI) * a2 * s * s).recip()
        }
        Which::AffineLogistics => {
            let determinant = p[0] * p[3] - p[1] * p[2];
            let (s, t) = (x[0] - p[4], x[1] - p[5]);
            let first = (p[3] * s - p[1] * t) / determinant;
            let second = (p[0] * t - p[2] * s) / determinant;
            logistic(first) * logistic(second) / determinant.abs()
        }
        // Rezende and Mohamed, "Variational Inference with Normalizing Flows" (2015).
        Which::RadialFlow => {
            let (alpha, beta) = (p[0], p[1]);
            let length = x[0].hypot(x[1]);
            let a = alpha + beta - length;
            let r = ((a * a + c(4.0) * alpha * length).sqrt() - a) * c(0.5);
            let h = (alpha + r).recip();
            normal(r * r) / ((one + beta * h) * (one + beta * h - beta * h * h * r))
        }
        Which::AffineCoupling => {
            let scale = (p[0] * x[0].tanh()).exp();
            logistic(x[0]) * logistic((x[1] - p[1] * x[0] * x[0]) / scale) / scale
        }
        _ => return None,
    };
    Some(density)
}
