//! Surfaces and curves in space: points chosen on them, and points where rays meet them.

use aether_core::{Real, Vec3};
use core::f64::consts::{FRAC_1_PI, PI, TAU};

use super::vector;
use crate::registry::Which;

/// The density of a sampler of points of a surface or a curve.
pub fn density<R: Real>(which: Which, p: &[R], x: &[R]) -> Option<R> {
    light(which, p).or_else(|| embedded(which, p, x)).or_else(|| met(which, p, x))
}

/// One over the area.
fn light<R: Real>(which: Which, p: &[R]) -> Option<R> {
    let c = R::of;
    let density = match which {
        Which::Triangle | Which::TriangleHeitz | Which::TriangleFold | Which::TriangleLight => {
            let side = |k: usize| vector(p, 3 * k) - vector(p, 0);
            c(2.0) / side(1).cross(side(2)).length()
        }
        Which::SphereSurface | Which::SphereLightSurface => (c(4.0 * PI) * p[3] * p[3]).recip(),
        Which::DiskLight => (c(PI) * vector(p, 3).cross(vector(p, 6)).length()).recip(),
        Which::RectangleLight => vector(p, 3).cross(vector(p, 6)).length().recip(),
        Which::CylinderLight => (c(TAU) * p[7] * p[6]).recip(),
        Which::TruncatedCone => {
            let slant = (p[2] * p[2] + (p[0] - p[1]) * (p[0] - p[1])).sqrt();
            (c(PI) * (p[0] + p[1]) * slant).recip()
        }
        Which::Simplex => c(2.0) / c(3.0).sqrt(),
        _ => return None,
    };
    Some(density)
}

/// Uniform in the parameters: one over the element of area or length.
fn embedded<R: Real>(which: Which, p: &[R], x: &[R]) -> Option<R> {
    let c = R::of;
    let one = R::ONE;
    let density = match which {
        Which::HeightField => {
            let (a, b) = (c(PI) * x[0], c(PI) * x[1]);
            let slope = |value: R| c(PI) * p[0] * value;
            let (dx, dy) = (slope(a.cos() * b.sin()), slope(a.sin() * b.cos()));
            (one + dx * dx + dy * dy).sqrt().recip()
        }
        Which::Helix => (p[2] * (p[0] * p[0] + p[1] * p[1]).sqrt()).recip(),
        Which::Torus => (c(TAU * TAU) * p[1] * x[0].hypot(x[1])).recip(),
        Which::Ellipsoid => {
            let [a, b, d] = [0, 1, 2].map(|i| x[i] / (p[i] * p[i]));
            let length = (a * a + b * b + d * d).sqrt();
            (c(4.0 * PI) * p[0] * p[1] * p[2] * length).recip()
        }
        Which::BilinearPatch => bilinear_patch(p, vector(x, 0)),
        _ => return None,
    };
    Some(density)
}

/// One over the vector product of the derivatives. The parameters of the point are found where the patch is
/// projected along the common normal of its diagonals.
fn bilinear_patch<R: Real>(p: &[R], x: Vec3<R>) -> R {
    let [a, b, c, d] = [0, 3, 6, 9].map(|first| vector(p, first));
    let normal = (c - a).cross(d - b);
    let cross = |a: Vec3<R>, b: Vec3<R>| normal.dot(a.cross(b));
    let (e, f, g, h) = (b - a, d - a, a - b + c - d, x - a);
    let (k2, k1, k0) = (cross(g, f), cross(e, f) + cross(h, g), cross(h, e));
    // The conjugate root, which parallelograms have too.
    let v = R::of(-2.0) * k0 / (k1 + (k1 * k1 - R::of(4.0) * k0 * k2).sqrt());
    let across = e + g * v;
    let u = (h - f * v).dot(across) / across.dot(across);
    across.cross(f + g * u).length().recip()
}

/// Rays that meet a surface: the density of the direction times cosine over squared distance.
fn met<R: Real>(which: Which, p: &[R], x: &[R]) -> Option<R> {
    let c = R::of;
    let x = vector(x, 0);
    let hit = |directions: R, ray: Vec3<R>, normal: Vec3<R>| {
        let d2 = ray.dot(ray);
        directions * normal.dot(ray).abs() / (normal.length() * d2.sqrt() * d2)
    };
    let density = match which {
        Which::OntoPlane => {
            let ray = x - vector(p, 0);
            hit(ray.z / ray.length() * c(FRAC_1_PI), ray, vector(p, 6))
        }
        Which::DiffuseHit => {
            let axis = vector(p, 0).normalize();
            hit(axis.dot(x) / x.length() * c(FRAC_1_PI), x, vector(p, 6))
        }
        Which::SphereLight => {
            let centre = Vec3::new(R::ZERO, R::ZERO, p[1]);
            hit((c(TAU) * p[0]).recip(), x, x - centre)
        }
        // Parallel rays: the area of a pixel, as large as it is seen from where they come.
        Which::ParallelFilm => {
            let (w, normal) = (vector(p, 11), vector(p, 17));
            let pixel = vector(p, 5).cross(vector(p, 8)).dot(w).abs();
            normal.dot(w).abs() / (normal.length() * pixel)
        }
        _ => return None,
    };
    Some(density)
}
