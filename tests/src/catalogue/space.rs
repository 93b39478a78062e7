//! Space: surfaces and volumes, and manifolds in more dimensions.

use aether_core::prelude::*;

/// Row 47: uniform on a triangle in space, by a square root.
#[sampler]
pub fn triangle(u: [Uniform; 2], a: Vec3, b: Vec3, c: Vec3) -> Surface {
    let s = (1.0 - u[0]).sqrt();
    Surface::from_vec(a + s * (1.0 - u[1]) * (b - a) + s * u[1] * (c - a))
}

/// Row 48: uniform on a triangle in space, with low distortion.
#[sampler]
pub fn triangle_heitz(u: [Uniform; 2], a: Vec3, b: Vec3, c: Vec3) -> Surface {
    let (b1, b2) =
        if u[1] > u[0] { (u[1] - u[0] / 2.0, u[0] / 2.0) } else { (u[1] / 2.0, u[0] - u[1] / 2.0) };
    Surface::from_vec(a + b1 * (b - a) + b2 * (c - a))
}

/// Row 49: uniform on a triangle in space, by a fold; two preimages.
#[sampler]
pub fn triangle_fold(u: [Uniform; 2], a: Vec3, b: Vec3, c: Vec3) -> Surface {
    let (b1, b2) = if u[0] + u[1] <= 1.0 { (u[0], u[1]) } else { (1.0 - u[0], 1.0 - u[1]) };
    Surface::from_vec(a + b1 * (b - a) + b2 * (c - a))
}

/// Row 94: an ellipsoid, uniform before it is scaled.
#[sampler(s1 in 1e-9.., s2 in 1e-9.., s3 in 1e-9..)]
pub fn ellipsoid(u: [Uniform; 2], s1: f64, s2: f64, s3: f64) -> Surface {
    let z = 1.0 - 2.0 * u[0];
    let r = (1.0 - z * z).sqrt();
    let phi = TAU * u[1];
    Surface::new(s1 * r * phi.cos(), s2 * r * phi.sin(), s3 * z)
}

/// Row 96: a torus, uniform in its two angles.
#[sampler(large in 1.0.., small in 1e-6..=1.0)]
pub fn torus(u: [Uniform; 2], large: f64, small: f64) -> Surface {
    let (a, b) = (TAU * u[0], TAU * u[1]);
    let r = large + small * b.cos();
    Surface::new(r * a.cos(), r * a.sin(), small * b.sin())
}

/// Row 103: uniform between two spheres.
#[sampler(a in 0.0.., b in 1e-6.., where a < b)]
pub fn shell(u: [Uniform; 3], a: f64, b: f64) -> Vec3 {
    let r = ((1.0 - u[0]) * a.powi(3) + u[0] * b.powi(3)).cbrt();
    let z = 1.0 - 2.0 * u[1];
    let s = (1.0 - z * z).sqrt();
    let phi = TAU * u[2];
    Vec3::new(r * s * phi.cos(), r * s * phi.sin(), r * z)
}

/// Row 104: uniform in a tetrahedron.
#[sampler]
pub fn tetrahedron(u: [Uniform; 3], a: Vec3, b: Vec3, c: Vec3, d: Vec3) -> Vec3 {
    let r = u[0].cbrt();
    let s = u[1].sqrt();
    a + r * (1.0 - s) * (b - a) + r * s * (1.0 - u[2]) * (c - a) + r * s * u[2] * (d - a)
}

/// Row 105: uniform on the simplex x + y + z = 1.
#[sampler]
pub fn simplex(u: [Uniform; 2]) -> Surface {
    let x = 1.0 - (1.0 - u[0]).sqrt();
    let y = (1.0 - x) * u[1];
    Surface::new(x, y, 1.0 - x - y)
}

/// Row 113: three numbers in ascending order.
#[sampler]
pub fn ordered(u: [Uniform; 3]) -> Vec3 {
    let z0 = (u[0] / (1.0 - u[0])).ln();
    let z1 = (u[1] / (1.0 - u[1])).ln();
    let z2 = (u[2] / (1.0 - u[2])).ln();
    let x1 = z0;
    let x2 = x1 + z1.exp();
    Vec3::new(x1, x2, x2 + z2.exp())
}

/// Row 79: uniform rotations, as unit quaternions.
#[sampler]
pub fn quaternion(u: [Uniform; 3]) -> Embedded<3, 4> {
    let (a, b) = ((1.0 - u[0]).sqrt(), u[0].sqrt());
    let (v, w) = (TAU * u[1], TAU * u[2]);
    Embedded([a * v.sin(), a * v.cos(), b * w.sin(), b * w.cos()])
}

/// Row 114: Cholesky factors of correlation matrices, (l21, l22, l31, l32, l33).
#[sampler]
pub fn correlation_factor(u: [Uniform; 3]) -> Embedded<3, 5> {
    let (a, b, c) = (2.0 * u[0] - 1.0, 2.0 * u[1] - 1.0, 2.0 * u[2] - 1.0);
    Embedded([
        a,
        (1.0 - a * a).sqrt(),
        b,
        c * (1.0 - b * b).sqrt(),
        (1.0 - b * b).sqrt() * (1.0 - c * c).sqrt(),
    ])
}

/// Row 40: a helix.
#[sampler(r in 1e-3.., c in 1e-3.., turns in 1e-3..)]
pub fn helix(u: [Uniform; 1], r: f64, c: f64, turns: f64) -> Curve {
    let t = turns * u[0];
    Curve::new(r * t.cos(), r * t.sin(), c * t)
}

/// Row 95: uniform on the side of a truncated cone.
#[sampler(r0 in 1e-6.., r1 in 0.0.., h in 1e-6..)]
pub fn truncated_cone(u: [Uniform; 2], r0: f64, r1: f64, h: f64) -> Surface {
    let t = u[0] * (r0 + r1) / (r0 + ((1.0 - u[0]) * r0 * r0 + u[0] * r1 * r1).sqrt());
    let r = (1.0 - t) * r0 + t * r1;
    let phi = TAU * u[1];
    Surface::new(r * phi.cos(), r * phi.sin(), h * t)
}

/// Row 97: where a cosine-distributed direction from o meets the plane through p0 with normal n.
#[sampler]
pub fn onto_plane(u: [Uniform; 2], o: Vec3, p0: Vec3, n: Vec3) -> Option<Surface> {
    let r = u[0].sqrt();
    let phi = TAU * u[1];
    let w = Vec3::new(r * phi.cos(), r * phi.sin(), (1.0 - u[0]).sqrt());
    let t = n.dot(p0 - o) / n.dot(w);
    if t > 0.0 { Some(Surface::from_vec(o + t * w)) } else { None }
}

/// Row 98: the near side of a sphere light with radius r at the distance d on the z axis, seen from the
/// origin in a cone with 1 - cos up to m. The cone must not be wider than the sphere.
#[sampler(m in 1e-19..=1.0, d in 1e-9.., r in 1e-9.., where r < d)]
pub fn sphere_light(u: [Uniform; 2], m: f64, d: f64, r: f64) -> Surface {
    let h = m * u[0];
    let s = (h * (2.0 - h)).sqrt();
    let phi = TAU * u[1];
    let z = 1.0 - h;
    let b = d * z;
    let t = (d * d - r * r) / (b + (r * r - d * d * s * s).sqrt());
    Surface::new(t * s * phi.cos(), t * s * phi.sin(), t * z)
}

/// Row 106: a scattering vertex, a free flight of at most d from o in a Henyey-Greenstein direction.
#[sampler(s in 1e-3.., d in 1e-3.., g in 0.001..=0.999)]
pub fn scattering_vertex(u: [Uniform; 3], o: Vec3, s: f64, d: f64, g: f64) -> Vec3 {
    let t = -(u[0] * (-s * d).exp_m1()).ln_1p() / s;
    let f = (1.0 - g * g) / (1.0 - g + 2.0 * g * u[1]);
    let c = (1.0 + g * g - f * f) / (2.0 * g);
    let r = (1.0 - c * c).sqrt();
    let phi = TAU * u[2];
    o + t * Vec3::new(r * phi.cos(), r * phi.sin(), c)
}

/// Row 111: a stick broken into four parts, which add up to 1.
#[sampler]
pub fn stick_breaking(u: [Uniform; 3]) -> Embedded<3, 4> {
    let z1 = 1.0 / (1.0 + 3.0 * (1.0 - u[0]) / u[0]);
    let z2 = 1.0 / (1.0 + 2.0 * (1.0 - u[1]) / u[1]);
    let z3 = u[2];
    let x1 = z1;
    let x2 = z2 * (1.0 - z1);
    let x3 = z3 * (1.0 - z1) * (1.0 - z2);
    Embedded([x1, x2, x3, (1.0 - z1) * (1.0 - z2) * (1.0 - z3)])
}

/// Row 102: a cosine-distributed direction about +z, and a second one about the first, in the frame that
/// turns +z to it the shortest way.
#[sampler]
pub fn chained_frames(u: [Uniform; 4]) -> (Direction, Direction) {
    let (r, phi) = (u[0].sqrt(), TAU * u[1]);
    let (x, y, z) = (r * phi.cos(), r * phi.sin(), (1.0 - u[0]).sqrt());
    let k = 1.0 / (1.0 + z);
    let (s, psi) = (u[2].sqrt(), TAU * u[3]);
    let (a, b, c) = (s * psi.cos(), s * psi.sin(), (1.0 - u[2]).sqrt());
    let first = Vec3::new(x, y, z);
    let right = Vec3::new(1.0 - x * x * k, -x * y * k, -x);
    let up = Vec3::new(-x * y * k, 1.0 - y * y * k, -y);
    (Direction::from_vec(first), Direction::from_vec(a * right + b * up + c * first))
}

/// Row 102 as it is printed: a Henyey-Greenstein direction about +z, and a power cosine about that one.
#[sampler(g in -0.999..=0.999, n in 0.0..=1e4)]
pub fn scattered_twice(u: [Uniform; 4], g: f64, n: f64) -> (Direction, Direction) {
    let f = 1.0 - g + 2.0 * g * u[0];
    let m = 2.0 * (1.0 - g).powi(2) * (1.0 - u[0]) * (1.0 + g * u[0]) / f.powi(2);
    let r = (m * (2.0 - m)).sqrt();
    let phi = TAU * u[1];
    let first = Direction::new(r * phi.cos(), r * phi.sin(), 1.0 - m);
    let c = u[2].powf(1.0 / (n + 1.0));
    let s = (1.0 - c * c).sqrt();
    let psi = TAU * u[3];
    let local = Vec3::new(s * psi.cos(), s * psi.sin(), c);
    (first, Direction::from_vec(Frame::around(first).to_world(local)))
}

/// Row 54 in space: a bilinear patch, which need not be flat.
#[sampler]
pub fn bilinear_patch(u: [Uniform; 2], a: Vec3, b: Vec3, c: Vec3, d: Vec3) -> Surface {
    let (s, t) = (u[0], u[1]);
    Surface::from_vec((1.0 - s) * (1.0 - t) * a + s * (1.0 - t) * b + s * t * c + (1.0 - s) * t * d)
}

/// Row 100: a point of the lens and the direction from it to a point of the plane of focus at distance f.
#[sampler(r in 1e-6..=10.0, f in 1e-3..=1e6)]
pub fn thin_lens(u: [Uniform; 4], r: f64, f: f64, a: f64, b: f64) -> (Vec2, Direction) {
    let s = r * u[0].sqrt();
    let phi = TAU * u[1];
    let (x, y) = (s * phi.cos(), s * phi.sin());
    let focus = Vec3::new(a * (2.0 * u[2] - 1.0), b * (2.0 * u[3] - 1.0), f);
    (Vec2::new(x, y), Direction::from_vec((focus - Vec3::new(x, y, 0.0)).normalize()))
}

/// Row 101: the two points at which a line through an opening meets planes parallel to that, at the heights h and -k.
/// The opening is a triangle with two sides of length a along the axes.
#[sampler(a in 1e-6..=1e6, h in 1e-3..=1e6, k in 1e-3..=1e6)]
pub fn portal_segment(u: [Uniform; 4], a: f64, h: f64, k: f64) -> (Surface, Surface) {
    let s = u[0].sqrt();
    let x = a * Vec3::new(1.0 - s, s * u[1], 0.0);
    let r = u[2].sqrt();
    let phi = TAU * u[3];
    let w = Vec3::new(r * phi.cos(), r * phi.sin(), (1.0 - u[2]).sqrt());
    (Surface::from_vec(x + h / w.z * w), Surface::from_vec(x - k / w.z * w))
}

/// Row 101 between any planes, with uniform directions: that through p with the normal n above the opening, and that through
/// q with the normal m below. A line in the plane of the opening does not pass through it: there is no sample.
#[sampler(a in 1e-6..=1e6)]
pub fn tilted_portal(
    u: [Uniform; 4],
    a: f64,
    p: Vec3,
    n: Direction,
    q: Vec3,
    m: Direction,
) -> (Surface, Surface) {
    let s = u[0].sqrt();
    let x = a * Vec3::new(1.0 - s, s * u[1], 0.0);
    let r = (1.0 - u[2] * u[2]).sqrt();
    let phi = TAU * u[3];
    let w = Vec3::new(r * phi.cos(), r * phi.sin(), u[2]);
    let above = n.dot(p - x) / n.dot(w);
    let below = m.dot(x - q) / m.dot(w);
    require(w.z > 0.0 && above > 0.0 && below > 0.0);
    (Surface::from_vec(x + above * w), Surface::from_vec(x - below * w))
}
