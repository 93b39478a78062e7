//! Directions.

use aether_core::prelude::*;

/// Row 66: uniform on the hemisphere, by concentric squares.
#[sampler]
pub fn concentric_hemisphere(u: [Uniform; 2]) -> Direction {
    let (a, b) = (2.0 * u[0] - 1.0, 2.0 * u[1] - 1.0);
    let (r, theta) = if a.abs() > b.abs() {
        (a, PI / 4.0 * (b / a))
    } else {
        (b, PI / 2.0 - PI / 4.0 * (a / b))
    };
    let s = r * (2.0 - r * r).sqrt();
    Direction::new(s * theta.cos(), s * theta.sin(), 1.0 - r * r)
}

/// Row 65: uniform on the cone about +z with 1 - cos up to m.
#[sampler(m in 0.0..=2.0)]
pub fn cone(u: [Uniform; 2], m: f64) -> Direction {
    let h = m * u[0];
    let r = (h * (2.0 - h)).sqrt();
    let phi = TAU * u[1];
    Direction::new(r * phi.cos(), r * phi.sin(), 1.0 - h)
}

/// Row 69: uniform on two lunes of half angle t around +x and -x.
#[sampler(t in 1e-6..=1.5707963267948966)]
pub fn double_lune(u: [Uniform; 2], t: f64) -> Direction {
    let theta = if u[0] < 0.5 { 4.0 * t * u[0] - t } else { 4.0 * t * u[0] + PI - 3.0 * t };
    let z = 1.0 - 2.0 * u[1];
    let r = (1.0 - z * z).sqrt();
    Direction::new(r * theta.cos(), r * theta.sin(), z)
}

/// Row 74: von Mises-Fisher about +z, by the depth below the pole.
#[sampler(kappa in 1e-12..)]
pub fn von_mises_fisher(u: [Uniform; 2], kappa: f64) -> Direction {
    let m = -((1.0 - u[0]) * (-2.0 * kappa).exp_m1()).ln_1p() / kappa;
    let r = (m * (2.0 - m)).sqrt();
    let phi = TAU * u[1];
    Direction::new(r * phi.cos(), r * phi.sin(), 1.0 - m)
}

/// Row 74 by the cosine, as it is printed.
#[sampler(kappa in 1e-12..)]
pub fn von_mises_fisher_as_printed(u: [Uniform; 2], kappa: f64) -> Direction {
    let c = 1.0 + ((1.0 - u[0]) * (-2.0 * kappa).exp_m1()).ln_1p() / kappa;
    let r = (1.0 - c * c).sqrt();
    let phi = TAU * u[1];
    Direction::new(r * phi.cos(), r * phi.sin(), c)
}

/// Row 75: Henyey-Greenstein about +z, by the depth below the pole.
#[sampler(g in -0.9999999..=0.9999999)]
pub fn henyey_greenstein(u: [Uniform; 2], g: f64) -> Direction {
    let f = 1.0 - g + 2.0 * g * u[0];
    let m = 2.0 * (1.0 - g).powi(2) * (1.0 - u[0]) * (1.0 + g * u[0]) / f.powi(2);
    let r = (m * (2.0 - m)).sqrt();
    let phi = TAU * u[1];
    Direction::new(r * phi.cos(), r * phi.sin(), 1.0 - m)
}

/// Row 75 by the cosine, as it is printed everywhere.
// Of its inverse the ends of the domain leave few digits, which is known.
#[allow(deprecated)]
#[sampler(g in -0.9999999..=0.9999999)]
pub fn henyey_greenstein_as_printed(u: [Uniform; 2], g: f64) -> Direction {
    let f = (1.0 - g * g) / (1.0 - g + 2.0 * g * u[0]);
    let c = (1.0 + g * g - f * f) / (2.0 * g);
    let r = (1.0 - c * c).sqrt();
    let phi = TAU * u[1];
    Direction::new(r * phi.cos(), r * phi.sin(), c)
}

/// Row 77: a linearly transformed cosine.
#[sampler]
pub fn transformed_cosine(u: [Uniform; 2], m: Mat3) -> Direction {
    let r = u[0].sqrt();
    let phi = TAU * u[1];
    let w = Vec3::new(r * phi.cos(), r * phi.sin(), (1.0 - u[0]).sqrt());
    Direction::from_vec((m * w).normalize())
}

/// Row 81: normals of Beckmann microfacets.
#[sampler(alpha in 1e-6..)]
pub fn beckmann(u: [Uniform; 2], alpha: f64) -> Direction {
    let t = (-alpha * alpha * (-u[0]).ln_1p()).sqrt();
    let phi = TAU * u[1];
    let z = 1.0 / (1.0 + t * t).sqrt();
    Direction::new(t * z * phi.cos(), t * z * phi.sin(), z)
}

/// Row 82: normals of GGX microfacets.
#[sampler(alpha in 1e-6..)]
pub fn ggx(u: [Uniform; 2], alpha: f64) -> Direction {
    let r = (u[0] / (1.0 - u[0])).sqrt();
    let phi = TAU * u[1];
    Direction::from_vec(Vec3::new(alpha * r * phi.cos(), alpha * r * phi.sin(), 1.0).normalize())
}

/// Row 83: normals of anisotropic GGX microfacets.
#[sampler(ax in 1e-6.., ay in 1e-6..)]
pub fn anisotropic_ggx(u: [Uniform; 2], ax: f64, ay: f64) -> Direction {
    let r = (u[0] / (1.0 - u[0])).sqrt();
    let phi = TAU * u[1];
    Direction::from_vec(Vec3::new(ax * r * phi.cos(), ay * r * phi.sin(), 1.0).normalize())
}

/// Row 84: the half vectors of Ashikhmin and Shirley.
#[sampler(nu in 0.0.., nv in 0.0..)]
pub fn ashikhmin_shirley(u: [Uniform; 2], nu: f64, nv: f64) -> Direction {
    let turn = TAU * u[1];
    let phi = ((nu + 1.0).sqrt() * turn.sin()).atan2((nv + 1.0).sqrt() * turn.cos());
    let n = nu * phi.cos().powi(2) + nv * phi.sin().powi(2);
    let z = (1.0 - u[0]).powf(1.0 / (n + 1.0));
    let r = (1.0 - z * z).sqrt();
    Direction::new(r * phi.cos(), r * phi.sin(), z)
}

/// Row 91: a power cosine with probability p, else a cosine, by one uniform.
#[sampler(p in 0.0..=1.0, n in 0.0..)]
pub fn mixture(u: [Uniform; 2], p: f64, n: f64) -> Direction {
    let phi = TAU * u[1];
    if u[0] < p {
        let z = (u[0] / p).powf(1.0 / (n + 1.0));
        let r = (1.0 - z * z).sqrt();
        Direction::new(r * phi.cos(), r * phi.sin(), z)
    } else {
        let v = (u[0] - p) / (1.0 - p);
        let r = v.sqrt();
        Direction::new(r * phi.cos(), r * phi.sin(), (1.0 - v).sqrt())
    }
}

/// Row 92: the sheen of Charlie.
#[sampler(alpha in 1e-3..)]
pub fn sheen(u: [Uniform; 2], alpha: f64) -> Direction {
    let s = u[0].powf(alpha / (2.0 * alpha + 1.0));
    let phi = TAU * u[1];
    Direction::new(s * phi.cos(), s * phi.sin(), (1.0 - s * s).sqrt())
}

/// Row 99: the directions of a perspective camera with half width t and aspect ratio a.
#[sampler(t in 1e-6.., a in 1e-6..)]
pub fn perspective(u: [Uniform; 2], t: f64, a: f64) -> Direction {
    Direction::from_vec(
        Vec3::new(t * (2.0 * u[0] - 1.0), t * a * (2.0 * u[1] - 1.0), 1.0).normalize(),
    )
}

/// Row 68: uniform in z between z0 and z1 and in azimuth from p over the angle d.
#[sampler(z0 in -1.0..=1.0, z1 in -1.0..=1.0, d in 1e-6..=6.283185307179586, where z0 < z1)]
pub fn zonal_window(u: [Uniform; 2], z0: f64, z1: f64, p: f64, d: f64) -> Direction {
    let z = (1.0 - u[0]) * z0 + u[0] * z1;
    let r = (1.0 - z * z).sqrt();
    let phi = p + d * u[1];
    Direction::new(r * phi.cos(), r * phi.sin(), z)
}

/// Row 76: Rayleigh's phase function about +z.
#[sampler]
pub fn rayleigh(u: [Uniform; 2]) -> Direction {
    let b = 4.0 * u[0] - 2.0;
    let t = (b + (b * b + 1.0).sqrt()).cbrt();
    let c = t - 1.0 / t;
    let r = (1.0 - c * c).sqrt();
    let phi = TAU * u[1];
    Direction::new(r * phi.cos(), r * phi.sin(), c)
}

/// Row 67: uniform on the sphere, by the equal-area octahedral map of the square.
#[sampler]
pub fn equal_area_octahedral(u: [Uniform; 2]) -> Direction {
    let (a, b) = (2.0 * u[0] - 1.0, 2.0 * u[1] - 1.0);
    let s = 1.0 - a.abs() - b.abs();
    let r = 1.0 - s.abs();
    let phi = PI / 4.0 * ((b.abs() - a.abs()) / r + 1.0);
    let h = r * (2.0 - r * r).sqrt();
    Direction::new(
        (h * phi.cos()).copysign(a),
        (h * phi.sin()).copysign(b),
        s.signum() * (1.0 - r * r),
    )
}

/// Row 86: normals of GGX that are visible from w, by a spherical cap.
#[sampler(alpha in 1e-4..=1.0, where w.z > 0.0)]
pub fn visible_normals(u: [Uniform; 2], alpha: f64, w: Direction) -> Direction {
    let v = Vec3::new(alpha * w.x, alpha * w.y, w.z).normalize();
    let z = 1.0 - u[1] * (1.0 + v.z);
    let r = (1.0 - z * z).sqrt();
    let phi = TAU * u[0];
    let n = (Vec3::new(r * phi.cos(), r * phi.sin(), z) + v).normalize();
    Direction::from_vec(Vec3::new(alpha * n.x, alpha * n.y, n.z).normalize())
}

/// Row 86 with two roughnesses.
#[sampler(alpha_x in 1e-4..=1.0, alpha_y in 1e-4..=1.0, where w.z > 0.0)]
pub fn anisotropic_normals(u: [Uniform; 2], alpha_x: f64, alpha_y: f64, w: Direction) -> Direction {
    let v = Vec3::new(alpha_x * w.x, alpha_y * w.y, w.z).normalize();
    let z = 1.0 - u[1] * (1.0 + v.z);
    let r = (1.0 - z * z).sqrt();
    let phi = TAU * u[0];
    let n = (Vec3::new(r * phi.cos(), r * phi.sin(), z) + v).normalize();
    Direction::from_vec(Vec3::new(alpha_x * n.x, alpha_y * n.y, n.z).normalize())
}

/// Row 89: w reflected about a normal of GGX.
#[sampler(alpha in 1e-4..=1.0)]
pub fn reflected_ggx(u: [Uniform; 2], alpha: f64, w: Direction) -> Direction {
    let r = alpha * (u[0] / (1.0 - u[0])).sqrt();
    let phi = TAU * u[1];
    let h = Vec3::new(r * phi.cos(), r * phi.sin(), 1.0).normalize();
    Direction::from_vec(2.0 * h.dot(w) * h - w)
}

/// Row 90: w refracted at a normal of GGX on its side, into a medium with the relative index eta.
#[sampler(alpha in 1e-4..=1.0, eta in 0.25..=4.0)]
pub fn refracted_ggx(u: [Uniform; 2], alpha: f64, eta: f64, w: Direction) -> Option<Direction> {
    let r = alpha * (u[0] / (1.0 - u[0])).sqrt();
    let phi = TAU * u[1];
    let h = Vec3::new(r * phi.cos(), r * phi.sin(), 1.0).normalize();
    let c = h.dot(w);
    let k = 1.0 - (1.0 - c * c) / (eta * eta);
    if c > 0.0 && k > 0.0 {
        Some(Direction::from_vec(((c - eta * k.sqrt()) * h - w) / eta))
    } else {
        None
    }
}
