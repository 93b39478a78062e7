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

/// Directions about +z, distributed as (n + 1) / 2π · cosⁿ(theta).
#[sampler(n in 0.0..=1e5)]
pub fn power_lobe(u: [Uniform; 2], n: f64) -> Direction {
    let z = (1.0 - u[0]).powf(1.0 / (n + 1.0));
    let r = (1.0 - z * z).sqrt();
    let phi = TAU * u[1];
    Direction::new(r * phi.cos(), r * phi.sin(), z)
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

/// Uniform on the side of a cylinder: all base + p·axis + q with p in [0, 1] and q on the circle of this
/// radius across the axis, which is the z axis of the frame.
#[sampler]
pub fn uniform_cylinder(
    u: [Uniform; 2],
    base: Vec3,
    frame: Frame,
    length: f64,
    radius: f64,
    id: SurfaceId,
) -> SurfacePoint {
    let phi = TAU * u[1];
    let local = Vec3::new(radius * phi.cos(), radius * phi.sin(), length * u[0]);
    SurfacePoint::new(base + frame.to_world(local), id)
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

/// Uniform on a rectangle of the film.
#[sampler]
pub fn film_rectangle(u: [Uniform; 2], corner: Vec2, size: Vec2) -> Vec2 {
    Vec2::new(corner.x + size.x * u[0], corner.y + size.y * u[1])
}

/// Around a point of the film, at a distance between `near` and `far` whose logarithm is uniform.
#[sampler(near in 1e-3..=1.0, far in 1e-3..=1e5, where near < far)]
pub fn film_near(u: [Uniform; 2], centre: Vec2, near: f64, far: f64) -> Vec2 {
    let r = far * (-(far / near).ln() * u[0]).exp();
    let phi = TAU * u[1];
    Vec2::new(centre.x + r * phi.cos(), centre.y + r * phi.sin())
}

/// Directions about +z at an angle between `near` and `far` whose logarithm is uniform.
#[sampler(near in 1e-6..=1.0, far in 1e-6..=1.5, where near < far)]
pub fn cone_near(u: [Uniform; 2], near: f64, far: f64) -> Direction {
    let theta = far * (-(far / near).ln() * u[0]).exp();
    let phi = TAU * u[1];
    Direction::new(theta.sin() * phi.cos(), theta.sin() * phi.sin(), theta.cos())
}

/// Directions whose projection onto the plane at distance one is uniform on a square about +z with sides of twice
/// `width`.
#[sampler(width in 1e-6..=1.0)]
pub fn square_of_directions(u: [Uniform; 2], width: f64) -> Direction {
    let x = width * (2.0 * u[0] - 1.0);
    let y = width * (2.0 * u[1] - 1.0);
    Direction::from_vec(Vec3::new(x, y, 1.0).normalize())
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
    normal: Direction,
    id: SurfaceId,
) -> SurfacePoint {
    let t = normal.dot(point - origin) / normal.dot(w);
    require(t > 0.0);
    SurfacePoint::new(origin + t * w, id)
}

/// Uniform on the disk about the origin with some radius.
#[sampler]
pub fn disk(u: [Uniform; 2], radius: f64) -> Vec2 {
    let r = radius * u[0].sqrt();
    let phi = TAU * u[1];
    Vec2::new(r * phi.cos(), r * phi.sin())
}

/// Where the parallel ray from a point of the film, in direction `w`, meets the plane through `point` with
/// normal `normal`, as a point of the surface `id`. `origin` is where the film point `centre` lies,
/// `across` and `down` are the sides of one pixel.
#[map]
pub fn parallel_hit(
    film: Vec2,
    centre: Vec2,
    origin: Vec3,
    across: Vec3,
    down: Vec3,
    w: Vec3,
    point: Vec3,
    normal: Vec3,
    id: SurfaceId,
) -> SurfacePoint {
    let o = origin + (film.x - centre.x) * across + (film.y - centre.y) * down;
    let t = normal.dot(point - o) / normal.dot(w);
    require(t > 0.0);
    SurfacePoint::new(o + t * w, id)
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

/// All directions alike that lie in a spherical rectangle: those of the points (x, y, 1) with x and y each between two
/// numbers. With the elevations of the lower and the upper side, the arc tangents of the bounds of y, `d` is the
/// tangent of half of what they differ by, and `m` of their mean, which is not negative. The solid angle between the plane x = 0
/// and a point of the plane y = 0 is sampled from twice `from` on, and is twice `half` in all.
///
/// The first uniform cuts off its share of the solid angle at a plane of constant x, the second divides the arc of the
/// rectangle in that plane, in terms of its height (Archimedes): the steps of Ureña, Fajardo and King ("An
/// Area-Preserving Parametrization for Spherical Rectangles", 2013). With t the tangent of half the solid angle and
/// w = t / (d - m t²), x is n w / √(1 - k² w²), where k = 1 - d m and n² = (1 + m²)(1 + d²).
#[sampler(
    d in 1e-2..=10.0, m in 0.0..=5.0, from in -1.4..=1.4, half in 1e-3..=2.8,
    where from + half <= 1.4, where (from + half).tan() <= 0.99 * d, where from.tan() >= -0.99 * d,
    where d * m <= 0.99
)]
pub fn spherical_rectangle(u: [Uniform; 2], d: f64, m: f64, from: f64, half: f64) -> Direction {
    let t = (from + half * u[0]).tan();
    require(t * t < d * d);
    require(t * t * m * m < 1.0);
    let w = t / (d - m * t * t);
    let k = 1.0 - d * m;
    require(k * w < 1.0);
    require(k * w > -1.0);
    let n = ((1.0 + m * m) * (1.0 + d * d)).sqrt();
    let q = (1.0 - k * k * w * w).sqrt();
    let phi = (n * w).atan2(q);
    // Heights where the plane of this x meets the two sides.
    let high = (d + m) * q / n;
    let low = (m - d) * q / (n * (1.0 + 4.0 * d * m * w * w).sqrt());
    let h = low + u[1] * (high - low);
    let r = (1.0 - h * h).sqrt();
    Direction::new(r * phi.sin(), h, r * phi.cos())
}

/// Uniform on the rectangle, or parallelogram, of all corner + p·a + q·b with p and q in [0, 1].
#[sampler]
pub fn uniform_rectangle(
    u: [Uniform; 2],
    corner: Vec3,
    a: Vec3,
    b: Vec3,
    id: SurfaceId,
) -> SurfacePoint {
    SurfacePoint::new(corner + u[0] * a + u[1] * b, id)
}

#[cfg(test)]
mod instructions;
#[cfg(test)]
mod tests {
    use super::*;
    use aether_core::battery;

    #[test]
    fn squares_of_directions_pass_the_battery_and_have_their_axis_in_the_middle() {
        for width in [1e-3, 0.125, 1.0] {
            battery::check(&square_of_directions(width).unwrap()).assert_ok();
        }
        let middle = square_of_directions(0.125).unwrap().sample([0.5, 0.5]).value();
        assert_eq!((middle.x, middle.y, middle.z), (0.0, 0.0, 1.0));
    }

    #[test]
    fn cylinders_and_parallel_films_pass_the_battery() {
        let axis = Direction::from_vec(Vec3::new(1.0, -2.0, 0.5));
        let base = Vec3::new(0.3, 4.0, -1.0);
        let side = uniform_cylinder(base, Frame::around(axis), 2.5, 0.7, SurfaceId(3));
        battery::check(&side).assert_ok();
        // Uniform: one over the area.
        let p = side.pdf(&side.sample([0.3, 0.6])).value();
        assert!((p * TAU * 0.7 * 2.5 - 1.0).abs() < 1e-12);
        let onto = parallel_hit(
            Vec2::new(32.0, 20.0),
            base,
            Vec3::new(0.1, 0.0, 0.02),
            Vec3::new(0.01, -0.2, 0.0),
            Vec3::new(0.1, 0.2, 0.97),
            Vec3::new(1.0, 2.0, 5.0),
            Vec3::new(0.6, 0.0, -0.8),
            SurfaceId(1),
        );
        battery::check(&film_box(12.5, 40.5).then(onto)).assert_ok();
    }
}
