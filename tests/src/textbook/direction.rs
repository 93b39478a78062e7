//! Directions.

use aether_core::{Real, Vec3};
use core::f64::consts::{FRAC_1_PI, PI, TAU};

use super::{henyey_greenstein, vector};
use crate::registry::Which;

/// The density of a sampler of directions that are no microfacets'.
pub fn density<R: Real>(which: Which, p: &[R], x: &[R]) -> Option<R> {
    uniform(which, p).or_else(|| lobe(which, p, x)).or_else(|| seen(which, p, x))
}

/// One over a solid angle.
fn uniform<R: Real>(which: Which, p: &[R]) -> Option<R> {
    let c = R::of;
    let density = match which {
        Which::UniformSphere | Which::EqualAreaOctahedral | Which::Sky => c(0.25 * FRAC_1_PI),
        Which::UniformHemisphere | Which::ConcentricHemisphere => c(0.5 * FRAC_1_PI),
        Which::Cone | Which::LightCone => (c(TAU) * p[0]).recip(),
        Which::ZonalWindow => ((p[1] - p[0]) * p[3]).recip(),
        Which::DoubleLune => (c(8.0) * p[0]).recip(),
        // The last parameter is half of the solid angle.
        Which::TriangleByDirection => (c(2.0) * p[2]).recip(),
        Which::RectangleByDirection => (c(2.0) * p[3]).recip(),
        Which::SeenTriangle => excess([0, 3, 6].map(|i| vector(p, i))).recip(),
        Which::SeenRectangle => {
            let [x0, y0, x1, y1, z] = [p[0], p[1], p[2], p[3], p[4]];
            excess([(x0, y0), (x1, y0), (x1, y1), (x0, y1)].map(|(x, y)| Vec3::new(x, y, z)))
                .recip()
        }
        _ => return None,
    };
    Some(density)
}

/// The solid angle of a polygon seen from the origin, by Girard's theorem: what its angles add up to beyond those of a
/// plane polygon, as Arvo ("Stratified Sampling of Spherical Triangles", 1995) and Ureña, Fajardo and King ("An
/// Area-Preserving Parametrization for Spherical Rectangles", 2013) compute it.
fn excess<R: Real, const N: usize>(corners: [Vec3<R>; N]) -> R {
    let side = |i: usize| corners[i % N].cross(corners[(i + 1) % N]).normalize();
    let angles = (0..N).map(|i| (-side(i).dot(side(i + 1))).acos());
    let half_turn = (-R::ONE).acos();
    angles.fold(-half_turn * R::of(N as f64 - 2.0), |sum, angle| sum + angle)
}

/// Lobes about an axis, and phase functions.
fn lobe<R: Real>(which: Which, p: &[R], x: &[R]) -> Option<R> {
    let c = R::of;
    let one = R::ONE;
    let z = x[2];
    let density = match which {
        Which::CosineHemisphere | Which::DiffuseLobe => z * c(FRAC_1_PI),
        Which::PowerCosine | Which::GlossyLobe => power(p[0], z),
        Which::Mixture => p[0] * power(p[1], z) + (one - p[0]) * z * c(FRAC_1_PI),
        Which::VonMisesFisher | Which::VonMisesFisherAsPrinted => {
            p[0] * (p[0] * (z - one)).exp() / (c(TAU) * (one - (c(-2.0) * p[0]).exp()))
        }
        Which::HenyeyGreenstein | Which::HenyeyGreensteinAsPrinted => henyey_greenstein(p[0], z),
        Which::Rayleigh => c(3.0 / (16.0 * PI)) * (one + z * z),
        // Estevez and Kulla, "Production Friendly Microfacet Sheen BRDF" (2017).
        Which::Sheen => {
            let sine = (one - z * z).sqrt();
            (c(2.0) + p[0].recip()) * sine.powf(p[0].recip()) * z / c(TAU)
        }
        // Heitz, Dupuy, Hill and Neubelt, "Real-Time Polygonal-Light Shading with Linearly Transformed Cosines" (2016).
        Which::TransformedCosine => {
            let [a, b, e] = [0, 3, 6].map(|first| vector(p, first));
            let w = vector(x, 0);
            let determinant = a.dot(b.cross(e));
            let [x, y, z] =
                [b.cross(e), e.cross(a), a.cross(b)].map(|row| row.dot(w) / determinant);
            let length = (x * x + y * y + z * z).sqrt();
            z / length * c(FRAC_1_PI) / (determinant.abs() * length * length * length)
        }
        _ => return None,
    };
    Some(density)
}

/// A power of the cosine.
fn power<R: Real>(n: R, cosine: R) -> R {
    (n + R::ONE) / R::of(TAU) * cosine.powf(n)
}

/// Maps of angles, and of a plane at distance one.
fn seen<R: Real>(which: Which, p: &[R], x: &[R]) -> Option<R> {
    let c = R::of;
    let z = x[2];
    let cube = z * z * z;
    let density = match which {
        Which::Equirectangular => (c(2.0 * PI * PI) * (R::ONE - z * z).sqrt()).recip(),
        Which::SmallAngles | Which::ConeNear => {
            let theta = z.acos();
            (c(TAU) * (p[1] / p[0]).ln() * theta * theta.sin()).recip()
        }
        Which::Perspective => (c(4.0) * p[0] * p[0] * p[1] * cube).recip(),
        Which::SquareOfDirections => (c(4.0) * p[0] * p[0] * cube).recip(),
        // A triangle's area density times squared distance over cosine.
        Which::Window => {
            let normal = vector(p, 3).cross(vector(p, 6));
            let cosine = normal.dot(vector(x, 0)) / normal.length();
            let distance = normal.dot(vector(p, 0)) / normal.dot(vector(x, 0));
            c(2.0) / normal.length() * distance * distance / cosine.abs()
        }
        _ => return None,
    };
    Some(density)
}
