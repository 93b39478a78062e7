//! The renderer's samplers and maps. Their inverses and densities are derived; nothing here, or
//! anywhere else in this crate, is a density written by hand.

use aether_core::prelude::*;

/// Directions about +z, distributed as cos(theta) / pi.
#[sampler]
pub fn cosine_hemisphere(u: [Uniform; 2]) -> Direction {
    let r = u[0].sqrt();
    let phi = TAU * u[1];
    Direction::new(r * phi.cos(), r * phi.sin(), (1.0 - u[0]).sqrt())
}

/// Uniform on the triangle a, b, c.
#[sampler]
pub fn uniform_triangle(u: [Uniform; 2], a: Vec3, b: Vec3, c: Vec3, id: SurfaceId) -> SurfacePoint {
    let s = u[0].sqrt();
    SurfacePoint::new(a + s * (1.0 - u[1]) * (b - a) + s * u[1] * (c - a), id)
}

/// Uniform on the sphere with this centre and radius.
#[sampler]
pub fn uniform_sphere_surface(
    u: [Uniform; 2],
    centre: Vec3,
    radius: f64,
    id: SurfaceId,
) -> SurfacePoint {
    let z = 1.0 - 2.0 * u[0];
    let r = (1.0 - z * z).sqrt();
    let phi = TAU * u[1];
    SurfacePoint::new(centre + radius * Vec3::new(r * phi.cos(), r * phi.sin(), z), id)
}

/// Uniform on the ellipse of all centre + p·a + q·b with p² + q² ≤ 1.
#[sampler]
pub fn uniform_disk(
    u: [Uniform; 2],
    centre: Vec3,
    a: Vec3,
    b: Vec3,
    id: SurfaceId,
) -> SurfacePoint {
    let r = u[0].sqrt();
    let phi = TAU * u[1];
    SurfacePoint::new(centre + r * phi.cos() * a + r * phi.sin() * b, id)
}

/// Uniform on the square of side one about a point of the film: the box filter.
#[sampler]
pub fn film_box(u: [Uniform; 2], x: f64, y: f64) -> Vec2 {
    Vec2::new(x - 0.5 + u[0], y - 0.5 + u[1])
}

/// One quadrant of the tent filter about a point of the film; the signed radii say which.
#[sampler]
pub fn film_tent(u: [Uniform; 2], x: f64, y: f64, radius_x: f64, radius_y: f64) -> Vec2 {
    let p = radius_x * (1.0 - (1.0 - u[0]).sqrt());
    let q = radius_y * (1.0 - (1.0 - u[1]).sqrt());
    Vec2::new(x + p, y + q)
}

/// A Gaussian about a point of the film, cut off at the radius within which lies a fraction `mass`.
#[sampler]
pub fn film_gaussian(u: [Uniform; 2], x: f64, y: f64, stddev: f64, mass: f64) -> Vec2 {
    let r = stddev * (-2.0 * (-u[0] * mass).ln_1p()).sqrt();
    let phi = TAU * u[1];
    Vec2::new(x + r * phi.cos(), y + r * phi.sin())
}

/// The direction in camera space in which a pinhole camera sees a point of the film: x to the right,
/// y down, z into the scene. `centre` is the point that the axis goes through, `scale` the width and
/// height of one pixel at distance one.
#[map]
pub fn pinhole(film: Vec2, centre: Vec2, scale: Vec2) -> Direction {
    let x = scale.x * (film.x - centre.x);
    let y = scale.y * (film.y - centre.y);
    Direction::from_vec(Vec3::new(x, y, 1.0).normalize())
}

/// A direction given in a frame, in world coordinates.
#[map]
pub fn rotate(w: Direction, frame: Frame) -> Direction {
    Direction::from_vec(frame.to_world(w))
}

/// Where the ray from `origin` in direction `w` meets the plane through `point` with normal
/// `normal`, as a point of the surface `id`.
///
/// For a curved surface the plane is the tangent plane at the hit: a density needs the surface to
/// first order only.
#[map]
pub fn hit_plane(
    w: Direction,
    origin: Vec3,
    point: Vec3,
    normal: Vec3,
    id: SurfaceId,
) -> SurfacePoint {
    let t = normal.dot(point - origin) / normal.dot(w);
    require(t > 0.0);
    SurfacePoint::new(origin + t * w, id)
}

/// All directions alike.
#[sampler]
pub fn uniform_directions(u: [Uniform; 2]) -> Direction {
    let z = 1.0 - 2.0 * u[0];
    let r = (1.0 - z * z).sqrt();
    let phi = TAU * u[1];
    Direction::new(r * phi.cos(), r * phi.sin(), z)
}

/// All directions alike within the cone about +z where one minus the cosine is at most `depth`.
#[sampler(depth in 0.0..=1.0)]
pub fn uniform_cone(u: [Uniform; 2], depth: f64) -> Direction {
    let h = depth * u[0];
    let r = (h * (2.0 - h)).sqrt();
    let phi = TAU * u[1];
    Direction::new(r * phi.cos(), r * phi.sin(), 1.0 - h)
}

/// All directions alike that lie in a spherical triangle with one corner at the pole +z. The side opposite
/// to it lies on a great circle that comes nearest to the pole in the half plane of +x, at a distance whose
/// half has the tangent `tau`; it is sampled from `from` on, in terms of half the signed area between that
/// nearest point, the pole, and a point of the side; `half` is half the area of the whole triangle.
///
/// The first uniform cuts off its share of the area at a point of the far side. The area of a right
/// spherical triangle is twice the arc tangent of the product of the tangents of half its legs, so that this
/// point is found by one tangent. The second one divides the arc from the pole to there, by its depth below
/// the pole (Archimedes). The idea of both steps is Arvo's ("Stratified Sampling of Spherical Triangles",
/// 1995); starting from the foot of the perpendicular makes them short, and the density a constant.
#[sampler(
    tau in 1e-3..=1.0, from in -1.5707..=1.5707, half in 1e-5..=3.1, where from + half <= 1.5707
)]
pub fn spherical_triangle(u: [Uniform; 2], tau: f64, from: f64, half: f64) -> Direction {
    // The corner itself loses its azimuth, and next to it squares of coordinates vanish.
    require(u[1] > 1e-18);
    let w = (from + half * u[0]).tan() / tau;
    let phi = (w * (1.0 + tau * tau)).atan2(tau * (1.0 - w * w));
    let depth = 2.0 * (tau * tau + w * w) / ((1.0 + tau * tau) * (1.0 + w * w));
    let h = u[1] * depth;
    let r = (h * (2.0 - h)).sqrt();
    Direction::new(r * phi.cos(), r * phi.sin(), 1.0 - h)
}
