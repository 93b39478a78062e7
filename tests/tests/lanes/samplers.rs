//! Samplers and maps of every kind that the language knows.

use aether_core::prelude::*;

/// A tent over [-r, r]: two pieces that meet.
#[sampler]
pub fn tent(u: [Uniform; 1], r: f64) -> f64 {
    if u[0] < 0.5 {
        r * ((2.0 * u[0]).sqrt() - 1.0)
    } else {
        r * (1.0 - (2.0 * (1.0 - u[0])).sqrt())
    }
}

/// Laplace's distribution with scale b.
#[sampler]
pub fn laplace(u: [Uniform; 1], b: f64) -> f64 {
    if u[0] < 0.5 {
        return b * (2.0 * u[0]).ln();
    }
    -b * (2.0 * (1.0 - u[0])).ln()
}

/// The distance of a uniform from the middle: two preimages.
#[sampler]
pub fn fold(u: [Uniform; 1]) -> f64 {
    (2.0 * u[0] - 1.0).abs()
}

/// Three teeth of a saw.
#[sampler]
pub fn sawtooth(u: [Uniform; 1]) -> f64 {
    (3.0 * u[0]).fract()
}

/// A wave: two preimages in closed form.
#[sampler]
pub fn sine_wave(u: [Uniform; 1]) -> f64 {
    (TAU * u[0]).sin()
}

/// Barycentric coordinates by folding the unit square.
#[sampler]
pub fn folded_triangle(u: [Uniform; 2]) -> Vec2 {
    let (a, b) = if u[0] + u[1] <= 1.0 { (u[0], u[1]) } else { (1.0 - u[0], 1.0 - u[1]) };
    Vec2::new(a, b)
}

/// Barycentric coordinates by Heitz's map (2019).
#[sampler]
pub fn heitz_triangle(u: [Uniform; 2]) -> Vec2 {
    if u[1] > u[0] {
        Vec2::new(u[0] / 2.0, u[1] - u[0] / 2.0)
    } else {
        Vec2::new(u[0] - u[1] / 2.0, u[1] / 2.0)
    }
}

/// The concentric map of Shirley and Chiu (1997).
#[sampler]
pub fn concentric_disk(u: [Uniform; 2]) -> Vec2 {
    let (a, b) = (2.0 * u[0] - 1.0, 2.0 * u[1] - 1.0);
    let (r, theta) = if a.abs() > b.abs() {
        (a, PI / 4.0 * (b / a))
    } else {
        (b, PI / 2.0 - PI / 4.0 * (a / b))
    };
    Vec2::new(r * theta.cos(), r * theta.sin())
}

/// A cosine lobe and a uniform sphere, mixed by one uniform that is used again.
#[sampler(p in 0.0..=1.0)]
pub fn lobe_and_sphere(u: [Uniform; 2], p: f64) -> Direction {
    let phi = TAU * u[1];
    if u[0] < p {
        let v = u[0] / p;
        let r = v.sqrt();
        Direction::new(r * phi.cos(), r * phi.sin(), (1.0 - v).sqrt())
    } else {
        let v = (u[0] - p) / (1.0 - p);
        let z = 1.0 - 2.0 * v;
        let r = (1.0 - z * z).sqrt();
        Direction::new(r * phi.cos(), r * phi.sin(), z)
    }
}

/// A triangle over [a, c] with its mode at b.
#[sampler(where a <= b, where b <= c, where a < c)]
pub fn triangular(u: [Uniform; 1], a: f64, b: f64, c: f64) -> f64 {
    if u[0] * (c - a) < b - a {
        a + (u[0] * (c - a) * (b - a)).sqrt()
    } else {
        c - ((1.0 - u[0]) * (c - a) * (c - b)).sqrt()
    }
}

/// Quarters of the unit interval, each with a slope of its own.
#[sampler]
pub fn quarters(u: [Uniform; 1]) -> f64 {
    let x = u[0];
    if x < 0.25 || !(x < 0.75) {
        if x < 0.5 { 4.0 * x } else { 1.0 + 8.0 * (x - 0.75) }
    } else if x >= 0.25 && x < 0.5 {
        -2.0 * (x - 0.25)
    } else {
        -0.5 - 6.0 * (x - 0.5)
    }
}

/// Free flight through a slab: no sample beyond the depth d.
#[sampler(s in 0.01..=100.0, d in 0.01..=100.0)]
pub fn flight_within(u: [Uniform; 1], s: f64, d: f64) -> Option<f64> {
    let t = -(-u[0]).ln_1p() / s;
    if t < d { Some(t) } else { None }
}

/// A map with branches.
#[map]
pub fn kink(x: Vec2) -> Vec2 {
    if x.y > 0.0 { Vec2::new(x.x + x.y, 2.0 * x.y) } else { Vec2::new(x.x, 3.0 * x.y) }
}

/// A square about the origin.
#[sampler]
pub fn square(u: [Uniform; 2]) -> Vec2 {
    Vec2::new(2.0 * u[0] - 1.0, 2.0 * u[1] - 1.0)
}

/// The square, kinked.
#[sampler]
pub fn kinked_square(u: [Uniform; 2]) -> Vec2 {
    kink().apply(&square().sample(u))
}

/// A box anywhere.
#[sampler]
pub fn parallelepiped(u: [Uniform; 3], m: Mat3, t: Vec3) -> Vec3 {
    t + m * Vec3::new(u[0], u[1], u[2])
}

/// Uniform on a triangle in space: membership is tested.
#[sampler]
pub fn triangle(u: [Uniform; 2], a: Vec3, b: Vec3, c: Vec3) -> Surface {
    let s = u[0].sqrt();
    Surface::from_vec(a + s * (1.0 - u[1]) * (b - a) + s * u[1] * (c - a))
}

/// Uniform on a parallelogram that is known by its identity.
#[sampler]
pub fn panel(u: [Uniform; 2], corner: Vec3, right: Vec3, up: Vec3, id: SurfaceId) -> SurfacePoint {
    SurfacePoint::new(corner + u[0] * right + u[1] * up, id)
}

/// A pair of normal variables by the method of Box and Muller.
#[sampler]
pub fn box_muller(u: [Uniform; 2]) -> Vec2 {
    let r = (-2.0 * (1.0 - u[0]).ln()).sqrt();
    let phi = TAU * u[1];
    Vec2::new(r * phi.cos(), r * phi.sin())
}

/// A logistic variable with tails that Lambert's W undoes.
#[sampler(h in 0.0..=10.0)]
pub fn lambert_tail(u: [Uniform; 1], h: f64) -> f64 {
    let z = u[0].ln() - (-u[0]).ln_1p();
    z * (0.5 * h * z * z).exp()
}

/// A scale that is a gamma function of the parameter.
#[sampler(k in 0.1..=10.0)]
pub fn gamma_scale(u: [Uniform; 1], k: f64) -> f64 {
    u[0] * ln_gamma(k + 3.0).exp()
}

/// Cauchy's distribution by the cotangent.
#[sampler(g in 1e-3..)]
pub fn cauchy(u: [Uniform; 1], g: f64) -> f64 {
    -g / (PI * u[0]).tan()
}

/// Hyperbolic functions and their inverses.
#[sampler(a in 0.1..=2.0)]
pub fn sinh_arcsine(u: [Uniform; 1], a: f64) -> f64 {
    (a * (2.0 * u[0] - 1.0)).sinh()
}

/// A sum of increasing functions: only the inverse is numerical.
#[sampler(k in 0.0..=100.0)]
pub fn quintic(u: [Uniform; 1], k: f64) -> f64 {
    u[0] + k * u[0].powi(5) + u[0].ln_1p()
}

/// A distance and a direction that is the narrower the farther away.
#[sampler]
pub fn narrowing(u: [Uniform; 3], s: f64) -> (f64, Direction) {
    let t = -(-u[0]).ln_1p() / s;
    let z = u[1].powf(1.0 / (2.0 + t));
    let r = (1.0 - z * z).sqrt();
    let phi = TAU * u[2];
    (t, Direction::new(r * phi.cos(), r * phi.sin(), z))
}

/// A direction given in a frame, in world coordinates.
#[map]
pub fn rotate(w: Direction, frame: Frame) -> Direction {
    Direction::from_vec(frame.to_world(w))
}

/// Where a direction meets the plane at height zero, from above.
#[map]
pub fn to_floor(w: Direction, eye: Vec3) -> Vec2 {
    let t = -eye.z / w.z;
    require(t > 0.0);
    Vec2::new(eye.x + t * w.x, eye.y + t * w.y)
}

/// The points of the floor that a lobe illuminates.
#[sampler]
pub fn spot(u: [Uniform; 2], n: f64, frame: Frame, eye: Vec3) -> Vec2 {
    let local = tests::catalogue::power_cosine(n).sample(u);
    let world = rotate(frame).apply(&local);
    to_floor(eye).apply(&world)
}
