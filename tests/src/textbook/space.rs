//! Volumes, manifolds in more dimensions, and points sampled jointly.

use aether_core::{Real, Vec3};
use core::f64::consts::{FRAC_1_PI, PI};

use super::{henyey_greenstein, logistic, truncated_exponential, vector};
use crate::registry::Which;

/// The density of a sampler of three numbers or more.
pub fn density<R: Real>(which: Which, p: &[R], x: &[R]) -> Option<R> {
    let c = R::of;
    let one = R::ONE;
    let density = match which {
        Which::Shell => c(3.0 / (4.0 * PI)) / (p[1] * p[1] * p[1] - p[0] * p[0] * p[0]),
        Which::Tetrahedron => {
            let side = |k: usize| vector(p, 3 * k) - vector(p, 0);
            c(6.0) / side(1).dot(side(2).cross(side(3))).abs()
        }
        // The density of the distance, that of the direction, and r² for the element of volume.
        Which::ScatteringVertex => {
            let ray = vector(x, 0) - vector(p, 0);
            let t = ray.length();
            truncated_exponential(p[3], p[4], t) * henyey_greenstein(p[5], ray.z / t) / (t * t)
        }
        Which::Quaternion => c(0.5 * FRAC_1_PI * FRAC_1_PI),
        Which::ChainedFrames => x[2] * vector(x, 0).dot(vector(x, 3)) * c(FRAC_1_PI) * c(FRAC_1_PI),
        Which::ScatteredTwice => {
            let cosine = vector(x, 0).dot(vector(x, 3));
            let lobe = (p[1] + one) * c(0.5 * FRAC_1_PI) * cosine.powf(p[1]);
            henyey_greenstein(p[0], x[2]) * lobe
        }
        // Uniform on the lens, and on a rectangle at a distance.
        Which::ThinLens => {
            let cosine = x[4];
            let focus = p[1] * p[1] / (c(4.0) * (p[2] * p[3]).abs() * cosine * cosine * cosine);
            focus * c(FRAC_1_PI) / (p[0] * p[0])
        }
        // Uniform in the opening, and the geometry term of the two ends.
        Which::PortalSegment => {
            let edge = vector(x, 0) - vector(x, 3);
            let cosine = edge.z / edge.length();
            c(2.0 * FRAC_1_PI) * cosine * cosine / (p[0] * p[0] * edge.dot(edge))
        }
        // The same with a cosine at each end, and one at the opening.
        Which::TiltedPortal => {
            let edge = vector(x, 0) - vector(x, 3);
            let cosine = |n: Vec3<R>| (n.dot(edge) / (n.length() * edge.length())).abs();
            let both = cosine(vector(p, 4)) * cosine(vector(p, 10));
            c(FRAC_1_PI) * both / (p[0] * p[0] * edge.length() * edge.z)
        }
        Which::Ordered => {
            let (y, z) = ((x[1] - x[0]).ln(), (x[2] - x[1]).ln());
            logistic(x[0]) * logistic(y) * logistic(z) * (-y - z).exp()
        }
        Which::StickBreaking => stick_breaking(x),
        // The columns of the factor, over the volume of the cube that they come from.
        Which::CorrelationFactor => x[1] * x[4] / (c(8.0) * (one - x[2] * x[2]).sqrt()),
        _ => return None,
    };
    Some(density)
}

/// The transform of Stan's reference manual, "Unit simplex", of logistic variables; per volume of the simplex, which
/// is twice that of its projection.
fn stick_breaking<R: Real>(x: &[R]) -> R {
    let mut rest = R::ONE;
    let mut density = R::of(0.5);
    for (part, others) in x.iter().zip([3.0, 2.0, 1.0]) {
        let z = *part / rest;
        let variable = (z / (R::ONE - z)).ln() + R::of(others).ln();
        density = density * logistic(variable) / (rest * z * (R::ONE - z));
        rest -= *part;
    }
    density
}
