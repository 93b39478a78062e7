//! Samplers with branches: every piece is inverted by itself, the preimages of all pieces add up.

use aether_core::prelude::*;
use tests::batteries;
use tests::catalogue::{SphericalRectangle, spherical_rectangle};
use tests::checks::{right, seen_in_its_plane};

/// A tent over [-r, r].
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
    let left = u[0] < 0.5;
    if left {
        return b * (2.0 * u[0]).ln();
    }
    -b * (2.0 * (1.0 - u[0])).ln()
}

/// The distance of a uniform from the middle.
#[sampler]
pub fn fold(u: [Uniform; 1]) -> f64 {
    (2.0 * u[0] - 1.0).abs()
}

/// Three teeth of a saw.
#[sampler]
pub fn sawtooth(u: [Uniform; 1]) -> f64 {
    (3.0 * u[0]).fract()
}

/// As many teeth as k says.
#[sampler(k in 1.0..=4.0)]
pub fn teeth(u: [Uniform; 1], k: f64) -> f64 {
    (k * u[0]).rem_euclid(1.0)
}

/// Barycentric coordinates by folding the unit square (every point has two preimages).
#[sampler]
pub fn folded_triangle(u: [Uniform; 2]) -> Vec2 {
    let (a, b) = if u[0] + u[1] <= 1.0 { (u[0], u[1]) } else { (1.0 - u[0], 1.0 - u[1]) };
    Vec2::new(a, b)
}

/// Barycentric coordinates by Heitz's map (2019), one preimage.
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
pub fn mixture(u: [Uniform; 2], p: f64) -> Direction {
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

/// The branch is on a parameter.
#[sampler(k in 0.5..=2.0)]
pub fn by_parameter(u: [Uniform; 1], k: f64) -> f64 {
    match k < 1.0 {
        true => u[0] * k,
        false => u[0] * u[0] * k,
    }
}

/// Nested branches with logic: quarters of the unit interval, each with a slope of its own.
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

/// A map with branches: the octant of |x| >= |y| is mirrored at the axis.
#[map]
pub fn kink(x: Vec2) -> Vec2 {
    if x.y > 0.0 { Vec2::new(x.x + x.y, 2.0 * x.y) } else { Vec2::new(x.x, 3.0 * x.y) }
}

#[sampler]
pub fn square(u: [Uniform; 2]) -> Vec2 {
    Vec2::new(2.0 * u[0] - 1.0, 2.0 * u[1] - 1.0)
}

/// The square, kinked.
#[sampler]
pub fn kinked_square(u: [Uniform; 2]) -> Vec2 {
    kink().apply(&square().sample(u))
}

/// The sampler of the rectangle between two corners, and its solid angle.
fn rectangle([x0, y0, x1, y1, z0]: [f64; 5]) -> (SphericalRectangle, f64) {
    let corner = |x, y| Vec3::new(x, y, z0);
    let (a, b, c, d) = (corner(x0, y0), corner(x1, y0), corner(x1, y1), corner(x0, y1));
    let normals = [a.cross(b), b.cross(c), c.cross(d), d.cross(a)].map(Vec3::normalize);
    let angle = |i: usize| (-normals[i].dot(normals[(i + 1) % 4])).acos();
    let omega = (0..4).map(angle).sum::<f64>() - TAU;
    let start = TAU - angle(2) - angle(3);
    (right(spherical_rectangle(normals[0].z, normals[2].z, omega, start, y0, y1, z0)), omega)
}

/// Directions and densities by the printed formulas in 50 digits (mpmath).
#[test]
fn row_71_agrees_with_its_reference() {
    #[rustfmt::skip]
    let reference = [
        ([0.25, -0.375, 1.25, 0.75, -1.0], [0.3125, 0.625], [0.4040685184692668, 0.23116772583516307, -0.885036787322567], 1.8724788985738825),
        ([0.25, -0.375, 1.25, 0.75, -1.0], [0.9375, 0.0625], [0.7338964187374195, -0.19832314961538086, -0.6496645094901102], 1.8724788985738825),
        ([-1.0, -1.0, 1.0, 1.0, -0.5], [0.3125, 0.625], [-0.371666237897833, 0.21990393946548023, -0.9019459324230216], 0.2696013040364513),
        ([-1.0, -1.0, 1.0, 1.0, -0.5], [0.9375, 0.0625], [0.6053722644574204, -0.665277811178073, -0.43695520980966374], 0.2696013040364513),
        ([-2.0, 0.5, -0.25, 3.0, -2.0], [0.3125, 0.625], [-0.4476564966234157, 0.5664943722144248, -0.6918726669555855], 2.6084844440378725),
        ([-2.0, 0.5, -0.25, 3.0, -2.0], [0.9375, 0.0625], [-0.15788066310141669, 0.2762490997109262, -0.948029604562832], 2.6084844440378725),
    ];
    for (corners, u, x, density) in reference {
        let (sampler, _) = rectangle(corners);
        let sample = sampler.sample(u);
        let gap = (sample.value().vec() - Vec3::new(x[0], x[1], x[2])).length();
        assert!(gap < 1e-14, "{corners:?} {u:?}: {:?}, {gap:e} off", sample.value());
        for found in [sample.pdf().value(), sampler.pdf(&sample.value()).value()] {
            let error = (found / density - 1.0).abs();
            assert!(error < 1e-12, "{corners:?} {u:?}: density {found}, {error:e} off");
        }
    }
}

fn assert_rectangles_are_right(all: [[f64; 5]; 2]) {
    for corners in all {
        seen_in_its_plane(&rectangle(corners).0, corners);
    }
}

#[test]
fn row_71_passes_the_battery() {
    assert_rectangles_are_right([[-2.0, 0.5, -0.25, 3.0, -2.0], [0.25, -0.375, 1.25, 0.75, -1.0]]);
}

#[test]
fn row_71_below_and_far_off_passes_the_battery() {
    assert_rectangles_are_right([[-1.0, -1.0, 1.0, 1.0, -0.5], [-0.1, -0.2, 0.2, 0.1, -1.0]]);
}

batteries! { [double single off]
    tents: tent(2.0), tent(0.125);
    laplaces: laplace(0.7), laplace(20.0);
    folds: fold(), sawtooth();
    saws: right(teeth(3.0)), right(teeth(1.75));
    guarded: right(guarded_phase(-0.7)), right(guarded_cone(0.5));
    folded_triangles: folded_triangle();
    heitz_triangles: heitz_triangle();
    concentric_disks: concentric_disk();
    mixtures: right(mixture(0.3)), right(mixture(0.999));
    triangles: right(triangular(-1.0, 0.5, 2.0)), right(triangular(-1.0, -1.0, 2.0)),
        right(triangular(0.0, 3.0, 3.0));
    switched: right(by_parameter(0.75)), right(by_parameter(1.5));
    quarter_slopes: quarters();
    kinked: kinked_square();
}

fn near(found: f64, expected: f64) {
    assert!((found - expected).abs() <= 1e-14 * expected.abs(), "{found:e}, not {expected:e}");
}

#[test]
fn densities_are_those_of_the_textbook() {
    for x in [-1.75f64, -0.3, 0.0, 1.2, 1.999] {
        near(tent(2.0).pdf(&x).value(), (2.0 - x.abs()) / 4.0);
        near(laplace(0.7).pdf(&x).value(), (-x.abs() / 0.7).exp() / 1.4);
    }
    assert_eq!(tent(2.0).pdf(&2.5).value(), 0.0);
    near(fold().pdf(&0.3).value(), 1.0);
    near(concentric_disk().pdf(&Vec2::new(0.3, -0.8)).value(), 1.0 / PI);
    assert_eq!(concentric_disk().pdf(&Vec2::new(0.8, -0.8)).value(), 0.0);
    let w = Direction::new(0.6, 0.0, 0.8);
    near(right(mixture(0.3)).pdf(&w).value(), 0.3 * 0.8 / PI + 0.7 / (2.0 * TAU));
}

#[test]
fn a_seam_counts_once_and_a_fold_twice() {
    // On the border of two pieces: the mode of the tent, the diagonals of the square.
    near(tent(2.0).pdf(&0.0).value(), 0.5);
    near(laplace(1.0).pdf(&0.0).value(), 0.5);
    for s in [0.125, 0.25, 1.0 / 3.0] {
        near(heitz_triangle().pdf(&Vec2::new(s, s)).value(), 2.0);
        near(concentric_disk().pdf(&Vec2::new(s, s)).value(), 1.0 / PI);
        near(concentric_disk().pdf(&Vec2::new(-s, s)).value(), 1.0 / PI);
    }
    near(concentric_disk().pdf(&Vec2::new(0.0, 0.0)).value(), 1.0 / PI);
    assert_eq!(folded_triangle().invert(&Vec2::new(0.3, 0.2)).iter().count(), 2);
    near(folded_triangle().pdf(&Vec2::new(0.3, 0.2)).value(), 2.0);
    assert_eq!(sawtooth().invert(&0.4).iter().count(), 3);
}

#[test]
fn the_ends_of_a_choice_are_its_parts() {
    let w = Direction::new(0.6, 0.0, 0.8);
    near(right(mixture(1.0)).pdf(&w).value(), 0.8 / PI);
    near(right(mixture(0.0)).pdf(&w).value(), 0.5 / TAU);
}

#[test]
fn relations_between_parameters_are_checked() {
    let error = triangular(3.0, 0.5, 2.0).unwrap_err().to_string();
    assert!(error.contains("a <= b"), "{error}");
    assert!(triangular(0.0, 1.0, f64::NAN).is_err());
}

#[test]
fn no_sample_is_a_value_and_its_mass_is_missing() {
    let flight = right(flight_within(2.0, 1.0));
    let escaped = 1.0 - (-2.0f64).exp();
    assert!(!flight.sample([escaped + 1e-9]).is_valid());
    assert!(flight.sample([escaped - 1e-9]).is_valid());
    near(flight.pdf(&0.5).value(), 2.0 * (-1.0f64).exp());
    assert_eq!(flight.pdf(&1.5).value(), 0.0);
    let n = 4096;
    let mass: f64 =
        (0..n).map(|i| flight.pdf(&((f64::from(i) + 0.5) / f64::from(n))).value()).sum();
    assert!((mass / f64::from(n) - escaped).abs() < 1e-7, "{mass}");
}

/// Henyey-Greenstein's phase function as renderers write it: isotropic for small g, and a root that is kept from rounding.
#[sampler(g in -0.99..=0.99)]
pub fn guarded_phase(u: [Uniform; 2], g: f64) -> Direction {
    let c = if g.abs() < 1e-3 {
        1.0 - 2.0 * u[0]
    } else {
        let f = (1.0 - g * g) / (1.0 - g + 2.0 * g * u[0]);
        (1.0 + g * g - f * f) / (2.0 * g)
    };
    let r = (1.0 - c * c).max(0.0).sqrt();
    let phi = TAU * u[1];
    Direction::new(r * phi.cos(), r * phi.sin(), c)
}

/// Directions in a cone, the same way.
#[sampler(cos_max in -1.0..=0.9999)]
pub fn guarded_cone(u: [Uniform; 2], cos_max: f64) -> Direction {
    let c = 1.0 - u[0] + u[0] * cos_max;
    let r = (1.0 - c * c).clamp(0.0, 1.0).sqrt();
    let phi = TAU * u[1];
    Direction::new(r * phi.cos(), r * phi.sin(), c)
}

/// A guard against rounding is no branch: there is one preimage, and the density is the textbook's.
#[test]
fn roots_that_are_kept_from_rounding() {
    assert_eq!(GuardedCone::<f64>::DERIVATION.preimages, 1);
    for g in [-0.9, -0.3, 5e-4, 0.5, 0.95] {
        let phase = right(guarded_phase(g));
        let g: f64 = if g.abs() < 1e-3 { 0.0 } else { g };
        for u in [[0.0, 0.3], [0.2, 0.9], [0.7, 0.1], [1.0 - f64::EPSILON, 0.5]] {
            let w = phase.sample(u);
            let denominator = (1.0 + g * g - 2.0 * g * w.z).powf(1.5);
            let by_hand = (1.0 - g * g) / (4.0 * PI * denominator);
            assert!((phase.pdf(&w).value() / by_hand - 1.0).abs() < 1e-13, "{g} {u:?}");
        }
    }
    let cone = right(guarded_cone(0.5));
    assert!((cone.pdf(&cone.sample([0.3, 0.6])).value() * PI - 1.0).abs() < 1e-14);
    assert_eq!(cone.pdf(&Direction::new(0.0, 0.0, -1.0)).value(), 0.0);
}

/// At the foot of a tent a point is rounded by more than its distance from the foot, but its uniforms
/// know where it is.
#[test]
fn samples_know_their_density_where_the_point_is_rounded() {
    let near = |a: f64, b: f64| assert!((a - b).abs() <= 1e-14 * b, "{a} is not {b}");
    let tent = tent(1.0);
    for u in [1e-30, 1e-12, 0.25, 1.0 - 1e-12, 1.0 - f64::EPSILON / 2.0] {
        near(tent.sample([u]).pdf().value(), (2.0 * u.min(1.0 - u)).sqrt());
    }
    for u in [[0.1, 0.2], [0.9, 0.3], [1e-20, 0.5]] {
        near(folded_triangle().sample(u).pdf().value(), 2.0);
    }
}
