//! The rows of the catalogue whose points lie on a manifold, or are several at once: the whole battery, with mass and samples over
//! parametrisations of these spaces by hand, which know nothing of how the points are sampled. Most reach beyond the
//! support, where the density is zero.

use aether_core::prelude::*;
use core::f64::consts::{PI, TAU};
use tests::batteries;
use tests::catalogue::*;
use tests::checks::{covered, covered_by, right};
use tests::points::{corners, patch};

type V = Vec3<f64>;

fn v(x: f64, y: f64, z: f64) -> V {
    Vec3::new(x, y, z)
}

fn at(x: &[f64]) -> V {
    v(x[0], x[1], x[2])
}

/// The unit vector with these shares of the angle from the pole and of a turn.
fn sphere(t: &[f64]) -> V {
    let (theta, phi) = (PI * t[0], TAU * t[1]);
    v(theta.sin() * phi.cos(), theta.sin() * phi.sin(), theta.cos())
}

/// These shares of a vector, of any length.
fn angles(w: V) -> Vec<f64> {
    vec![w.x.hypot(w.y).atan2(w.z) / PI, turn(w.y, w.x)]
}

/// The angle of (x, y) as a share of a turn.
fn turn(y: f64, x: f64) -> f64 {
    y.atan2(x).rem_euclid(TAU) / TAU
}

/// All numbers.
fn wide(t: f64) -> f64 {
    (t - 0.5) / (t * (1.0 - t))
}

/// The t of `wide`, by the root that does not cancel.
fn narrow(x: f64) -> f64 {
    0.5 + 0.5 * x / (1.0 + (1.0 + x * x).sqrt())
}

/// More than [0, 1].
fn beyond(t: f64) -> f64 {
    1.1 * t - 0.05
}

fn within(x: f64) -> f64 {
    (x + 0.05) / 1.1
}

/// A plane by coordinates along two vectors.
struct Plane {
    origin: V,
    along: V,
    up: V,
}

impl Plane {
    fn point(&self, s: f64, t: f64) -> V {
        self.origin + s * self.along + t * self.up
    }

    fn coordinates(&self, x: V) -> [f64; 2] {
        let (d, normal) = (x - self.origin, self.along.cross(self.up));
        let area = normal.dot(normal);
        [d.cross(self.up).dot(normal) / area, self.along.cross(d).dot(normal) / area]
    }

    /// The plane through a point, with perpendicular axes of unit length.
    fn through(origin: V, normal: V) -> Plane {
        let along = v(normal.y, -normal.x, 0.0).normalize();
        Plane { origin, along, up: normal.normalize().cross(along) }
    }
}

/// A triangle by lines that are parallel to a side.
fn on_triangle<S: Sampler<f64, Point = Surface>>(sampler: S, [a, b, c]: [V; 3]) {
    let plane = Plane { origin: a, along: b - a, up: c - a };
    covered(
        sampler,
        |t| Surface::from_vec(plane.point(t[0] * (1.0 - t[1]), t[0] * t[1])),
        |x| {
            let [s, t] = plane.coordinates(at(x));
            vec![s + t, t / (s + t)]
        },
    );
}

#[test]
fn row_47_triangle() {
    let [a, b, c, _] = corners();
    on_triangle(triangle(a, b, c), [a, b, c]);
}

#[test]
fn row_48_triangle_heitz() {
    let [a, b, c, _] = corners();
    on_triangle(triangle_heitz(a, b, c), [a, b, c]);
}

#[test]
fn row_49_triangle_fold() {
    let [a, b, c, _] = corners();
    on_triangle(triangle_fold(a, b, c), [a, b, c]);
}

#[test]
fn row_40_helix() {
    covered(
        right(helix(1.5, 0.25, 20.0)),
        |t| {
            let angle = 24.0 * t[0] - 2.0;
            Curve::new(1.5 * angle.cos(), 1.5 * angle.sin(), 0.25 * angle)
        },
        |x| vec![(4.0 * x[2] + 2.0) / 24.0],
    );
}

/// The patch by planes across: those with the same x, from one side to the other, and beyond the ends.
#[test]
fn row_54_bilinear_patch() {
    // x = 2s - t/4 + 3st/4, y = s/4 + t + st/2, z = s/2 + 3t/4 - 3st/2.
    let across = |x: f64, t: f64| (x + 0.25 * t) / (2.0 + 0.75 * t);
    let sides = |x: f64| {
        // Where the plane enters and leaves the patch, in terms of t, as 0 <= s <= 1.
        let (low, high) = ((-4.0 * x).max(2.0 * x - 4.0), 1.0_f64);
        (low.max(0.0), high)
    };
    covered(
        patch(),
        |t| {
            let x = 2.75 * t[0] - 0.25;
            let (low, high) = sides(x);
            let t = low + (high - low) * t[1];
            let s = across(x, t);
            Surface::new(x, 0.25 * s + t + 0.5 * s * t, 0.5 * s + 0.75 * t - 1.5 * s * t)
        },
        |p| {
            // y tells t: (x + t/4) (1/4 + t/2) / (2 + 3t/4) + t, which rises.
            let (mut below, mut above) = (0.0, 1.0);
            for _ in 0..60 {
                let t = 0.5 * (below + above);
                let s = across(p[0], t);
                if 0.25 * s + t + 0.5 * s * t < p[1] { below = t } else { above = t }
            }
            let (low, high) = sides(p[0]);
            vec![(p[0] + 0.25) / 2.75, (below - low) / (high - low)]
        },
    );
}

#[test]
fn row_79_quaternion() {
    covered(
        quaternion(),
        |t| {
            let (sine, cosine) = (PI * t[0]).sin_cos();
            let rest = sine * sphere(&t[1..]);
            Embedded([cosine, rest.x, rest.y, rest.z])
        },
        |x| {
            let rest = at(&x[1..]);
            [vec![rest.length().atan2(x[0]) / PI], angles(rest)].concat()
        },
    );
}

#[test]
fn row_94_ellipsoid() {
    covered(
        right(ellipsoid(2.0, 1.0, 0.5)),
        |t| {
            let w = sphere(t);
            Surface::new(2.0 * w.x, w.y, 0.5 * w.z)
        },
        |x| angles(v(0.5 * x[0], x[1], 2.0 * x[2])),
    );
}

#[test]
fn row_95_truncated_cone() {
    covered(
        right(truncated_cone(1.0, 0.25, 2.0)),
        |t| {
            let (z, phi) = (2.0 * beyond(t[0]), TAU * t[1]);
            let r = 1.0 - 0.375 * z;
            Surface::new(r * phi.cos(), r * phi.sin(), z)
        },
        |x| vec![within(0.5 * x[2]), turn(x[1], x[0])],
    );
}

#[test]
fn row_96_torus() {
    covered(
        right(torus(2.0, 0.5)),
        |t| {
            let (a, b) = (TAU * t[0], TAU * t[1]);
            let r = 2.0 + 0.5 * b.cos();
            Surface::new(r * a.cos(), r * a.sin(), 0.5 * b.sin())
        },
        |x| vec![turn(x[1], x[0]), turn(x[2], x[0].hypot(x[1]) - 2.0)],
    );
}

/// The whole plane, about the foot of its perpendicular. Some directions do not meet it, and samples have to say how many.
#[test]
fn row_97_onto_plane() {
    let [o, n, _, p] = corners();
    let foot = o + n.dot(p - o) / n.dot(n) * n;
    let plane = Plane::through(foot, n);
    covered_by(
        onto_plane(o, p, n),
        [200_000, 200_000],
        |t| Surface::from_vec(plane.point(wide(t[0]), wide(t[1]))),
        |x| plane.coordinates(at(x)).map(narrow).to_vec(),
    );
}

#[test]
fn row_98_sphere_light() {
    covered(
        right(sphere_light(0.1875, 1.25, 0.75)),
        |t| Surface::from_vec(v(0.0, 0.0, 1.25) + 0.75 * sphere(t)),
        |x| angles(at(x) - v(0.0, 0.0, 1.25)),
    );
}

/// The lens by radius and azimuth, and the plane of focus by its coordinates.
#[test]
fn row_100_thin_lens() {
    covered(
        right(thin_lens(0.5, 2.0, 0.8, 0.6)),
        |t| {
            let (r, phi) = (0.5 * t[0], TAU * t[1]);
            let focus = v(1.6 * t[2] - 0.8, 1.2 * t[3] - 0.6, 2.0);
            let lens = v(r * phi.cos(), r * phi.sin(), 0.0);
            (Vec2::new(lens.x, lens.y), Direction::from_vec((focus - lens).normalize()))
        },
        |x| {
            let focus = [0, 1].map(|i| x[i] + 2.0 * x[2 + i] / x[4]);
            let lens = [2.0 * x[0].hypot(x[1]), turn(x[1], x[0])];
            vec![lens[0], lens[1], (focus[0] + 0.8) / 1.6, (focus[1] + 0.6) / 1.2]
        },
    );
}

/// The point of a triangular opening with two sides of length `a` along the axes, and the other way round.
fn opening(a: f64, t: &[f64]) -> V {
    v(a * t[0], a * (1.0 - t[0]) * t[1], 0.0)
}

/// The place of a line through the opening, from what it has there and from its slope.
fn place_of_line(a: f64, x: &[f64]) -> Vec<f64> {
    let (first, second) = (at(x), at(&x[3..]));
    let w = first - second;
    let hole = second - second.z / w.z * w;
    let polar = angles(w);
    vec![hole.x / a, hole.y / (a - hole.x), 2.0 * polar[0], polar[1]]
}

fn line(t: &[f64]) -> V {
    sphere(&[0.5 * t[0], t[1]])
}

/// Where the line passes the opening, and its angles.
#[test]
fn row_101_portal_segment() {
    covered(
        right(portal_segment(1.5, 2.0, 1.0)),
        |t| {
            let (o, w) = (opening(1.5, t), line(&t[2..]));
            let [first, second] = [2.0, -1.0].map(|z| Surface::from_vec(o + z / w.z * w));
            (first, second)
        },
        |x| place_of_line(1.5, x),
    );
}

/// The same with planes that are tilted about the y axis: lines that meet both are those with some azimuths about it, and
/// samples have to say how many there are.
#[test]
fn row_101_tilted_portal() {
    let planes = [(v(0.5, 0.25, 3.0), v(0.6, 0.0, 0.8)), (v(1.0, -0.5, -2.0), v(-0.28, 0.0, 0.96))];
    let [(p, n), (q, m)] = planes.map(|(p, n)| (p, Direction::from_vec(n)));
    let (least, most) = (0.28_f64.atan2(0.96), PI - 0.6_f64.atan2(0.8));
    covered_by(
        right(tilted_portal(2.0, p, n, q, m)),
        [400_000, 200_000],
        |t| {
            let (o, theta) = (opening(2.0, t), PI * t[2]);
            let azimuth = least + (most - least) * t[3];
            let across = theta.sin();
            let w = v(across * azimuth.cos(), theta.cos(), across * azimuth.sin());
            let [first, second] =
                planes.map(|(p, n)| Surface::from_vec(o + n.dot(p - o) / n.dot(w) * w));
            (first, second)
        },
        |x| {
            let (hole, w) = (place_of_line(2.0, x), at(x) - at(&x[3..]));
            let azimuth = w.z.atan2(w.x);
            let polar = w.x.hypot(w.z).atan2(w.y) / PI;
            vec![hole[0], hole[1], polar, (azimuth - least) / (most - least)]
        },
    );
}

/// A direction by its angles, and a second one by those in a frame about the first.
fn scattered<S: Sampler<f64, Point = (Direction, Direction)>>(sampler: S) {
    let frame = |w: V| {
        let across = w.cross(v(1.0, 0.0, 0.0)).normalize();
        [across, w.cross(across), w]
    };
    covered_by(
        sampler,
        [40_000, 400_000],
        |t| {
            let first = sphere(t);
            let ([a, b, c], local) = (frame(first), sphere(&[0.55 * t[2], t[3]]));
            let second = local.x * a + local.y * b + local.z * c;
            (Direction::from_vec(first), Direction::from_vec(second))
        },
        |x| {
            let (first, second) = (at(x), at(&x[3..]));
            let local = frame(first).map(|axis| axis.dot(second));
            let [polar, azimuth] = [0, 1].map(|i| angles(at(&local))[i]);
            [angles(first), vec![polar / 0.55, azimuth]].concat()
        },
    );
}

#[test]
fn row_102_chained_frames() {
    scattered(chained_frames());
}

#[test]
fn row_102_scattered_twice() {
    scattered(right(scattered_twice(0.25, 2.0)));
}

#[test]
fn row_105_simplex() {
    on_triangle(simplex(), [v(1.0, 0.0, 0.0), v(0.0, 1.0, 0.0), v(0.0, 0.0, 1.0)]);
}

/// What is left of the stick after each piece, as a share of what was left before.
#[test]
fn row_111_stick_breaking() {
    covered(
        stick_breaking(),
        |t| {
            let (a, b, c) = (t[0], t[0] * t[1], t[0] * t[1] * t[2]);
            Embedded([1.0 - a, a - b, b - c, c])
        },
        |x| {
            let b = x[2] + x[3];
            let a = x[1] + b;
            vec![a, b / a, x[3] / b]
        },
    );
}

/// Heavy tails are integrated over numbers in order that are spread as widely.
#[test]
fn row_113_ordered() {
    let root = |gap: f64| {
        let root = gap.sqrt();
        root / (1.0 + root)
    };
    covered(
        ordered(),
        |t| {
            let gap = |t: f64| (t / (1.0 - t)).powi(2);
            let low = 2.0 * (t[0] / (1.0 - t[0])).ln();
            Vec3::new(low, low + gap(t[1]), low + gap(t[1]) + gap(t[2]))
        },
        |x| vec![1.0 / (1.0 + (-0.5 * x[0]).exp()), root(x[1] - x[0]), root(x[2] - x[1])],
    );
}

#[test]
fn row_114_correlation_factor() {
    covered(
        correlation_factor(),
        |t| {
            let [a, b, c] = [0, 1, 2].map(|i| (PI * t[i]).sin_cos());
            Embedded([a.1, a.0, b.1, c.1 * b.0, c.0 * b.0])
        },
        |x| vec![x[1].atan2(x[0]) / PI, x[4].hypot(x[3]).atan2(x[2]) / PI, x[4].atan2(x[3]) / PI],
    );
}

// Polygons, whose densities look at all their triangles. Seeds are fixed; one in a million would make a right sampler fail.
batteries! { [double single]
    row_52_pentagon: pentagon();
    row_52_regular_polygon: right(regular_polygon(3.0)), right(regular_polygon(8.0));
}
