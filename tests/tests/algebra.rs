//! Samplers that need most of the functions of the language, against reference values and through
//! the check battery. The number behind each name is the one in `reference/algebra.txt`.

use aether_core::prelude::*;
use aether_core::{Uniforms, battery};
use tests::batteries;
use tests::catalogue::*;
use tests::checks::right;

/// What has no value beyond the last uniform that stays is no sample; it is not filled in from before it, as 0/0 at one
/// uniform is.
#[test]
fn row_29_leaves_from_the_first_uniform_on() {
    let last = -(-2f64).exp_m1();
    let flight = right(falling_extinction(1.0, 0.5));
    for beyond in [1e-15, 1e-13, 1e-8, 1e-3] {
        let (stays, is_sample) = flight.forward([last - beyond]);
        assert!(is_sample && stays > 0.0 && stays < 75.0, "{beyond:e}: {stays}");
        let escapes = flight.sample([last + beyond]);
        assert!(!escapes.is_valid() && escapes.pdf().value() == 0.0, "{beyond:e}: {escapes:?}");
    }
    let flight = right(falling_extinction(1.0f32, 0.5));
    for beyond in [3e-7, 3e-6, 1e-4] {
        let escapes = flight.sample([last as f32 + beyond]);
        assert!(!escapes.is_valid() && escapes.pdf().value() == 0.0, "{beyond:e}: {escapes:?}");
    }
}

/// 17 digits of the catalogue at an extreme point, and the closed form elsewhere.
#[test]
fn row_108_has_the_density_of_its_angle() {
    let narrow = right(small_angles(1e-8, 0.01));
    let sample = narrow.sample([0.01, 0.6]);
    for found in [sample.pdf().value(), narrow.pdf(&sample).value()] {
        assert!((found / 87_388_280_207_248.14 - 1.0).abs() < 1e-12, "{found:e}");
    }
    let wide = right(small_angles(0.125, 1.0));
    for i in 0..400 {
        let u = [f64::from(i % 20) / 20.0, f64::from(i / 20) / 20.0];
        let sample = wide.sample(u);
        let theta = 0.125 * 8.0_f64.powf(u[0]);
        let truth = 1.0 / (TAU * 8.0_f64.ln() * theta * theta.sin());
        for found in [sample.pdf().value(), wide.pdf(&sample).value()] {
            assert!((found / truth - 1.0).abs() < 1e-12, "{u:?}: {found:e}, expected {truth:e}");
        }
    }
    assert_eq!(narrow.pdf(&Direction::new(0.02, 0.0, 1.0)).value(), 0.0);
    assert!(small_angles(0.5, 0.25).is_err());
}

/// The solid angle of a spherical triangle by the formula of Van Oosterom and Strackee (1983).
fn solid_angle([a, b, c]: [Vec3; 3]) -> f64 {
    2.0 * a.dot(b.cross(c)).abs().atan2(1.0 + a.dot(b) + b.dot(c) + c.dot(a))
}

/// The density is one over the solid angle, and zero outside. The uniforms are areas: the arc from b through the point
/// cuts off the first one's share of the triangle, and |b - x|² is the second one's share of that of the end of the arc.
#[test]
fn row_70_is_uniform_in_its_triangle() {
    let v = Vec3::new;
    for corners in [
        [v(1.0, 0.0, 0.25), v(0.25, 1.0, 0.5), v(-0.25, 0.125, 1.0)],
        [v(1.0, 0.0, 0.0), v(0.0, 1.0, 0.0), v(0.0, 0.0, 1.0)],
        [v(1.0, 0.0, 1.0), v(-1.0, 1.0, 0.125), v(-1.0, -1.0, 0.125)],
    ] {
        let [a, b, c] = corners.map(Vec3::normalize);
        let omega = solid_angle([a, b, c]);
        let ca = a.cross(b).normalize().dot(a.cross(c).normalize());
        let n = (c - c.dot(a) * a).normalize();
        let [u, v, w] = [a, b, n].map(Direction::from_vec);
        let sa = (1.0 - ca * ca).sqrt();
        let triangle = right(spherical_triangle(ca, sa, a.dot(b), omega, ca.acos(), u, v, w));
        for i in 0..400 {
            let u = [(f64::from(i % 20) + 0.5) / 20.0, (f64::from(i / 20) + 0.5) / 20.0];
            let sample = triangle.sample(u);
            let x = sample.value().vec();
            let end = b.cross(x).cross(c.cross(a)).normalize();
            let end = if end.dot(a + c) < 0.0 { -end } else { end };
            let share = solid_angle([a, b, end]) / omega;
            let along = (b - x).dot(b - x) / (b - end).dot(b - end);
            assert!((share - u[0]).abs() + (along - u[1]).abs() < 1e-12, "{u:?}: {share}, {along}");
            for found in [sample.pdf().value(), triangle.pdf(&sample).value()] {
                assert!((found * omega - 1.0).abs() < 2e-12, "{u:?}: {found:e} for {omega}");
            }
            // Beyond a side, and on the other side of the sphere.
            for outside in [-x, x - 2.0 * x.dot(b.cross(a).normalize()) * b.cross(a).normalize()] {
                assert_eq!(triangle.pdf(&Direction::from_vec(outside)).value(), 0.0, "{u:?}");
            }
        }
    }
}

/// Roughness and view: usual, grazing and nearly along the normal.
fn views() -> [(f64, Direction); 3] {
    let views = [(0.4, [0.6, 0.2, 0.7]), (0.05, [0.6, 0.2, 0.1]), (0.9, [0.01, 0.02, 1.0])];
    views.map(|(alpha, [x, y, z])| (alpha, Direction::new(x, y, z)))
}

/// Visible normals by spherical caps, as Dupuy and Benyoub (2023) print them: the half vector has no unit length yet when
/// it is unstretched, and its height is (1 - u) (1 + v.z) - v.z.
#[sampler(alpha_x in 1e-4..=1.0, alpha_y in 1e-4..=1.0, where w.z > 0.0)]
fn normals_by_caps(u: [Uniform; 2], alpha_x: f64, alpha_y: f64, w: Direction) -> Direction {
    let v = Vec3::new(w.x * alpha_x, w.y * alpha_y, w.z).normalize();
    let phi = TAU * u[0];
    let z = (1.0 - u[1]).mul_add(1.0 + v.z, -v.z);
    let sine = (1.0 - z * z).clamp(0.0, 1.0).sqrt();
    let h = Vec3::new(sine * phi.cos(), sine * phi.sin(), z) + v;
    Direction::from_vec(Vec3::new(h.x * alpha_x, h.y * alpha_y, h.z).normalize())
}

/// The same for one roughness.
#[sampler(alpha in 1e-4..=1.0, where w.z > 0.0)]
fn round_normals_by_caps(u: [Uniform; 2], alpha: f64, w: Direction) -> Direction {
    let v = Vec3::new(w.x * alpha, w.y * alpha, w.z).normalize();
    let phi = TAU * u[0];
    let z = (1.0 - u[1]) * (1.0 + v.z) - v.z;
    let sine = (1.0 - z * z).sqrt();
    let h = Vec3::new(sine * phi.cos(), sine * phi.sin(), z) + v;
    Direction::from_vec(Vec3::new(h.x * alpha, h.y * alpha, h.z).normalize())
}

#[test]
fn visible_normals_pass_the_battery_as_they_are_printed() {
    for (alpha, w) in views() {
        battery::check(&right(visible_normals_as_printed(alpha, w))).assert_ok();
        battery::check(&right(normals_by_caps(alpha, 0.5 * alpha, w))).assert_ok();
        battery::check(&right(round_normals_by_caps(alpha, w))).assert_ok();
    }
}

/// D(h) max(0, w · h) / (w.z Λ-term), the density of visible normals in closed form.
#[test]
fn visible_normals_have_their_density() {
    for (alpha, w) in views() {
        has_the_density_of_visible_normals(
            right(visible_normals_as_printed(alpha, w)),
            [alpha; 2],
            w,
        );
        has_the_density_of_visible_normals(right(round_normals_by_caps(alpha, w)), [alpha; 2], w);
        let other = 0.5 * alpha;
        let caps = right(normals_by_caps(alpha, other, w));
        has_the_density_of_visible_normals(caps, [alpha, other], w);
    }
}

fn has_the_density_of_visible_normals<S>(normals: S, [ax, ay]: [f64; 2], w: Direction)
where
    S: Sampler<f64, Uniforms = [f64; 2], Point = Direction>,
{
    let stretched = (ax * w.x).powi(2) + (ay * w.y).powi(2) + w.z * w.z;
    let seen = 0.5 * (w.z + stretched.sqrt());
    for i in 0..400 {
        let u = [(i % 20) as f64 / 20.0 + 0.025, (i / 20) as f64 / 20.0 + 0.025];
        let sample = normals.sample(u);
        let h = sample.value();
        let slope = (h.x / ax).powi(2) + (h.y / ay).powi(2) + h.z * h.z;
        let truth = h.dot(w).max(0.0) / (PI * ax * ay * slope * slope) / seen;
        for found in [sample.pdf().value(), normals.pdf(&sample).value()] {
            assert!((found / truth - 1.0).abs() < 1e-12, "{found:e}, expected {truth:e}");
        }
        let below = Direction::new(h.x, h.y, -h.z - 0.1);
        assert_eq!(normals.pdf(&below).value(), 0.0);
    }
}

/// The sample, its own density, and the density at `x`.
fn values<S: Sampler<f64, Point = f64>>(s: &S, u: f64, x: f64) -> [f64; 3] {
    let sample = s.sample(S::Uniforms::from_fn(|_| u));
    [sample.value(), sample.pdf().value(), s.pdf(&x).value()]
}

fn row(number: u32, p: &[f64], u: f64, x: f64) -> [f64; 3] {
    match number {
        9 => values(&epanechnikov(), u, x),
        10 => values(&right(logistic(p[0])), u, x),
        11 => values(&right(truncated_logistic(p[0], p[1], p[2])), u, x),
        12 => values(&right(normal(p[0], p[1])), u, x),
        13 if p[1] < 0.0 => values(&lower_normal(p[0], p[1]), u, x),
        13 => values(&upper_normal(p[0], p[1]), u, x),
        14 => values(&right(cauchy(p[0])), u, x),
        20 => values(&right(pareto(p[0], p[1], p[2])), u, x),
        21 => values(&right(kumaraswamy(p[0], p[1])), u, x),
        22 => values(&right(power_law(p[0], p[1], p[2])), u, x),
        24 => values(&right(sinh_arcsinh(p[0], p[1])), u, x),
        25 => values(&right(heavy_tails(p[0])), u, x),
        26 => values(&right(equiangular(p[0], p[1], p[2])), u, x),
        27 => values(&wavelength(), u, x),
        28 => values(&right(linear_extinction(p[0], p[1])), u, x),
        29 => values(&right(falling_extinction(p[0], p[1])), u, x),
        33 => values(&arcsine(), u, x),
        _ => panic!("no sampler for row {number}"),
    }
}

/// Relative error that a well-conditioned value may have.
const TOLERANCE: f64 = 1e-12;
/// A condition number says what rounding of the inputs may cost, and an implementation that does
/// not round them loses less: more than this is not excused by it.
const WORST_CONDITION: f64 = 1e3;

#[test]
fn samples_and_densities_agree_with_the_reference() {
    let mut failed = Vec::new();
    for line in include_str!("../reference/algebra.txt").lines().filter(|l| !l.starts_with('#')) {
        let n: Vec<f64> = line.split(' ').map(|n| n.parse().expect("a number")).collect();
        let (inputs, outputs) = n.split_at(n.len() - 6);
        let (parameters, u) = (&inputs[1..inputs.len() - 1], inputs[inputs.len() - 1]);
        let [x, pdf, at_rounded, c_sample, c_pdf, c_own] = *outputs else { unreachable!() };
        let found = row(inputs[0] as u32, parameters, u, x);
        let expected = [(x, c_sample), (pdf, c_own), (at_rounded, c_pdf)];
        for ((found, (value, condition)), what) in
            found.into_iter().zip(expected).zip(["sample", "sample.pdf()", "pdf(x)"])
        {
            let error = if found == value { 0.0 } else { ((found - value) / value).abs() };
            let limit = TOLERANCE * condition.clamp(1.0, WORST_CONDITION);
            // A zero of the map is the difference of numbers that are not, and are rounded.
            let near_zero = value == 0.0 && found.abs() < 1e-15;
            if !(error <= limit || near_zero) {
                failed.push(format!("{what} {found:e}, error {error:.1e} > {limit:.1e}: {line}"));
            }
        }
    }
    assert!(failed.is_empty(), "{} failures:\n{}", failed.len(), failed.join("\n"));
}

// The battery, in `f64` and perhaps in `f32`. Its seeds are fixed; one seed in a million would make
// a right sampler fail.
batteries! { [double single]
    row_9_epanechnikov: epanechnikov();
    row_10_logistic: right(logistic(1.0)), right(logistic(0.25));
    row_11_truncated_logistic: right(truncated_logistic(1.0, -2.0, 3.0));
    row_11_truncated_logistic_as_printed: right(truncated_logistic_as_printed(1.0, -2.0, 3.0));
    row_12_normal: right(normal(0.0, 1.0)), right(normal(-3.0, 0.25));
    row_14_cauchy: right(cauchy(1.0)), right(cauchy(20.0));
    row_20_pareto: right(pareto(0.0, 1.0, 0.25)), right(pareto(1.0, 2.0, -0.5));
    row_21_kumaraswamy: right(kumaraswamy(2.0, 3.0)), right(kumaraswamy(2.0, 2.0));
    row_24_sinh_arcsinh: right(sinh_arcsinh(0.5, 1.5));
    row_25_heavy_tails: right(heavy_tails(0.25));
    row_26_equiangular: right(equiangular(1.0, -1.0, 3.0)), right(equiangular(0.5, 1.0, 2.0));
    row_26_equiangular_as_printed: right(equiangular_as_printed(1.0, -1.0, 3.0)), right(equiangular_as_printed(0.5, 1.0, 2.0));
    row_27_wavelength: wavelength();
    row_28_linear_extinction: right(linear_extinction(1.0, 2.0));
    row_29_falling_extinction: right(falling_extinction(1.0, 0.5)), right(falling_extinction(2.0, 0.125));
    row_108_small_angles: right(small_angles(0.125, 1.0));
}

/// Left out in `f32`: the tangent next to its poles, and narrow ranges far from zero and folds of the map,
/// where differences of the map are too coarse to vouch for a density.
mod only_double {
    use super::*;
    batteries! { [double]
        row_13_upper_normal: upper_normal(8.0, 9.0);
        row_14_cauchy_by_tangent: right(cauchy_by_tangent(1.0));
        row_22_power_law: right(power_law(1.0, 2.0, 2.0)), right(power_law(0.5, 4.0, 3.5));
        row_33_arcsine: arcsine();
    }
}

mod only_single {
    use super::*;
    batteries! { [single]
        row_13_upper_normal: upper_normal(0.5, 2.0);
    }
}
