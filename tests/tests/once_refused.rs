//! Cases that an earlier implementation of the same idea refused, or took and got wrong; `regressions.rs` has
//! those that are simplest to write. Each test states the true value in closed form.

use aether_core::battery;
use aether_core::prelude::*;
use tests::catalogue::{
    bilinear_patch, concentric_disk, concentric_hemisphere, helix, reflected_ggx, sphere_light,
    student, torus, triangle_heitz,
};
use tests::checks::right;

/// Asserts that two densities agree to rounding.
#[track_caller]
fn close(found: f64, expected: f64) {
    assert!((found - expected).abs() <= 2e-13 * expected.abs(), "{found:e}, expected {expected:e}");
}

/// Asserts that a sample's own density and that of the point both have the value.
#[track_caller]
fn both<S: Sampler<f64>>(sampler: S, u: S::Uniforms, expected: f64) {
    let sample = sampler.sample(u);
    close(sample.pdf().value(), expected);
    close(sampler.pdf(&sample).value(), expected);
}

// One dimension.

#[sampler]
fn cube_and_itself(u: [Uniform; 1]) -> f64 {
    u[0].powi(3) + u[0]
}

#[sampler]
fn exponential_and_itself(u: [Uniform; 1]) -> f64 {
    u[0] + u[0].exp()
}

#[sampler]
fn log_odds(u: [Uniform; 1]) -> f64 {
    (u[0] / (1.0 - u[0])).ln()
}

#[sampler]
fn tangent(u: [Uniform; 1]) -> f64 {
    u[0].tan()
}

#[sampler]
fn arc_cosine(u: [Uniform; 1]) -> f64 {
    u[0].acos()
}

#[sampler]
fn angle_of_a_slope(u: [Uniform; 1], x: f64) -> f64 {
    u[0].atan2(x)
}

#[sampler(d in 1e-3..)]
fn equiangular(u: [Uniform; 1], d: f64, a: f64, b: f64) -> f64 {
    let (from, to) = ((a / d).atan(), (b / d).atan());
    d * ((1.0 - u[0]) * from + u[0] * to).tan()
}

#[sampler]
fn kepler(u: [Uniform; 1]) -> f64 {
    solve(|a| a - 0.6 * a.sin(), 0.0..TAU, TAU * u[0])
}

#[test]
fn one_uniform_that_occurs_twice() {
    for u in [0.05, 0.3, 0.7, 0.95_f64] {
        both(cube_and_itself(), [u], 1.0 / (1.0 + 3.0 * u * u));
        both(exponential_and_itself(), [u], 1.0 / (1.0 + u.exp()));
        both(log_odds(), [u], u * (1.0 - u));
        let e = *kepler().sample([u]);
        both(kepler(), [u], (1.0 - 0.6 * e.cos()) / TAU);
        let t = *right(student(4.0)).sample([u]);
        both(right(student(4.0)), [u], 0.375 * (1.0 + t * t / 4.0).powf(-2.5));
    }
}

#[test]
fn tangents_and_inverse_functions_have_derivatives() {
    for u in [0.05, 0.3, 0.7, 0.95_f64] {
        both(tangent(), [u], u.cos() * u.cos());
        both(arc_cosine(), [u], (1.0 - u * u).sqrt());
        both(angle_of_a_slope(0.75), [u], (u * u + 0.5625) / 0.75);
        let (d, a, b) = (0.5, -1.0, 2.0_f64);
        let x = *right(equiangular(d, a, b)).sample([u]);
        let width = (b / d).atan() - (a / d).atan();
        both(right(equiangular(d, a, b)), [u], d / (width * (d * d + x * x)));
    }
}

// Conditions.

#[sampler]
fn by_less(u: [Uniform; 1]) -> f64 {
    if u[0] < 0.25 { 2.0 * u[0] } else { 0.5 + (u[0] - 0.25) / 3.0 }
}

#[sampler]
fn by_logic(u: [Uniform; 1]) -> f64 {
    if u[0] >= 0.75 || u[0] <= 0.25 { 2.0 * u[0] } else { 4.0 + u[0] }
}

#[test]
fn every_comparison_can_be_written() {
    both(by_less(), [0.125], 0.5);
    both(by_less(), [0.5], 3.0);
    both(by_logic(), [0.125], 0.5);
    both(by_logic(), [0.5], 1.0);
    both(by_logic(), [0.875], 0.5);
    assert_eq!(by_logic().pdf(&1.0).value(), 0.0);
}

/// Half-open and closed ranges, one without an end, alternatives and a guard.
#[sampler]
fn by_ranges(u: [Uniform; 1]) -> f64 {
    match u[0] {
        0.0..0.25 | 0.75.. => u[0],
        x if x > 0.5 => 2.0 * x,
        0.25..=0.5 => 3.0 * u[0],
        _ => 8.0,
    }
}

#[test]
fn arms_are_ranges() {
    both(by_ranges(), [0.125], 1.0);
    // 3 u for u in [1/4, 1/2] comes to [3/4, 3/2], and 2 u for u in (1/2, 3/4) to (1, 3/2).
    both(by_ranges(), [0.875], 1.0 + 1.0 / 3.0);
    assert_eq!(by_ranges().sample([0.25]).value(), 0.75);
    assert_eq!(by_ranges().sample([0.75]).value(), 0.75);
    both(by_ranges(), [0.375], 1.0 / 2.0 + 1.0 / 3.0);
    both(by_ranges(), [0.625], 1.0 / 2.0 + 1.0 / 3.0);
    assert_eq!(by_ranges().pdf(&0.5).value(), 0.0);
}

// Frames about directions.

/// A direction of the sphere, and one about it with a density that is its cosine.
#[sampler]
fn about_a_sample(u: [Uniform; 4]) -> (Direction, Direction) {
    let z = 1.0 - 2.0 * u[0];
    let (r, phi) = ((1.0 - z * z).sqrt(), TAU * u[1]);
    let first = Direction::new(r * phi.cos(), r * phi.sin(), z);
    let (s, psi) = (u[2].sqrt(), TAU * u[3]);
    let local = Vec3::new(s * psi.cos(), s * psi.sin(), (1.0 - u[2]).sqrt());
    (first, Direction::from_vec(Frame::around(first).to_world(local)))
}

#[sampler]
fn about_a_parameter(u: [Uniform; 2], axis: Direction) -> Direction {
    let (s, psi) = (u[0].sqrt(), TAU * u[1]);
    let local = Vec3::new(s * psi.cos(), s * psi.sin(), (1.0 - u[0]).sqrt());
    Direction::from_vec(Frame::around(axis).to_world(local))
}

#[test]
fn frames_are_about_directions() {
    let chain = about_a_sample();
    for u in [[0.3, 0.6, 0.2, 0.9], [0.8, 0.1, 0.5, 0.4], [0.95, 0.7, 0.9, 0.15]] {
        let (a, b) = chain.sample(u).value();
        // As plain code makes the frame.
        let (s, psi) = (u[2].sqrt(), std::f64::consts::TAU * u[3]);
        let local = Vec3::new(s * psi.cos(), s * psi.sin(), (1.0 - u[2]).sqrt());
        let expected = Frame::around(a).to_world(local);
        assert!((b.vec() - expected).length() < 1e-15, "{b:?} and {expected:?}");
        both(about_a_sample(), u, a.dot(b) / (4.0 * std::f64::consts::PI.powi(2)));
    }
    for axis in [[0.48, 0.64, 0.6], [0.6, 0.0, -0.8], [0.0, 0.0, -1.0]] {
        let axis = Direction::new(axis[0], axis[1], axis[2]);
        for u in [[0.3, 0.6], [0.8, 0.1]] {
            let w = about_a_parameter(axis).sample(u).value();
            both(about_a_parameter(axis), u, axis.dot(w) * std::f64::consts::FRAC_1_PI);
        }
    }
}

// Uniforms are known by their index, not by where they occur first.

#[sampler]
fn second_first(u: [Uniform; 2]) -> Surface {
    Surface::new(u[1], u[0], 1.0)
}

#[test]
fn uniforms_go_by_their_index() {
    let x = second_first().sample([0.25, 0.5]).value();
    assert_eq!(x, Surface::new(0.5, 0.25, 1.0));
    both(second_first(), [0.25, 0.5], 1.0);
}

// Surfaces and volumes.

#[sampler]
fn flat_disk(u: [Uniform; 2]) -> Surface {
    let r = u[0].sqrt();
    let phi = TAU * u[1];
    Surface::new(r * phi.cos(), r * phi.sin(), 0.0)
}

#[sampler]
fn ball(u: [Uniform; 3]) -> Vec3 {
    let z = 1.0 - 2.0 * u[1];
    let s = (1.0 - z * z).sqrt();
    let phi = TAU * u[2];
    u[0].cbrt() * Vec3::new(s * phi.cos(), s * phi.sin(), z)
}

#[sampler]
fn cube(u: [Uniform; 3]) -> Vec3 {
    Vec3::new(2.0 * u[0], 3.0 * u[1], 4.0 * u[2])
}

#[sampler]
fn sphere_by_its_radius(u: [Uniform; 2]) -> Direction {
    let r = 2.0 * (u[0] * (1.0 - u[0])).sqrt();
    let phi = TAU * u[1];
    Direction::new(r * phi.cos(), r * phi.sin(), 1.0 - 2.0 * u[0])
}

#[test]
fn a_disk_has_no_density_off_its_plane() {
    both(flat_disk(), [0.3, 0.6], 1.0 / PI);
    both(flat_disk(), [0.0, 0.6], 1.0 / PI);
    assert_eq!(flat_disk().pdf(&Surface::new(0.3, 0.2, 1e-3)).value(), 0.0);
    assert_eq!(flat_disk().pdf(&Surface::new(0.9, 0.9, 0.0)).value(), 0.0);
}

#[test]
fn volumes_have_densities() {
    both(ball(), [0.3, 0.6, 0.2], 0.75 / PI);
    assert_eq!(ball().pdf(&Vec3::new(0.8, 0.8, 0.0)).value(), 0.0);
    both(cube(), [0.3, 0.6, 0.2], 1.0 / 24.0);
}

#[test]
fn curves_and_surfaces_have_densities() {
    both(sphere_by_its_radius(), [0.3, 0.6], 0.25 / PI);
    both(concentric_disk(), [0.3, 0.6], 1.0 / PI);
    both(concentric_hemisphere(), [0.3, 0.6], 0.5 / PI);
    both(right(helix(1.5, 0.25, 20.0)), [0.3], 1.0 / (20.0 * 1.5_f64.hypot(0.25)));
    let x = right(torus(2.0, 0.5)).sample([0.3, 0.6]).value().vec();
    both(right(torus(2.0, 0.5)), [0.3, 0.6], 1.0 / (4.0 * PI * PI * 0.5 * x.x.hypot(x.y)));
    let v = Vec3::new;
    let heitz = triangle_heitz(v(1.0, 0.0, 0.0), v(1.0, 2.0, 0.0), v(1.0, 0.0, 3.0));
    both(heitz, [0.3, 0.6], 1.0 / 3.0);
    both(heitz, [0.6, 0.3], 1.0 / 3.0);
    let [a, b, c, d] =
        [v(0.0, 0.0, 0.0), v(2.0, 0.25, 0.5), v(2.5, 1.75, -0.25), v(-0.25, 1.0, 0.75)];
    let (s, t) = (0.3, 0.6);
    let along = (1.0 - t) * (b - a) + t * (c - d);
    let across = (1.0 - s) * (d - a) + s * (c - b);
    both(bilinear_patch(a, b, c, d), [s, t], 1.0 / along.cross(across).length());
}

// Microfacets.

#[sampler(alpha in 1e-3..=1.0)]
fn ggx_by_the_cosine(u: [Uniform; 2], alpha: f64) -> Direction {
    let z = ((1.0 - u[0]) / (1.0 + (alpha * alpha - 1.0) * u[0])).sqrt();
    let r = (1.0 - z * z).sqrt();
    let phi = TAU * u[1];
    Direction::new(r * phi.cos(), r * phi.sin(), z)
}

#[sampler(alpha in 1e-3..=1.0)]
fn ggx_by_the_angle(u: [Uniform; 2], alpha: f64) -> Direction {
    let theta = (alpha * (u[0] / (1.0 - u[0])).sqrt()).atan();
    let phi = TAU * u[1];
    Direction::new(theta.sin() * phi.cos(), theta.sin() * phi.sin(), theta.cos())
}

fn ggx_density(alpha: f64, h: Direction) -> f64 {
    let slope = (h.x * h.x + h.y * h.y) / (alpha * alpha) + h.z * h.z;
    h.z / (PI * alpha * alpha * slope * slope)
}

#[test]
fn ggx_compiles_in_both_usual_forms() {
    for u in [[0.3, 0.6], [0.9, 0.1], [0.01, 0.99]] {
        let h = right(ggx_by_the_cosine(0.25)).sample(u).value();
        both(right(ggx_by_the_cosine(0.25)), u, ggx_density(0.25, h));
        let h = right(ggx_by_the_angle(0.25)).sample(u).value();
        both(right(ggx_by_the_angle(0.25)), u, ggx_density(0.25, h));
    }
}

/// About w, which is seen from behind by some half vectors: the sample is as legal as any other.
#[sampler(n in 0.0..=100.0)]
fn blinn(u: [Uniform; 2], n: f64, w: Direction) -> Direction {
    let z = u[0].powf(1.0 / (n + 1.0));
    let r = (1.0 - z * z).sqrt();
    let phi = TAU * u[1];
    let h = Vec3::new(r * phi.cos(), r * phi.sin(), z);
    Direction::from_vec(2.0 * h.dot(w) * h - w)
}

#[test]
fn a_reflection_at_a_half_vector_that_faces_away_has_a_density() {
    let (n, w) = (2.0, Direction::from_vec(Vec3::new(0.9, 0.3, 0.1).normalize()));
    let lobe = right(blinn(n, w));
    let mut away = 0;
    for k in 0..100 {
        let u = [(f64::from(k % 10) + 0.5) / 10.0, (f64::from(k / 10) + 0.5) / 10.0];
        let (z, phi) = (u[0].powf(1.0 / 3.0), TAU * u[1]);
        let r = (1.0 - z * z).sqrt();
        let cosine = Vec3::new(r * phi.cos(), r * phi.sin(), z).dot(w);
        away += usize::from(cosine < 0.0);
        // A point has this half vector and the opposite one, which lies below the horizon.
        both(lobe, u, 3.0 * z * z / (TAU * 4.0 * cosine.abs()));
    }
    assert!(away > 10, "{away}");
}

#[test]
fn a_lobe_has_its_peak_at_the_mirror_direction() {
    let w = Direction::from_vec(Vec3::new(0.48, 0.64, 0.6));
    for alpha in [0.25, 0.5] {
        both(right(reflected_ggx(alpha, w)), [0.0, 0.3], 1.0 / (PI * alpha * alpha * 4.0 * w.z));
    }
}

#[test]
fn a_sphere_light_has_the_density_of_its_axis() {
    let (d, r, m) = (1.25_f64, 0.75, 0.1875);
    both(right(sphere_light(m, d, r)), [0.0, 0.3], 1.0 / (TAU * m * (d - r) * (d - r)));
}

#[sampler(k in 0.1..=5.0)]
fn bent_disk(u: [Uniform; 2], k: f64) -> Vec2 {
    let (r, phi) = (u[0].sqrt(), TAU * u[1]);
    let y = r * phi.sin();
    Vec2::new(r * phi.cos() + k * y * y, y)
}

#[map]
fn polar(p: Vec2) -> Vec2 {
    Vec2::new(p.length(), p.y.atan2(p.x))
}

#[sampler(g in -0.95..=0.95)]
fn phase_function_about(u: [Uniform; 2], g: f64, wo: Direction) -> Direction {
    let cos = if g.abs() < 1e-3 {
        1.0 - 2.0 * u[0]
    } else {
        let s = (1.0 - g * g) / (1.0 + g - 2.0 * g * u[0]);
        (1.0 + g * g - s * s) / (2.0 * g)
    };
    let sin = (1.0 - cos * cos).sqrt();
    let phi = TAU * u[1];
    Direction::from_vec(Frame::around(wo).to_world(Vec3::new(
        sin * phi.cos(),
        sin * phi.sin(),
        cos,
    )))
}

#[test]
fn a_coordinate_that_another_depends_on_squared() {
    let disk = right(bent_disk(3.0));
    for u in [[0.25, 0.1], [0.9, 0.5], [1e-12, 0.75]] {
        both(disk, u, 1.0 / PI);
    }
}

#[test]
fn polar_coordinates_are_a_map() {
    // Uniform on the unit disk: r / π of radius and azimuth.
    let polar = Sampler::<f64>::then(plain_disk(), polar());
    for u in [[0.25, 0.1], [0.9, 0.45], [0.3, 0.7]] {
        both(polar, u, f64::sqrt(u[0]) / PI);
    }
    assert_eq!(polar.pdf(&Vec2::new(0.5, 4.0)).value(), 0.0);
    assert_eq!(polar.pdf(&Vec2::new(-0.5, 1.0)).value(), 0.0);
}

#[sampler]
fn plain_disk(u: [Uniform; 2]) -> Vec2 {
    let (r, phi) = (u[0].sqrt(), TAU * u[1]);
    Vec2::new(r * phi.cos(), r * phi.sin())
}

#[test]
fn a_narrow_branch_beside_one_that_a_frame_has() {
    for z in [0.5, -0.5] {
        let wo = Direction::from_vec(Vec3::new(0.3, 0.2, z).normalize());
        for g in [0.0, 5e-4, -0.6] {
            let sampler = right(phase_function_about(g, wo));
            let w = sampler.sample([0.3, 0.4]).value();
            let truth = if g.abs() < 1e-3 {
                1.0 / (4.0 * PI)
            } else {
                (1.0 - g * g) / (4.0 * PI) / (1.0 + g * g - 2.0 * g * w.dot(wo)).powf(1.5)
            };
            close(sampler.pdf(&w).value(), truth);
        }
    }
}

#[sampler(g in -0.95..=0.95)]
fn lobe_about(u: [Uniform; 2], g: f64, wo: Direction) -> Direction {
    let s = (1.0 - g * g) / (1.0 + g - 2.0 * g * u[0]);
    let cos = (1.0 + g * g - s * s) / (2.0 * g);
    let sin = (1.0 - cos * cos).sqrt();
    let phi = TAU * u[1];
    let local = Vec3::new(sin * phi.cos(), sin * phi.sin(), cos);
    Direction::from_vec(Frame::around(wo).to_world(local))
}

/// What a body turns by a frame about a parameter is derived in the frame: its poles are those of the frame.
#[test]
fn an_inverse_in_a_frame_is_that_in_its_coordinates() {
    for z in [0.5, -0.5] {
        let wo = Direction::from_vec(Vec3::new(0.3, 0.2, z).normalize());
        for g in [0.0, 1e-12, -1e-9, 1e-6, 1e-3, -0.3, 0.9] {
            let sampler = right(lobe_about(g, wo));
            for u in [[0.3, 0.4], [1e-9, 0.7], [0.999, 0.1]] {
                let sample = sampler.sample(u);
                let truth = (1.0 - g * g)
                    / (4.0 * PI)
                    / (1.0 + g * g - 2.0 * g * sample.value().dot(wo)).powf(1.5);
                assert!((sampler.pdf(&sample).value() / truth - 1.0).abs() < 1e-12);
                let found: Vec<[f64; 2]> = sampler.invert(&sample).iter().collect();
                assert_eq!(found.len(), 1, "{g:e} {u:?}");
                for (found, u) in found[0].iter().zip(u) {
                    assert!((found - u).abs() < 1e-9, "{found:e} for {u:e}, g = {g:e}");
                }
                assert!((found[0][0] / u[0] - 1.0).abs() < 1e-5, "{found:?} for {u:?}, g = {g:e}");
            }
        }
    }
}

// Spellings of papers and renderers.

/// The concentric map with its regions told by squares.
#[sampler]
fn disk_by_squares(u: [Uniform; 2]) -> Vec2 {
    let (a, b) = (2.0 * u[0] - 1.0, 2.0 * u[1] - 1.0);
    let (r, phi) =
        if a * a > b * b { (a, FRAC_PI_4 * (b / a)) } else { (b, FRAC_PI_2 - FRAC_PI_4 * (a / b)) };
    Vec2::new(r * phi.cos(), r * phi.sin())
}

/// The four regions of Shirley and Chiu (1997).
#[sampler]
fn disk_by_regions(u: [Uniform; 2]) -> Vec2 {
    let (a, b) = (2.0 * u[0] - 1.0, 2.0 * u[1] - 1.0);
    let (r, phi) = if a > -b {
        if a > b { (a, FRAC_PI_4 * (b / a)) } else { (b, FRAC_PI_4 * (2.0 - a / b)) }
    } else if a < b {
        (-a, FRAC_PI_4 * (4.0 + b / a))
    } else {
        (-b, FRAC_PI_4 * (6.0 - a / b))
    };
    Vec2::new(r * phi.cos(), r * phi.sin())
}

#[test]
fn regions_of_a_square_are_told_by_squares_and_by_two_comparisons() {
    let (squares, regions) = (disk_by_squares(), disk_by_regions());
    battery::check(&squares).assert_ok();
    battery::check(&regions).assert_ok();
    for u in [[0.9, 0.4], [0.1, 0.3], [0.45, 0.95], [0.6, 0.02], [0.5, 0.7]] {
        both(squares, u, 1.0 / PI);
        both(regions, u, 1.0 / PI);
        let found: Vec<[f64; 2]> = regions.invert(&regions.sample(u)).iter().collect();
        assert!(found.len() == 1 && found[0].iter().zip(u).all(|(a, b)| (a - b).abs() < 1e-14));
    }
}

/// The normals of a clear coat (Burley 2012), with the bounds that keep roots from rounding.
#[sampler(a in 1e-3..=0.99)]
fn clear_coat(u: [Uniform; 2], a: f64) -> Direction {
    let a2 = a * a;
    let cos = ((1.0 - a2.powf(1.0 - u[0])) / (1.0 - a2)).max(0.0).sqrt();
    let sin = (1.0 - cos * cos).max(0.0).sqrt();
    let phi = TAU * u[1];
    Direction::new(sin * phi.cos(), sin * phi.sin(), cos)
}

#[test]
fn bounds_that_keep_roots_from_rounding_are_no_branches() {
    battery::check(&right(clear_coat(0.3))).assert_ok();
    for a in [1e-3, 0.1, 0.9] {
        let coat = right(clear_coat(a));
        for u in [[0.3, 0.4], [0.99, 0.1]] {
            let h = coat.sample(u).value();
            let square = h.x * h.x + h.y * h.y + a * a * h.z * h.z;
            let truth = (a * a - 1.0) * h.z / (PI * (a * a).ln() * square);
            both(coat, u, truth);
        }
    }
}

/// Visible normals in a bounded cap, reflected at, in one body (Eto and Tokuyoshi 2023).
#[sampler(ax in 1e-3..=1.0, ay in 1e-3..=1.0, where i.z > 0.0)]
fn reflected_in_a_bounded_cap(u: [Uniform; 2], ax: f64, ay: f64, i: Direction) -> Direction {
    let stretched = Vec3::new(i.x * ax, i.y * ay, i.z).normalize();
    let phi = TAU * u[0];
    let a = ax.min(ay).clamp(0.0, 1.0);
    let s = 1.0 + (i.x * i.x + i.y * i.y).sqrt();
    let (a2, s2) = (a * a, s * s);
    let k = (1.0 - a2) * s2 / (s2 + a2 * i.z * i.z);
    let b = if i.z > 0.0 { k * stretched.z } else { stretched.z };
    let z = (1.0 - u[1]).mul_add(1.0 + b, -b);
    let sine = (1.0 - z * z).clamp(0.0, 1.0).sqrt();
    let o = Vec3::new(sine * phi.cos(), sine * phi.sin(), z);
    let m = stretched + o;
    let m = Vec3::new(m.x * ax, m.y * ay, m.z).normalize();
    Direction::from_vec(2.0 * i.dot(m) * m - i)
}

#[test]
fn a_reflection_at_a_normal_that_a_body_draws_is_undone_with_it() {
    let i = Direction::from_vec(Vec3::new(0.3, -0.2, 0.6).normalize());
    for [ax, ay] in [[0.3, 0.5], [0.9, 0.2], [0.05, 0.05]] {
        let sampler = right(reflected_in_a_bounded_cap(ax, ay, i));
        for u in [[0.3, 0.4], [0.8, 0.05], [0.1, 0.9]] {
            let o = sampler.sample(u).value();
            let m = (i.vec() + o.vec()).normalize();
            let d = 1.0
                / (PI * ax * ay * ((m.x / ax).powi(2) + (m.y / ay).powi(2) + m.z * m.z).powi(2));
            let t = ((ax * i.x).powi(2) + (ay * i.y).powi(2) + i.z * i.z).sqrt();
            let a2 = ax.min(ay).powi(2);
            let s2 = (1.0 + i.x.hypot(i.y)).powi(2);
            let k = (1.0 - a2) * s2 / (s2 + a2 * i.z * i.z);
            both(sampler, u, d / (2.0 * (k * i.z + t)));
        }
    }
}

/// The unit normal and a point of the unit sphere, normalised, are distributed by the cosine.
#[sampler]
fn cosine_by_sphere(u: [Uniform; 2], n: Direction) -> Direction {
    let a = 1.0 - 2.0 * u[0];
    let b = (1.0 - a * a).sqrt();
    let phi = TAU * u[1];
    let sum = Vec3::new(n.x + b * phi.cos(), n.y + b * phi.sin(), n.z + a);
    Direction::from_vec(sum.normalize())
}

#[test]
fn nothing_is_sampled_below_the_horizon_of_a_rounded_normal() {
    let n = Direction::new(0.3, -0.2, 0.7);
    let sampler = cosine_by_sphere(n);
    for u in [[0.3, 0.4], [0.9, 0.1], [0.55, 0.75]] {
        let x = sampler.sample(u);
        let cosine = n.dot(x.value());
        assert!((sampler.pdf(&x).value() / (cosine / PI) - 1.0).abs() < 1e-12);
        let below = Direction::from_vec(x.value().vec() - 2.0 * cosine * n.vec());
        assert_eq!(sampler.pdf(&below).value(), 0.0);
        assert_eq!(sampler.invert(&below).iter().count(), 0);
    }
    let grazing = Vec3::new(-0.2869769099651593, -0.9448720381711309, -0.15767398209337552);
    assert_eq!(sampler.pdf(&Direction::from_vec(grazing)).value(), 0.0);
}

/// The cosine of von Mises and Fisher's distribution as Jakob (2012) prints it, for all concentrations.
#[sampler(kappa in 1e-3..=1e5)]
fn concentrated(u: [Uniform; 2], kappa: f64) -> Direction {
    let w = 1.0 + 1.0 / kappa * (u[0] + (1.0 - u[0]) * (-2.0 * kappa).exp()).ln();
    let theta = TAU * u[1];
    let s = (1.0 - w * w).sqrt();
    Direction::new(s * theta.cos(), s * theta.sin(), w)
}

#[test]
fn exponentials_of_parameters_stay_within_range() {
    for kappa in [1e-2, 1.0, 300.0, 1e5] {
        let sampler = right(concentrated(kappa));
        for u in [[0.2, 0.4], [0.999, 0.1]] {
            let mean = u[0] + (1.0 - u[0]) * f64::exp(-2.0 * kappa);
            both(sampler, u, kappa * mean / (TAU * -f64::exp_m1(-2.0 * kappa)));
            let found: Vec<[f64; 2]> = sampler.invert(&sampler.sample(u)).iter().collect();
            assert!(found.len() == 1 && found[0].iter().zip(u).all(|(a, b)| (a - b).abs() < 1e-10));
        }
    }
}

/// Heitz 2018, "Sampling the GGX Distribution of Visible Normals", as listed.
#[sampler(alpha_x in 1e-3..=1.0, alpha_y in 1e-3..=1.0, where ve.z > 0.0)]
fn sample_ggx_vndf(u: [Uniform; 2], alpha_x: f64, alpha_y: f64, ve: Direction) -> Direction {
    let vh = Vec3::new(alpha_x * ve.x, alpha_y * ve.y, ve.z).normalize();
    let lensq = vh.x * vh.x + vh.y * vh.y;
    let axis_1 = if lensq > 0.0 {
        Vec3::new(-vh.y, vh.x, 0.0) * (1.0 / lensq.sqrt())
    } else {
        Vec3::new(1.0, 0.0, 0.0)
    };
    let axis_2 = vh.cross(axis_1);
    let r = u[0].sqrt();
    let phi = TAU * u[1];
    let t1 = r * phi.cos();
    let t2 = r * phi.sin();
    let s = 0.5 * (1.0 + vh.z);
    let t2 = (1.0 - s) * (1.0 - t1 * t1).sqrt() + s * t2;
    let nh = t1 * axis_1 + t2 * axis_2 + (1.0 - t1 * t1 - t2 * t2).max(0.0).sqrt() * vh;
    Direction::from_vec(Vec3::new(alpha_x * nh.x, alpha_y * nh.y, nh.z.max(0.0)).normalize())
}

/// Asserts that a sample has the density of visible normals of GGX, and its uniforms as its only preimage.
#[track_caller]
fn visible<S>(normals: S, (ax, ay, v): (f64, f64, Direction), u: [f64; 2])
where
    S: Sampler<f64, Uniforms = [f64; 2], Point = Direction> + Copy,
{
    let n = normals.sample(u);
    let slopes = (n.x / ax).powi(2) + (n.y / ay).powi(2) + n.z * n.z;
    let seen = v.z + ((ax * v.x).powi(2) + (ay * v.y).powi(2) + v.z * v.z).sqrt();
    let expected = 2.0 * v.dot(n.value()) / (seen * PI * ax * ay * slopes.powi(2));
    close(normals.pdf(&n).value(), expected);
    assert!((n.pdf().value() / expected - 1.0).abs() < 1e-11);
    let back: Vec<_> = normals.invert(&n).iter().collect();
    assert_eq!(back.len(), 1);
    assert!(back[0].iter().zip(u).all(|(a, b)| (a - b).abs() < 1e-12), "{back:?}");
}

/// Straight from above its frame is another one, which is a way through the body that one view alone takes; a name
/// has two values, and a bound keeps rounding from a height.
#[test]
fn visible_normals_have_their_density_straight_from_above_too() {
    for (ax, ay) in [(0.5, 0.2), (1e-3, 1e-3), (0.01, 1.0)] {
        for v in [(0.0, 0.0, 1.0), (0.3, 0.0, 0.7), (0.0, -0.2, 0.1), (1e-170, 0.0, 1.0)] {
            let v = Direction::from_vec(Vec3::new(v.0, v.1, v.2).normalize());
            for u in [[0.3, 0.1], [0.9, 0.6], [1e-3, 0.8]] {
                visible(sample_ggx_vndf(ax, ay, v).unwrap(), (ax, ay, v), u);
                visible(ggx_vndf_by_halves(ax, v).unwrap(), (ax, ax, v), u);
            }
        }
    }
    let above = sample_ggx_vndf(0.5, 0.2, Direction::new(0.0, 0.0, 1.0)).unwrap();
    // At a turn of zero the normal leans towards the second frame's first axis.
    let n = above.sample([0.5, 0.0]);
    assert!(n.x > 0.1 && n.y.abs() < 1e-16);
}

/// The same of the older form, by half disks (Heitz 2017, "A Simpler and Exact Sampling Routine for the GGX Distribution
/// of Visible Normals").
#[sampler(alpha in 1e-3..=1.0, where ve.z > 0.0)]
fn ggx_vndf_by_halves(u: [Uniform; 2], alpha: f64, ve: Direction) -> Direction {
    let v = Vec3::new(alpha * ve.x, alpha * ve.y, ve.z).normalize();
    let l = v.x * v.x + v.y * v.y;
    let t1 = if l <= 0.0 { Vec3::new(1.0, 0.0, 0.0) } else { Vec3::new(-v.y, v.x, 0.0) / l.sqrt() };
    let t2 = v.cross(t1);
    let a = 1.0 / (1.0 + v.z);
    let r = u[0].sqrt();
    let phi = if u[1] < a { u[1] / a * PI } else { PI + (u[1] - a) / (1.0 - a) * PI };
    let p1 = r * phi.cos();
    let p2 = r * phi.sin() * if u[1] < a { 1.0 } else { v.z };
    let n = p1 * t1 + p2 * t2 + (1.0 - p1 * p1 - p2 * p2).max(0.0).sqrt() * v;
    Direction::from_vec(Vec3::new(alpha * n.x, alpha * n.y, n.z.max(0.0)).normalize())
}

/// pbrt-v4's `Sphere::Sample` for a point outside, at the distance `dc` of the centre, without bounds.
#[sampler(radius in 0.05..=1.0, dc in 1.1..=100.0)]
fn sphere_from_outside(u: [Uniform; 2], radius: f64, dc: f64) -> Surface {
    let sin_theta_max = radius / dc;
    let sin2_theta_max = sin_theta_max * sin_theta_max;
    let cos_theta_max = (1.0 - sin2_theta_max).sqrt();
    let (sin2_theta, cos_theta) = if sin2_theta_max < 0.00068523 {
        let sin2_theta = sin2_theta_max * u[0];
        (sin2_theta, (1.0 - sin2_theta).sqrt())
    } else {
        let cos_theta = (cos_theta_max - 1.0) * u[0] + 1.0;
        (1.0 - cos_theta * cos_theta, cos_theta)
    };
    let cos_alpha = sin2_theta / sin_theta_max
        + cos_theta * (1.0 - sin2_theta / (sin_theta_max * sin_theta_max)).sqrt();
    let sin_alpha = (1.0 - cos_alpha * cos_alpha).sqrt();
    let phi = TAU * u[1];
    let (x, y) = (sin_alpha * phi.cos(), sin_alpha * phi.sin());
    Surface::new(radius * x, radius * y, dc - radius * cos_alpha)
}

/// A root stands in the equation by itself and in a product, and squaring leaves a quadratic equation. The second way is
/// uniform in the sine's square instead of the angle.
#[test]
fn a_sphere_from_outside_has_the_density_of_the_cone() {
    for (radius, dc) in [(0.5, 1.1), (1.0, 2.0), (1.0, 38.1), (1.0, 38.3), (0.05, 100.0)] {
        let sphere = sphere_from_outside(radius, dc).unwrap();
        let sine2 = (radius / dc) * (radius / dc);
        for u in [[0.3, 0.1], [0.9, 0.6], [1e-3, 0.8]] {
            let x = sphere.sample(u);
            let to = x.value().vec();
            let normal = Vec3::new(to.x, to.y, to.z - dc) / radius;
            let cone = match sine2 < 0.00068523 {
                true => PI * sine2 * to.length() / to.z,
                false => TAU * sine2 / (1.0 + (1.0 - sine2).sqrt()),
            };
            let expected = to.dot(normal).abs() / (to.length().powi(3) * cone);
            // What the sample is off by counts, as the point is far away.
            let tolerance = 1e-13 * dc / radius;
            for found in [x.pdf().value(), sphere.pdf(&x).value()] {
                assert!(
                    (found / expected - 1.0).abs() < tolerance,
                    "{found} {expected} {radius} {dc}"
                );
            }
        }
    }
}

/// The cosine hemisphere about a direction, in the frame that turns about z.
#[sampler]
fn cosine_about(u: [Uniform; 2], w: Direction) -> Direction {
    let l = w.x * w.x + w.y * w.y;
    let t = if l > 0.0 { Vec3::new(-w.y, w.x, 0.0) / l.sqrt() } else { Vec3::new(1.0, 0.0, 0.0) };
    let b = w.vec().cross(t);
    let r = u[0].sqrt();
    let phi = TAU * u[1];
    Direction::from_vec(r * phi.cos() * t + r * phi.sin() * b + (1.0 - u[0]).sqrt() * w.vec())
}

/// A quarter of a logarithm's curve, and what it tends to, written otherwise.
#[sampler(a in 0.0..=5.0)]
fn logarithm_or_twice(u: [Uniform; 1], a: f64) -> f64 {
    if a > 0.0 { (1.0 + a * u[0]).ln() / a } else { 2.0 * u[0] }
}

/// A segment along a vector, and one of unit length where there is none.
#[sampler]
fn along(u: [Uniform; 1], v: Vec3) -> f64 {
    let l = v.length();
    if l > 0.0 { u[0] * l } else { 1.0 + u[0] }
}

/// A map that is another one where its parameter vanishes.
#[map]
fn scaled_or_trebled(p: Vec2, a: f64) -> Vec2 {
    if a * a > 0.0 { Vec2::new(a * p.x, p.y) } else { Vec2::new(3.0 * p.x, p.y) }
}

#[sampler]
fn unit_square(u: [Uniform; 2]) -> Vec2 {
    Vec2::new(u[0], u[1])
}

#[test]
fn what_vanishes_has_the_way_that_is_written_for_it() {
    for (a, width) in [(0.0, 3.0), (0.5, 0.5), (1e-9, 1e-9)] {
        let sampler = unit_square().then(scaled_or_trebled(a));
        both(sampler, [0.3, 0.4], 1.0 / width);
        assert_eq!(sampler.invert(&sampler.sample([0.3, 0.4])).iter().count(), 1);
    }
    for w in [(0.0, 0.0, 1.0), (0.0, 0.0, -1.0), (0.6, 0.0, 0.8), (1e-9, 1e-9, -1.0)] {
        let w = Direction::from_vec(Vec3::new(w.0, w.1, w.2).normalize());
        for u in [[0.3, 0.1], [0.9, 0.6], [1e-3, 0.8]] {
            let x = cosine_about(w).sample(u);
            both(cosine_about(w), u, w.dot(x.value()) / PI);
            let back: Vec<_> = cosine_about(w).invert(&x).iter().collect();
            assert!((back[0][1] - u[1]).abs() < 1e-12 && back.len() == 1, "{back:?}");
            let below = Direction::from_vec(-x.value().vec());
            assert_eq!(cosine_about(w).pdf(&below).value(), 0.0);
        }
    }
    let x = cosine_about(Direction::new(0.0, 0.0, -1.0)).sample([0.5, 0.0]);
    assert!(x.x > 0.7 && x.y.abs() < 1e-15, "the frame that is written: {:?}", x.value());

    // It is no limit of what it is elsewhere.
    let at_zero = logarithm_or_twice(0.0).unwrap();
    close(at_zero.sample([0.75]).value(), 1.5);
    both(at_zero, [0.75], 0.5);
    close(at_zero.invert(&0.8).iter().next().unwrap()[0], 0.4);
    let beside = logarithm_or_twice(1e-170).unwrap();
    close(beside.sample([0.75]).value(), 0.75);

    both(along(Vec3::new(0.0, 0.0, 0.0)), [0.25], 1.0);
    close(along(Vec3::new(0.0, 0.0, 0.0)).sample([0.25]).value(), 1.25);
    both(along(Vec3::new(3.0, 0.0, 4.0)), [0.25], 0.2);
}

/// Refraction into a denser half space at normals about z, in cosines (Walter et al. 2007).
#[sampler(eta in 1.05..=3.0)]
fn refracted_cosine(u: [Uniform; 1], eta: f64) -> f64 {
    let c = u[0];
    let ct = (1.0 - (1.0 - c * c) / (eta * eta)).sqrt();
    c * ct - (1.0 - c * c) / eta
}

/// A torus, uniform in area: the distribution function of its angle is solved for.
#[sampler(major in 1.0..=10.0, minor in 0.01..=0.99)]
fn torus_by_area(u: [Uniform; 2], major: f64, minor: f64) -> Surface {
    let v = solve(|v| v + minor / major * v.sin(), 0.0..TAU, TAU * u[1]);
    let a = TAU * u[0];
    let r = major + minor * v.cos();
    Surface::new(r * a.cos(), r * a.sin(), minor * v.sin())
}

#[test]
fn even_equations_and_angles_that_are_solved_for() {
    for eta in [1.05, 1.5, 3.0] {
        let cosine = refracted_cosine(eta).unwrap();
        for u in [0.0, 1e-6, 0.3, 0.99] {
            let ct: f64 = (1.0 - (1.0 - u * u) / (eta * eta)).sqrt();
            both(cosine, [u], 1.0 / (ct + u * u / (eta * eta * ct) + 2.0 * u / eta));
        }
    }
    for u in [[0.1, 0.2], [0.7, 0.6], [0.4, 0.99]] {
        let torus = torus_by_area(2.0, 0.5).unwrap();
        both(torus, u, 1.0 / (4.0 * PI * PI));
        let back = torus.invert(&torus.sample(u)).iter().next().unwrap();
        assert!(back.iter().zip(u).all(|(a, b)| (a - b).abs() < 1e-12), "{back:?} {u:?}");
    }
}

/// A spherical triangle by its corners, in the steps of pbrt-v4.
#[sampler(where a.cross(b).dot(c) > 0.01)]
fn triangle_by_corners(u: [Uniform; 2], a: Direction, b: Direction, c: Direction) -> Direction {
    let n_ab = a.cross(b).normalize();
    let n_bc = b.cross(c).normalize();
    let n_ca = c.cross(a).normalize();
    let alpha = (-n_ab.dot(n_ca)).acos();
    let beta = (-n_bc.dot(n_ab)).acos();
    let gamma = (-n_ca.dot(n_bc)).acos();
    let a_pi = alpha + beta + gamma;
    let ap_pi = (1.0 - u[0]) * PI + u[0] * a_pi;
    let (cos_alpha, sin_alpha) = (alpha.cos(), alpha.sin());
    let sin_phi = ap_pi.sin() * cos_alpha - ap_pi.cos() * sin_alpha;
    let cos_phi = ap_pi.cos() * cos_alpha + ap_pi.sin() * sin_alpha;
    let k1 = cos_phi + cos_alpha;
    let k2 = sin_phi - sin_alpha * a.dot(b);
    let cos_bp = (k2 + (k2 * cos_phi - k1 * sin_phi) * cos_alpha)
        / ((k2 * sin_phi + k1 * cos_phi) * sin_alpha);
    let sin_bp = (1.0 - cos_bp * cos_bp).sqrt();
    let cp = cos_bp * a + sin_bp * (c.vec() - c.dot(a) * a).normalize();
    let cos_theta = 1.0 - u[1] * (1.0 - cp.dot(b));
    let sin_theta = (1.0 - cos_theta * cos_theta).sqrt();
    Direction::from_vec(cos_theta * b + sin_theta * (cp - cp.dot(b) * b).normalize())
}

/// From a height on, as far as two points are apart, which is declared and computed once. Names of the body are no others.
#[sampler(width in 1e-3..=10.0)]
fn between_points(u: [Uniform; 1], a: Vec3, b: Vec3) -> f64 {
    let (lane, numbers) = (b - a, 1.0);
    let all = lane.length();
    let width = numbers * all;
    a.z + width * u[0]
}

#[test]
fn what_parameters_alone_make_is_computed_once() {
    let corner = |x, y, z| Direction::from_vec(Vec3::new(x, y, z));
    let octant = [corner(1.0, 0.0, 0.0), corner(0.0, 1.0, 0.0), corner(0.0, 0.0, 1.0)];
    let wide = [corner(1.0, 0.1, 0.0), corner(0.2, 1.0, 0.3), corner(-0.3, 0.3, 1.0)];
    for [a, b, c] in [octant, wide] {
        let triangle = triangle_by_corners(a, b, c).unwrap();
        let volume = a.vec().dot(b.vec().cross(c.vec()));
        let area = 2.0 * volume.atan2(1.0 + a.dot(b) + b.dot(c) + c.dot(a));
        for u in [[0.3, 0.6], [0.9, 0.2], [0.5, 0.5]] {
            let x = triangle.sample(u);
            assert!((x.pdf().value() * area - 1.0).abs() < 1e-12);
            assert!((triangle.pdf(&x).value() * area - 1.0).abs() < 1e-12);
            let back = triangle.invert(&x).iter().next().unwrap();
            assert!(back.iter().zip(u).all(|(a, b)| (a - b).abs() < 1e-12), "{back:?} {u:?}");
            let inside = |n: Vec3| n.dot(x.value().vec()) > 0.0;
            assert!([a.cross(b), b.cross(c), c.cross(a)].into_iter().all(inside));
            assert_eq!(triangle.pdf(&Direction::from_vec(-x.value().vec())).value(), 0.0);
        }
    }
    let [a, b, c] = octant;
    assert!(triangle_by_corners(a, c, b).is_err());

    both(between_points(Vec3::splat(0.0), Vec3::new(3.0, 0.0, 4.0)).unwrap(), [0.25], 0.2);
    let apart = between_points(Vec3::splat(0.0), Vec3::splat(100.0));
    assert_eq!(apart.unwrap_err().requirement, "width in 0.001..=10.0");
}

/// A spotlight's falloff in two parts, with the bound that printed code has.
#[sampler(c0 in 0.0..=1.0, c1 in 0.0..=1.0, where c0 < c1)]
fn spot_in_two_parts(u: [Uniform; 2], c0: f64, c1: f64) -> Direction {
    let z = if u[0] < 0.5 {
        c1 + (1.0 - c1) * (2.0 * u[0])
    } else {
        c0 + (c1 - c0) * (2.0 * u[0] - 1.0)
    };
    let r = (1.0 - z * z).max(0.0).sqrt();
    let phi = TAU * u[1];
    Direction::new(r * phi.cos(), r * phi.sin(), z)
}

/// Reflection as pbrt writes it.
#[map]
fn reflected(n: Direction, wo: Direction) -> Direction {
    require(wo.dot(n) > 0.0);
    Direction::from_vec(-wo + 2.0 * wo.dot(n) * n)
}

#[test]
fn a_bound_after_a_branch_is_a_bound_of_that_branch() {
    let spot = spot_in_two_parts(0.5, 0.75).unwrap();
    both(spot, [0.2, 0.3], 0.5 / (TAU * 0.25));
    both(spot, [0.7, 0.3], 0.5 / (TAU * 0.25));
    assert_eq!(spot.pdf(&Direction::new(0.8, 0.0, 0.6)).value(), 0.5 / (TAU * 0.25));
    assert_eq!(spot.pdf(&Direction::new(0.96, 0.0, 0.28)).value(), 0.0);

    let n = Direction::new(0.6, 0.0, 0.8);
    let wo = Direction::new(0.0, 0.0, 1.0);
    let wi = reflected(wo).apply(&n);
    assert!((wi.vec() - Vec3::new(0.96, 0.0, 0.28)).length() < 1e-15);
    assert_eq!((-wo).vec(), -wo.vec());
}

/// A logistic distribution between a and b, with the bounds that pbrt has.
#[sampler(s in 0.01..=2.0, a in -4.0..=4.0, b in -4.0..=4.0, where a < b)]
fn trimmed_logistic(u: [Uniform; 1], s: f64, a: f64, b: f64) -> f64 {
    let ka = 1.0 / (1.0 + (-a / s).exp());
    let kb = 1.0 / (1.0 + (-b / s).exp());
    let x = -s * (1.0 / (u[0] * (kb - ka) + ka) - 1.0).ln();
    x.clamp(a, b)
}

/// Directions about x, distributed as a hair scatters them (Chiang et al. 2016): a trimmed logistic azimuth.
#[sampler(v in 0.02..=5.0, s in 0.05..=2.0, theta in 0.1..=1.5)]
fn hair_lobe(u: [Uniform; 2], v: f64, s: f64, theta: f64) -> Direction {
    let c = 1.0 + v * (u[0] + (1.0 - u[0]) * (-2.0 / v).exp()).ln();
    let sin_o = theta.sin() * c;
    let k = 1.0 / (1.0 + (-PI / s).exp());
    let k0 = 1.0 / (1.0 + (PI / s).exp());
    let x = -s * (1.0 / (u[1] * (k - k0) + k0) - 1.0).ln();
    let cos_o = (1.0 - sin_o * sin_o).sqrt();
    Direction::new(sin_o, cos_o * x.cos(), cos_o * x.sin())
}

#[test]
fn bounds_that_are_never_passed_and_angles_that_stay_within_a_turn() {
    let logistic = |x: f64, s: f64| {
        let e = (-x.abs() / s).exp();
        e / (s * (1.0 + e) * (1.0 + e))
    };
    let cdf = |x: f64, s: f64| 1.0 / (1.0 + (-x / s).exp());
    for (s, a, b) in [(0.3, -1.0, 2.0), (2.0, 0.5, 4.0)] {
        let trimmed = trimmed_logistic(s, a, b).unwrap();
        for u in [1e-3, 0.3, 0.9] {
            let x = trimmed.sample([u]);
            let expected = logistic(x.value(), s) / (cdf(b, s) - cdf(a, s));
            assert!((trimmed.pdf(&x).value() / expected - 1.0).abs() < 1e-12);
        }
        assert_eq!(trimmed.pdf(&(a - 1e-6)).value(), 0.0);
        assert_eq!(trimmed.pdf(&(b + 1e-6)).value(), 0.0);
    }
    for (v, s, theta) in [(0.1, 0.3, 0.5_f64), (1.0, 0.05, 1.2), (0.5, 2.0, 0.2)] {
        let hair = hair_lobe(v, s, theta).unwrap();
        for u in [[0.3, 0.2], [0.9, 0.7], [0.5, 0.01]] {
            let w = hair.sample(u);
            let c = w.x / theta.sin();
            let along = ((c - 1.0) / v).exp() / (v * (1.0 - (-2.0 / v).exp()) * theta.sin());
            let around = logistic(w.z.atan2(w.y), s) / (cdf(PI, s) - cdf(-PI, s));
            for p in [w.pdf(), hair.pdf(&w)] {
                assert!(
                    (p.value() / (along * around) - 1.0).abs() < 1e-11,
                    "{v} {s} {theta} {u:?}"
                );
            }
        }
    }
}

/// A density on a parallelogram in space that is linear along one side. The place along that side, which the other two tell, enters a quadratic
/// equation: spelled out in coordinates that has hundreds of terms, and no digits are left.
#[sampler(w0 in 0.01..=1.0, w1 in 0.01..=1.0)]
fn linear_along_a_side(
    u: [Uniform; 2],
    w0: f64,
    w1: f64,
    corner: Vec3,
    a: Vec3,
    b: Vec3,
    id: SurfaceId,
) -> SurfacePoint {
    let x = u[0] * (w0 + w1) / (w0 + (w0 * w0 * (1.0 - u[0]) + w1 * w1 * u[0]).sqrt());
    SurfacePoint::new(corner + x * a + u[1] * b, id)
}

#[test]
fn a_quadratic_equation_for_a_place_in_space() {
    let (a, b) = (Vec3::new(1.0, 0.2, 0.0), Vec3::new(0.1, 0.0, 1.5));
    let area = a.cross(b).length();
    for (w0, w1) in [(0.2, 0.9), (1.0, 0.01), (0.5, 0.5)] {
        let corner = Vec3::new(0.0, 1.0, 2.0);
        let side = linear_along_a_side(w0, w1, corner, a, b, SurfaceId(3)).unwrap();
        for [x, y] in [[0.25, 0.5], [0.9, 0.1], [1e-3, 0.999]] {
            let point = SurfacePoint::new(corner + x * a + y * b, SurfaceId(3));
            let expected = 2.0 * (w0 * (1.0 - x) + w1 * x) / ((w0 + w1) * area);
            assert!((side.pdf(&point).value() / expected - 1.0).abs() < 1e-12);
        }
        let outside = SurfacePoint::new(corner + 1.001 * a + 0.5 * b, SurfaceId(3));
        assert_eq!(side.pdf(&outside).value(), 0.0);
    }
}
