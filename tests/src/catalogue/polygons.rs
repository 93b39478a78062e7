//! Directions in which polygons are seen: as they are printed, and in forms that hold for the smallest and the largest.
//! Normals of facets that are seen, for views from straight above too.

use aether_core::prelude::*;
use aether_core::{DomainError, Scalar};

/// Row 70: uniform in the solid angle `omega` of a spherical triangle with corners a, b and a third one, as Arvo prints
/// it ("Stratified Sampling of Spherical Triangles", 1995). `alpha` is the angle at a, `ca` and `sa` are its cosine and
/// sine, `cosab` is the cosine of the side from a to b, and n the unit vector perpendicular to a towards the third corner.
#[sampler(ca in -0.999..=0.999, sa in 0.01..=1.0, omega in 1e-3..=6.0, alpha in 0.01..=3.13)]
pub fn spherical_triangle(
    u: [Uniform; 2],
    ca: f64,
    sa: f64,
    cosab: f64,
    omega: f64,
    alpha: f64,
    a: Direction,
    b: Direction,
    n: Direction,
) -> Direction {
    let psi = omega * u[0] - alpha;
    let (s, t) = (psi.sin(), psi.cos());
    let q = t - ca;
    let w = s + sa * cosab;
    let k = ((w * t - q * s) * ca - w) / ((w * s + q * t) * sa);
    let c = k * a + (1.0 - k * k).sqrt() * n;
    let z = 1.0 - u[1] * (1.0 - c.dot(b));
    let side = (c - c.dot(b) * b).normalize();
    Direction::from_vec(z * b + (1.0 - z * z).sqrt() * side)
}

/// Row 71: uniform in the solid angle of the rectangle from (.., y0) to (.., y1) at the height z0, as Ureña, Fajardo
/// and King print it: `b0` and `b1` are the heights of the unit normals of the planes through the lower and the upper
/// side, the solid angle is `omega`, and `start` is what its corners on the left leave of a turn.
/// `where` says that x grows with the first uniform, which holds for every rectangle.
#[sampler(
    b0 in -0.999..=0.999, b1 in -0.999..=0.999, omega in 1e-3..=6.0, start in 0.0..=6.28,
    where start + omega <= 6.28, where b0 + b1 > 0.0, where b1 * start.cos() < b0,
    where b1 * (start + omega).cos() < b0
)]
pub fn spherical_rectangle(
    u: [Uniform; 2],
    b0: f64,
    b1: f64,
    omega: f64,
    start: f64,
    y0: f64,
    y1: f64,
    z0: f64,
) -> Direction {
    let a = start + omega * u[0];
    let f = (a.cos() * b0 - b1) / a.sin();
    let c = f.signum() / (f * f + b0 * b0).sqrt();
    let x = -c * z0 / (1.0 - c * c).sqrt();
    let d = (x * x + z0 * z0).sqrt();
    let h0 = y0 / (d * d + y0 * y0).sqrt();
    let h1 = y1 / (d * d + y1 * y1).sqrt();
    let h = h0 + u[1] * (h1 - h0);
    let y = h * d / (1.0 - h * h).sqrt();
    Direction::from_vec(Vec3::new(x, y, z0).normalize())
}

/// Row 70 in another form: uniform in a spherical triangle with one corner at the third axis of a frame.
///
/// The side opposite to that pole lies on a great circle that comes nearest to it, in the half plane of the first axis,
/// at a distance whose half has the tangent `tau`. With w the tangent of half the way along that circle, tan⁻¹(tau w) is
/// half the area between that nearest point, the pole and the point of the circle: it goes from `from` to `from` +
/// `half`. The second uniform divides the arc from the pole to there, by its depth below the pole.
#[sampler(
    tau in 1e-9..=1.0, from in -1.5707..=1.5707, half in 1e-12..=3.1, where from + half <= 1.5707
)]
pub fn triangle_from_foot(
    u: [Uniform; 2],
    tau: f64,
    from: f64,
    half: f64,
    frame: Frame,
) -> Direction {
    let w = (from + half * u[0]).tan() / tau;
    let phi = (w * (1.0 + tau * tau)).atan2(tau * (1.0 - w * w));
    let depth = 2.0 * (tau * tau + w * w) / ((1.0 + tau * tau) * (1.0 + w * w));
    let h = u[1] * depth;
    let r = (h * (2.0 - h)).sqrt();
    Direction::from_vec(frame.to_world(Vec3::new(r * phi.cos(), r * phi.sin(), 1.0 - h)))
}

/// Row 70: the directions in which the triangle with these corners is seen from the origin. The first uniform goes from
/// a to c, the second from b to the side between these.
///
/// # Errors
/// If the triangle has no area or half the sky, or if the side from a to c passes the point of its great circle that is
/// farthest from b.
pub fn seen_triangle<R: Scalar>(
    a: Vec3<R>,
    b: Vec3<R>,
    c: Vec3<R>,
) -> Result<TriangleFromFoot<R>, DomainError> {
    let [a, b, c] = [a, b, c].map(Vec3::normalize);
    // The normal of the circle on the side of b, by differences: corners may be close to each other.
    let normal = (c - a).cross(a).normalize();
    let side = R::ONE.copysign(normal.dot(b - a));
    let normal = normal * side;
    let sine = normal.dot(b - a);
    let below = b - normal * sine;
    let below = below - normal * normal.dot(below);
    let cosine = below.length();
    // From its pole all of the circle is as far.
    let foot = if cosine > R::EPSILON { below / cosine } else { a };
    // The way from a to c along the circle, at its point next to b.
    let along = foot.cross(normal) * side;
    let tau = sine / (R::ONE + cosine);
    let half_way = |p: Vec3<R>| p.dot(along) / (R::ONE + p.dot(foot));
    let (start, end) = (tau * half_way(a), tau * half_way(c));
    let half = (tau * (half_way(c) - half_way(a))).atan2(R::ONE + start * end);
    let frame = Frame::try_from_axes(foot * sine - normal * cosine, along, b);
    let frame = frame.ok_or(DomainError {
        item: "seen_triangle",
        requirement: "corners in different directions",
        value: sine.to_f64(),
    })?;
    triangle_from_foot(tau, start.atan(), half, frame)
}

/// Row 71 in another form: uniform in the solid angle of a rectangle in a plane z = -1 with sides along x and y.
///
/// Of the elevations of the lower and of the upper side, whose tangents are the bounds of y, `d` is the tangent of half
/// the difference and `m` that of the mean. With t the tangent of half the solid angle between the plane x = 0 and a
/// point, x is n w / √(1 - k² w²), where w = t / (d - m t²), k = 1 - d m and n² = (1 + m²) (1 + d²); tan⁻¹ t goes from
/// `from` to `from` + `half`. The second uniform divides the arc of the rectangle in the plane of this x by its height.
#[sampler(
    d in 1e-9..=1e9, m in -1e9..=1e9, from in -1.57079632679..=1.57079632679, half in 1e-300..=3.14159265358,
    where from + half <= 1.57079632679, where (from + half).tan() < d, where from.tan() > -d, where m.abs() * d < 1.0
)]
pub fn rectangle_by_elevations(u: [Uniform; 2], d: f64, m: f64, from: f64, half: f64) -> Direction {
    let t = (from + half * u[0]).tan();
    let w = t / (d - m * t * t);
    let k = 1.0 - d * m;
    let n = ((1.0 + m * m) * (1.0 + d * d)).sqrt();
    let q = (1.0 - k * k * w * w).sqrt();
    let phi = (n * w).atan2(q);
    // The heights of the two sides in this plane; their difference without cancellation.
    let s = (1.0 + 4.0 * d * m * w * w).sqrt();
    let low = (m - d) * q / (n * s);
    let span = d * q / (n * s) * (1.0 + s + 4.0 * m * m * w * w / (1.0 + s));
    let h = low + u[1] * span;
    let r = (1.0 - h * h).sqrt();
    Direction::new(r * phi.sin(), h, -r * phi.cos())
}

/// Row 71: the directions in which the rectangle from (x0, y0) to (x1, y1) in the plane of height z0 < 0 is seen from
/// the origin.
///
/// # Errors
/// If the rectangle has no area, or the plane is not below.
pub fn seen_rectangle<R: Scalar>(
    x0: R,
    y0: R,
    x1: R,
    y1: R,
    z0: R,
) -> Result<RectangleByElevations<R>, DomainError> {
    let [a, b, p, q] = [x0, x1, y0, y1].map(|t| t / -z0);
    let r = ((R::ONE + p * p) * (R::ONE + q * q)).sqrt();
    // The tangent of half an angle from the sine and the cosine, times r, whichever way nothing cancels.
    let half_tangent = |sine: R, cosine: R| match cosine > R::ZERO {
        true => sine / (r + cosine),
        false => (r - cosine) / sine,
    };
    let d = half_tangent(q - p, R::ONE + p * q);
    let m = half_tangent(q + p, R::ONE - p * q);
    let n = ((R::ONE + m * m) * (R::ONE + d * d)).sqrt();
    let tangent = |x: R| {
        let leg = |k: R| n.hypot(k * x);
        R::of(2.0) * d * x / (leg(R::ONE + d * m) + leg(R::ONE - d * m))
    };
    let (t, u) = (tangent(a), tangent(b));
    rectangle_by_elevations(d, m, t.atan(), (u - t).atan2(R::ONE + t * u))
}

/// Row 85 in the frame of its listing, whose axes are T1, T2 and V: a point of the disk is moved into the half of it
/// that is seen, `s` of which is there for V straight above.
#[sampler(alpha in 1e-3..=1.0, s in 0.5..=1.0)]
pub fn normals_in_frame(u: [Uniform; 2], alpha: f64, s: f64, frame: Frame) -> Direction {
    let r = u[0].sqrt();
    let phi = TAU * u[1];
    let a = r * phi.cos();
    let b = (1.0 - s) * (1.0 - a * a).sqrt() + s * r * phi.sin();
    let n = frame.to_world(Vec3::new(a, b, (1.0 - a * a - b * b).sqrt()));
    Direction::from_vec(Vec3::new(alpha * n.x, alpha * n.y, n.z).normalize())
}

/// Row 85: normals of GGX that are visible from w, as Heitz lists them (2018): seen from straight above, the first axis
/// is x.
///
/// # Errors
/// If w is below the surface, or alpha outside of its domain.
pub fn heitz_normals<R: Scalar>(
    alpha: R,
    w: Direction<R>,
) -> Result<NormalsInFrame<R>, DomainError> {
    let v = Vec3::new(alpha * w.x, alpha * w.y, w.z).normalize();
    let across = v.x.hypot(v.y);
    let t1 = match across > R::ZERO {
        true => Vec3::new(-v.y / across, v.x / across, R::ZERO),
        false => Vec3::new(R::ONE, R::ZERO, R::ZERO),
    };
    let frame = Frame::try_from_axes(t1, v.cross(t1), v).ok_or(DomainError {
        item: "heitz_normals",
        requirement: "a direction",
        value: across.to_f64(),
    })?;
    normals_in_frame(alpha, R::of(0.5) * (R::ONE + v.z), frame)
}
