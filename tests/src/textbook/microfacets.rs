//! Microfacets: normals, and what they reflect and refract (Walter, Marschner, Li and Torrance, "Microfacet Models
//! for Refraction through Rough Surfaces", 2007; Heitz, "Sampling the GGX Distribution of Visible Normals", 2018).

use aether_core::special::erf;
use aether_core::{Real, Vec3};
use core::f64::consts::{PI, TAU};

use super::vector;
use crate::registry::Which;

/// The density of a sampler of normals or of scattered directions.
pub fn density<R: Real>(which: Which, p: &[R], x: &[R]) -> Option<R> {
    normals(which, p, x)
        .or_else(|| in_catalogue(which, p, x))
        .or_else(|| reflected(which, p, x))
        .or_else(|| refracted(which, p, x))
}

/// Normals.
fn normals<R: Real>(which: Which, p: &[R], x: &[R]) -> Option<R> {
    let c = R::of;
    let one = R::ONE;
    let h = || vector(x, 0);
    let density = match which {
        Which::Beckmann => beckmann(h(), p[0]) * x[2],
        Which::Ggx => ggx(h(), p[0]) * x[2],
        Which::AnisotropicGgx => anisotropic_ggx(h(), [p[0], p[1]]) * x[2],
        // Ashikhmin and Shirley, "An Anisotropic Phong BRDF Model" (2000).
        Which::AshikhminShirley => {
            let z = x[2];
            let exponent = (p[0] * x[0] * x[0] + p[1] * x[1] * x[1]) / (one - z * z);
            ((p[0] + one) * (p[1] + one)).sqrt() / c(TAU) * z.powf(exponent)
        }
        Which::VisibleNormals | Which::VisibleNormalsAsPrinted | Which::HeitzNormals => {
            visible_ggx(vector(p, 1), h(), [p[0]; 2])
        }
        Which::BrushedNormals | Which::BrushedNormalsAsPrinted => {
            visible_ggx(vector(p, 2), h(), [p[0], p[1]])
        }
        _ => return None,
    };
    Some(density)
}

/// The density of a sampler of their slopes.
pub fn slopes<R: Real>(which: Which, p: &[R], x: &[R]) -> Option<R> {
    (which == Which::VisibleBeckmannSlopes).then(|| visible_slopes(x[0], x[1], p[0]))
}

/// What a viewer reflects and refracts at normals of GGX.
fn in_catalogue<R: Real>(which: Which, p: &[R], x: &[R]) -> Option<R> {
    let x = vector(x, 0);
    let density = match which {
        Which::ReflectedGgx => {
            let w = vector(p, 1);
            let h = half_vector(w, x);
            ggx(h, p[0]) * h.z / (R::of(4.0) * w.dot(h).abs())
        }
        Which::RefractedGgx => {
            let (w, eta) = (vector(p, 2), p[1]);
            let h = half_vector(w, x * eta);
            ggx(h, p[0]) * h.z * refraction(w, R::ONE, x, eta, h)
        }
        _ => return None,
    };
    Some(density)
}

/// Rough conductors of the renderer.
fn reflected<R: Real>(which: Which, p: &[R], x: &[R]) -> Option<R> {
    let w = match which {
        Which::VisibleGgx | Which::Beckmanns | Which::VisibleBeckmann => view(p[1]),
        Which::AnisotropicNormals | Which::AnisotropicVisible => view(p[2]),
        _ => return None,
    };
    let h = half_vector(w, vector(x, 0));
    let normals = match which {
        Which::VisibleGgx => visible_ggx(w, h, [p[0]; 2]),
        Which::Beckmanns => beckmann(h, p[0]) * h.z,
        // The slopes that are seen, from an angle of their own.
        Which::VisibleBeckmann => {
            let (alpha, cube) = (p[0], h.z * h.z * h.z);
            let slopes = visible_slopes(h.x / (h.z * alpha), h.y / (h.z * alpha), p[2]);
            slopes / (alpha * alpha * cube)
        }
        Which::AnisotropicNormals => anisotropic_ggx(h, [p[0], p[1]]) * h.z,
        _ => visible_ggx(w, h, [p[0], p[1]]),
    };
    Some(normals / (R::of(4.0) * w.dot(h)))
}

/// Rough dielectrics of the renderer.
fn refracted<R: Real>(which: Which, p: &[R], x: &[R]) -> Option<R> {
    let (alphas, w, r) = match which {
        Which::RoughRefraction | Which::RoughNearOne => ([p[0]; 2], view(p[1]), p[2]),
        Which::RoughEscape => ([p[0], p[1]], view(p[2]), p[3]),
        _ => return None,
    };
    let x = vector(x, 0);
    let h = half_vector(w * r, x);
    Some(visible_ggx(w, h, alphas) * refraction(w, r, x, R::ONE, h))
}

/// A viewer above the surface, at this height.
fn view<R: Real>(z: R) -> Vec3<R> {
    Vec3::new((R::ONE - z * z).sqrt(), R::ZERO, z)
}

/// The upper normal along the sum of two vectors.
fn half_vector<R: Real>(w: Vec3<R>, x: Vec3<R>) -> Vec3<R> {
    let h = (w + x).normalize();
    h * R::ONE.copysign(h.z)
}

/// Beckmann's distribution of normals.
fn beckmann<R: Real>(h: Vec3<R>, alpha: R) -> R {
    let (c2, a2) = (h.z * h.z, alpha * alpha);
    let t2 = (R::ONE - c2) / c2;
    (-t2 / a2).exp() / (R::of(PI) * a2 * c2 * c2)
}

/// The distribution GGX of normals.
fn ggx<R: Real>(h: Vec3<R>, alpha: R) -> R {
    let a2 = alpha * alpha;
    let d = h.z * h.z * (a2 - R::ONE) + R::ONE;
    a2 / (R::of(PI) * d * d)
}

/// The same with two roughnesses.
fn anisotropic_ggx<R: Real>(h: Vec3<R>, [ax, ay]: [R; 2]) -> R {
    let (a, b) = (h.x / ax, h.y / ay);
    let d = a * a + b * b + h.z * h.z;
    (R::of(PI) * ax * ay * d * d).recip()
}

/// The normals of GGX that are visible: G1 max(0, w · h) D / cos.
fn visible_ggx<R: Real>(w: Vec3<R>, h: Vec3<R>, [ax, ay]: [R; 2]) -> R {
    let (x, y) = (ax * w.x, ay * w.y);
    let tangent2 = (x * x + y * y) / (w.z * w.z);
    let g1 = R::of(2.0) / (R::ONE + (R::ONE + tangent2).sqrt());
    g1 * w.dot(h).max(R::ZERO) * anisotropic_ggx(h, [ax, ay]) / w.z
}

/// Slopes of Beckmann's microfacets of unit roughness that are visible to a viewer in the direction of the first
/// slope, by the cotangent of the angle with the normal (Heitz, "Understanding the Masking-Shadowing Function in
/// Microfacet-Based BRDFs", 2014).
fn visible_slopes<R: Real>(x: R, y: R, cot: R) -> R {
    let one = R::ONE;
    let slope = (-cot * cot).exp() / (cot * R::of(PI).sqrt());
    let g1 = R::of(2.0) / (one + erf(cot) + slope);
    g1 * (cot + x) / cot * (-x * x - y * y).exp() / R::of(PI)
}

/// Solid angle of normals for that of refracted directions: Eq. 17 of Walter et al.
fn refraction<R: Real>(w: Vec3<R>, inside: R, x: Vec3<R>, outside: R, h: Vec3<R>) -> R {
    let d = inside * w.dot(h) + outside * x.dot(h);
    outside * outside * x.dot(h).abs() / (d * d)
}
