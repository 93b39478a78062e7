//! Surfaces and volumes in space.

use core::f64::consts::{FRAC_1_PI, TAU};

use aether_core::prelude::{Surface, Vec3};

use super::{by_hand, finite};

/// How far rounding may move a point of coordinates of this size, in units of it.
const ROUNDING: f64 = 16.0 * f64::EPSILON;

/// The largest coordinate.
#[inline(always)]
fn size(v: Vec3) -> f64 {
    v.x.abs().max(v.y.abs()).max(v.z.abs())
}

by_hand! {
    /// Row 47: uniform on a triangle.
    Triangle(a: Vec3, b: Vec3, c: Vec3): [2] => Surface;
    sample(u) {
        let s = (1.0 - u[0]).sqrt();
        let (p, q) = (s * (1.0 - u[1]), s * u[1]);
        Surface::from_vec(a + p * (b - a) + q * (c - a))
    }
    pdf(x) {
        let (e, f, d) = (b - a, c - a, x.vec() - a);
        let n = e.cross(f);
        let square = n.length_squared();
        let (p, q) = (n.dot(d.cross(f)), n.dot(e.cross(d)));
        if !(p >= -ROUNDING * square && q >= -ROUNDING * square && p + q <= square * (1.0 + ROUNDING)) {
            return 0.0;
        }
        // Off the plane by no more than coordinates are rounded.
        let bound = ROUNDING * (size(x.vec()) + size(a) + size(b) + size(c));
        let off = n.dot(d);
        if off * off <= bound * bound * square { 2.0 / square.sqrt() } else { 0.0 }
    }
    draw(u) {
        let (e, f) = (b - a, c - a);
        let s = (1.0 - u[0]).sqrt();
        let (p, q) = (s * (1.0 - u[1]), s * u[1]);
        (Surface::from_vec(a + p * e + q * f), 2.0 / e.cross(f).length())
    }

    /// Row 93: uniform on a sphere's surface.
    SphereSurface(centre: Vec3, radius: f64): [2] => Surface;
    sample(u) {
        let z = 1.0 - 2.0 * u[0];
        let r = (1.0 - z * z).sqrt();
        let (s, c) = (TAU * u[1]).sin_cos();
        Surface::from_vec(centre + radius * Vec3::new(r * c, r * s, z))
    }
    pdf(x) {
        let d = x.vec() - centre;
        let square = radius * radius;
        let bound = ROUNDING * (size(x.vec()) + size(centre) + radius);
        let near = (d.length_squared() - square).abs() <= 2.0 * bound * radius;
        if near && finite(x.0) { 0.25 * FRAC_1_PI / square } else { 0.0 }
    }
    draw(u) {
        let z = 1.0 - 2.0 * u[0];
        let r = (1.0 - z * z).sqrt();
        let (s, c) = (TAU * u[1]).sin_cos();
        let x = Surface::from_vec(centre + radius * Vec3::new(r * c, r * s, z));
        (x, 0.25 * FRAC_1_PI / (radius * radius))
    }

    /// Row 103: uniform between two spheres.
    Shell(a: f64, b: f64): [3] => Vec3;
    sample(u) {
        let r = ((1.0 - u[0]) * (a * a * a) + u[0] * (b * b * b)).cbrt();
        let z = 1.0 - 2.0 * u[1];
        let s = r * (1.0 - z * z).sqrt();
        let (sine, cosine) = (TAU * u[2]).sin_cos();
        Vec3::new(s * cosine, s * sine, r * z)
    }
    pdf(x) {
        let square = x.length_squared();
        // Samples next to a border may be rounded out of it.
        if square >= a * a * (1.0 - ROUNDING) && square <= b * b * (1.0 + ROUNDING) {
            0.75 * FRAC_1_PI / (b * b * b - a * a * a)
        } else {
            0.0
        }
    }
    draw(u) {
        let (a3, b3) = (a * a * a, b * b * b);
        let r = ((1.0 - u[0]) * a3 + u[0] * b3).cbrt();
        let z = 1.0 - 2.0 * u[1];
        let s = r * (1.0 - z * z).sqrt();
        let (sine, cosine) = (TAU * u[2]).sin_cos();
        (Vec3::new(s * cosine, s * sine, r * z), 0.75 * FRAC_1_PI / (b3 - a3))
    }

    /// Row 104: uniform in a tetrahedron.
    Tetrahedron(a: Vec3, b: Vec3, c: Vec3, d: Vec3): [3] => Vec3;
    sample(u) {
        let r = u[0].cbrt();
        let s = u[1].sqrt();
        let rs = r * s;
        a + (r - rs) * (b - a) + (rs * (1.0 - u[2])) * (c - a) + (rs * u[2]) * (d - a)
    }
    pdf(x) {
        let (e, f, g, h) = (b - a, c - a, d - a, *x - a);
        let fg = f.cross(g);
        let det = e.dot(fg);
        let he = h.cross(e);
        let (p, q, r) = (h.dot(fg) / det, -he.dot(g) / det, he.dot(f) / det);
        let inside = p >= -ROUNDING && q >= -ROUNDING && r >= -ROUNDING && p + q + r <= 1.0 + ROUNDING;
        if inside { 6.0 / det.abs() } else { 0.0 }
    }
    draw(u) {
        let (e, f, g) = (b - a, c - a, d - a);
        let r = u[0].cbrt();
        let s = u[1].sqrt();
        let rs = r * s;
        let x = a + (r - rs) * e + (rs * (1.0 - u[2])) * f + (rs * u[2]) * g;
        (x, 6.0 / e.dot(f.cross(g)).abs())
    }

    /// Row 98: the near side of a sphere light, by the cone that it fills.
    SphereLight(m: f64, d: f64, r: f64): [2] => Surface;
    sample(u) {
        let h = m * u[0];
        let s2 = h * (2.0 - h);
        let z = 1.0 - h;
        let t = (d * d - r * r) / (d * z + (r * r - d * d * s2).sqrt());
        let s = t * s2.sqrt();
        let (sine, cosine) = (TAU * u[1]).sin_cos();
        Surface::new(s * cosine, s * sine, t * z)
    }
    pdf(x) {
        let p = x.vec();
        if !finite([p.x, p.y, p.z]) {
            return 0.0;
        }
        let (low, up) = (p.x * p.x + p.y * p.y, d - p.z);
        let off = (low + up * up - r * r).abs();
        let square = low + p.z * p.z;
        let t = square.sqrt();
        // 1 - cos, without losing digits near the axis.
        let h = low / (t * (t + p.z));
        // The cosine on the light times its radius, positive on the side that is seen.
        let cosine = d * p.z - square;
        if off <= 4.0 * ROUNDING * (d + r) * r && h <= m && cosine >= 0.0 {
            cosine / (TAU * m * r * (square * t))
        } else {
            0.0
        }
    }
    draw(u) {
        let h = m * u[0];
        let s2 = h * (2.0 - h);
        let z = 1.0 - h;
        let root = (r * r - d * d * s2).sqrt();
        let t = (d * d - r * r) / (d * z + root);
        let s = t * s2.sqrt();
        let (sine, cosine) = (TAU * u[1]).sin_cos();
        // The root is the cosine on the light times its radius.
        (Surface::new(s * cosine, s * sine, t * z), root / (TAU * m * r * (t * t)))
    }
}
