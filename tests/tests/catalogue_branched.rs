//! The rows of the catalogue with branches, roots and several preimages, against reference values
//! and through the check battery.

use aether_core::battery::Battery;
use aether_core::prelude::*;
use tests::batteries;
use tests::catalogue::*;
use tests::checks::{right, seen_in_its_plane};
use tests::compare::{IllConditioned, failures, unnoticed, wrong_densities};
use tests::points::{corners, patch};
use tests::reference::{Inputs, Reference};

/// Where the loss is real, and the full condition number is the limit.
const ILL_CONDITIONED: [IllConditioned; 3] = [
    (
        50,
        "sample",
        "two uncorrelated normals in a nearly singular matrix: a difference of equal numbers",
    ),
    (71, "pdf(x)", SMALL_AND_FAR),
    (71, "sample.pdf()", SMALL_AND_FAR),
];

const SMALL_AND_FAR: &str =
    "a rectangle of a millionth at a distance of four: its sides are differences of its bounds";

/// Points at which a row falls short of the exact function: the sampler, which parameters and uniforms, and the reason.
/// Everything else is compared.
type Shortfall = (&'static str, fn(&Inputs, &[f64]) -> bool, &'static str);
const SHORTFALLS: &[Shortfall] = &[
    (
        "cubic",
        |_, u| u == [0.2500009536743164],
        "next to a fold: the share of the second preimage is that of the rounded sample, whose condition number is 1e6",
    ),
    (
        "epanechnikov",
        |_, u| u == [0.0],
        "the foot: the sine of a sixth of a turn is rounded, and the density next to the foot is not zero",
    ),
    (
        "kumaraswamy",
        |p, u| p.scalar("b") == 0.5 && u == LAST,
        "a sample that is rounded onto the pole of the density",
    ),
    (
        "elliptical_grid",
        |_, u| u == [0.9999990463256836; 2],
        "next to the corner, where rounding the coordinates changes the density by 1e-6",
    ),
    (
        "mixture",
        |_, u| u[..1] == LAST,
        "the last uniform of a piece: how far it is from the end is taken from its rounded place in the piece",
    ),
    (
        "sphere_light",
        |p, u| p.scalar("d") == 1e6 && u == [0.3, 0.6],
        "a thousandth at a distance of a million: the rounded point tells its place by 1e-7",
    ),
    (
        "sphere_light",
        |p, u| p.scalar("r") == 0.75 && u[..1] == LAST,
        "the rim, where the density needs differences of squares",
    ),
];

/// The last uniform before one.
const LAST: [f64; 1] = [1.0 - f64::EPSILON / 2.0];

/// The reference data without the shortfalls.
fn reference() -> Reference {
    let mut all = Reference::load_branched();
    let short = |inputs: &Inputs, u: &[f64]| {
        SHORTFALLS.iter().any(|(name, test, _)| *name == inputs.name && test(inputs, u))
    };
    all.points.retain(|p| !short(&p.inputs, &p.u));
    all
}

#[test]
fn samples_and_densities_agree_with_the_reference() {
    let failed = failures(&reference(), &ILL_CONDITIONED);
    assert!(failed.is_empty(), "{} failures:\n{}", failed.len(), failed.join("\n"));
}

/// What is left out falls short indeed.
#[test]
fn every_shortfall_is_one() {
    let all = Reference::load_branched();
    for (name, test, _) in SHORTFALLS {
        let mut left_out = all.clone();
        left_out.points.retain(|p| p.inputs.name == *name && test(&p.inputs, &p.u));
        assert!(!failures(&left_out, &ILL_CONDITIONED).is_empty(), "{name}: {left_out:?}");
    }
}

#[test]
fn queries_have_the_density_of_the_reference() {
    let failed = wrong_densities(&reference());
    assert!(failed.is_empty(), "{} failures:\n{}", failed.len(), failed.join("\n"));
}

#[test]
fn a_density_off_by_one_percent_fails_the_comparison_in_every_row() {
    let reference = reference();
    // Where the reference is a pole or nothing, there is nothing to be noticed.
    let missed: Vec<_> = unnoticed(&reference, &ILL_CONDITIONED)
        .filter(|p| p.pdf_at_rounded.is_finite() && p.pdf_at_rounded > 0.0)
        .collect();
    assert!(missed.is_empty(), "{missed:?}");
}

fn matrix<R: Scalar>() -> Mat3<R> {
    let v = |x, y, z| Vec3::new(R::of(x), R::of(y), R::of(z));
    Mat3::from_cols(v(1.0, 0.125, 0.25), v(0.0, 0.5, 0.0), v(0.25, 0.0, 1.0))
}

fn view<R: Scalar>() -> Direction<R> {
    Direction::from_vec(Vec3::new(R::of(0.48), R::of(0.64), R::of(0.6)))
}

#[test]
fn row_68_zonal_window() {
    fn check<R: Scalar>(window: &impl Sampler<R, Point = Direction<R>>) {
        let turn = core::f64::consts::TAU;
        let battery = Battery::new(window).jumps(0, [-0.25, 0.75]).jumps(1, [2.5, 4.0 - turn]);
        battery.run().assert_ok();
    }
    check(&right(zonal_window(-0.25f64, 0.75, 2.5, 1.5)));
    check(&right(zonal_window(-0.25f32, 0.75, 2.5, 1.5)));
}

#[test]
fn row_69_double_lune() {
    fn check<R: Scalar>(lunes: &impl Sampler<R, Point = Direction<R>>, t: f64) {
        let rims = [-t, t, PI - t, t - PI];
        Battery::new(lunes).jumps(1, rims).run().assert_ok();
    }
    check(&right(double_lune(0.25f64)), 0.25);
    check(&right(double_lune(1.5f64)), 1.5);
    check(&right(double_lune(0.25f32)), 0.25);
}

/// A triangle whose sides are seen under a tenth of a degree.
fn small_triangle<R: Scalar>() -> [Vec3<R>; 3] {
    let v = |x, y| Vec3::new(R::of(x), R::of(y), R::ONE);
    [v(0.3, 0.2), v(0.301, 0.2), v(0.3, 0.2015)]
}

/// A quadrilateral that is no parallelogram.
fn quad<R: Scalar>() -> BilinearQuad<R> {
    let v = |x, y| Vec2::new(R::of(x), R::of(y));
    bilinear_quad(v(0.0, 0.0), v(2.0, 0.25), v(2.5, 1.75), v(-0.25, 1.0))
}

/// Two tilted planes on both sides of the opening.
fn portal<R: Scalar>() -> TiltedPortal<R> {
    let v = |x, y, z| Vec3::new(R::of(x), R::of(y), R::of(z));
    let [n, m] = [v(0.48, -0.64, 0.6), v(0.0, 0.6, 0.8)].map(Direction::from_vec);
    right(tilted_portal(R::of(2.0), v(0.5, 0.25, 3.0), n, v(1.0, -0.5, -2.0), m))
}

/// A line in the plane of the opening has no density, not even one that is no number.
#[test]
fn row_101_lines_in_the_plane_of_the_opening() {
    let portal = portal::<f64>();
    assert!(!portal.sample([0.5, 0.5, 0.0, 0.0]).is_valid());
    let [a, b] = [Vec3::new(4.0, 0.5, 0.0), Vec3::new(-3.0, 0.25, 0.0)].map(Surface::from_vec);
    assert_eq!(portal.pdf(&(a, b)).value(), 0.0);
    assert_eq!(portal.pdf(&(a, a)).value(), 0.0);
    let sample = portal.sample([0.5, 0.5, 1e-3, 0.05]);
    assert!(sample.is_valid() && portal.pdf(&sample).value() > 0.0);
}

/// A corner far from the origin: uniforms below 1e-30 move its point by less than rounding.
#[test]
fn row_104_tetrahedron() {
    let [a, b, c, d] = corners::<f64>();
    Battery::new(&tetrahedron(a, b, c, d)).least(1e-30).run().assert_ok();
}

#[test]
fn row_71_seen_rectangle_passes_the_battery_in_its_plane() {
    let corners = [0.25, -0.375, 1.25, 0.75, -1.0];
    let [x0, y0, x1, y1, z0] = corners;
    seen_in_its_plane(&right(seen_rectangle(x0, y0, x1, y1, z0)), corners);
    let [x0, y0, x1, y1, z0] = corners.map(|x| x as f32);
    seen_in_its_plane(&right(seen_rectangle(x0, y0, x1, y1, z0)), corners);
}

// The battery. Its seeds are fixed; one seed in a million would make a right sampler fail.
batteries! { [double single]
    row_6_tent: right(tent(2.0)), right(tent(0.125));
    row_7_triangular: triangular(-1.0, 0.5, 3.0), triangular(0.0, 0.0, 1.0), triangular(0.0, 1.0, 1.0);
    row_15_student_2: student_2();
    row_16_student: right(student(3.5));
    row_17_laplace: right(laplace(1.5));
    row_32_rational_quadratic: right(rational_quadratic(1.5, 2.5, 0.5));
    row_35_sawtooth: right(sawtooth(3.0)), right(sawtooth(2.5));
    row_43_concentric_disk: concentric_disk();
    row_50_bivariate_normal: right(bivariate_normal(1.5, -0.75, 0.5));
    row_51_ggx_slopes: right(ggx_slopes(0.25));
    row_53_bilinear_density: right(bilinear_density(1.0, 3.0, 5.0, 7.0));
    row_54_bilinear_quad: quad();
    row_56_complex_square: complex_square();
    row_56_complex_square_xy: complex_square_xy();
    row_65_cone: right(cone(0.125)), right(cone(2.0));
    row_66_concentric_hemisphere: concentric_hemisphere();
    row_67_equal_area_octahedral: equal_area_octahedral();
    row_70_seen_triangle: right(seen_triangle(corners()[0], corners()[1], corners()[2]));
    row_71_seen_rectangle: right(seen_rectangle(-0.5, -0.375, 1.25, 0.75, -1.0));
    row_75_henyey_greenstein: right(henyey_greenstein(0.75)), right(henyey_greenstein(-0.5));
    row_76_rayleigh: rayleigh();
    row_77_transformed_cosine: transformed_cosine(matrix());
    row_81_beckmann: right(beckmann(0.25));
    row_82_ggx: right(ggx(0.25)), right(ggx(2.0));
    row_83_anisotropic_ggx: right(anisotropic_ggx(0.125, 0.5));
    row_84_ashikhmin_shirley: right(ashikhmin_shirley(10.0, 40.0));
    row_86_visible_normals: right(visible_normals(0.25, view()));
    row_86_anisotropic_normals: right(anisotropic_normals(0.25, 0.5, view()));
    row_89_reflected_ggx: right(reflected_ggx(0.25, view()));
    row_90_refracted_ggx: right(refracted_ggx(0.25, 1.5, view()));
    row_91_mixture: right(mixture(0.25, 8.0));
    row_92_sheen: right(sheen(0.5));
    row_99_perspective: right(perspective(0.75, 0.5));
    row_116_radial_flow: right(radial_flow(0.75, 1.25));
    row_103_shell: right(shell(0.5, 2.0));
    row_106_scattering_vertex: right(scattering_vertex(corners()[0], 0.75, 2.0, 0.5));
    row_117_affine_coupling: affine_coupling(0.875, 0.5);
}

// In double precision these are in `tests/optimised/tests/manifolds.rs`, where more is checked.
batteries! { [single]
    row_54_bilinear_patch: patch();
    row_47_triangle: triangle(corners()[0], corners()[1], corners()[2]);
    row_48_triangle_heitz: triangle_heitz(corners()[0], corners()[1], corners()[2]);
    row_49_triangle_fold: triangle_fold(corners()[0], corners()[1], corners()[2]);
    row_79_quaternion: quaternion();
    row_94_ellipsoid: right(ellipsoid(2.0, 1.0, 0.5));
    row_96_torus: right(torus(2.0, 0.5));
    row_105_simplex: simplex();
    row_40_helix: right(helix(1.5, 0.25, 20.0));
    row_95_truncated_cone: right(truncated_cone(1.0, 0.25, 2.0));
    row_97_onto_plane: onto_plane(corners()[0], corners()[3], corners()[1]);
    row_101_tilted_portal: portal();
    row_101_portal_segment: right(portal_segment(1.5, 2.0, 1.0));
    row_102_chained_frames: chained_frames();
    row_102_scattered_twice: right(scattered_twice(0.5, 3.0));
    row_111_stick_breaking: stick_breaking();
}

/// One end is half a million units away, and rounded by more than the opening's size and the other end's distance.
#[test]
fn a_far_end_does_not_hide_on_which_side_of_an_opening_the_near_one_is() {
    let v = |x, y, z| Vec3::<f32>::new(x, y, z);
    let unit = |x, z| Direction::from_vec(v(x, 0.0, z));
    let (p, q) = (v(0.0, 0.0, 100.0), v(0.0, 0.0, -0.01));
    let portal = right(tilted_portal(0.001, p, unit(0.6, 0.8), q, unit(0.28, 0.96)));
    for u in [
        [0.250_874_9, 0.607_485_6, 0.599_938_7, 0.504_543_8],
        [0.591_150_9, 0.484_932_72, 0.525_284_35, 0.596_185_3],
    ] {
        let sample = portal.sample(u);
        let ratio = portal.pdf(&sample).value() / sample.pdf().value();
        assert!((ratio - 1.0).abs() < 0.01, "{u:?}: {ratio}");
    }
}

/// Every slice of a polygon has the centre, and two have each border between them, the first and the last one too.
#[test]
fn centre_and_borders_of_a_polygon_count_once() {
    for n in 3..=8 {
        let n = f64::from(n);
        let sampler = right(regular_polygon(n));
        let density = 2.0 / (n * (TAU / n).sin());
        let near = |u: [f64; 2]| {
            let sample = sampler.sample(u);
            for p in [sample.pdf().value(), sampler.pdf(&sample).value()] {
                assert!((p / density - 1.0).abs() < 1e-12, "{n} at {u:?}: {p}, not {density}");
            }
        };
        for k in 0..n as u32 {
            let border = f64::from(k) / n;
            for v in [border, border.next_up(), border.next_down().max(0.0), border + 0.3 / n] {
                [0.0, 1e-20, 1e-9, 0.3, LAST[0]].into_iter().for_each(|u| near([u, v]));
            }
        }
        // On the line through the centre along an opposite side, other slices divide by zero.
        [0.125, 0.375, 0.625, 0.875].into_iter().for_each(|v| near([4e-6, v]));
        assert!((sampler.pdf(&Vec2::new(0.0, 0.0)).value() / density - 1.0).abs() < 1e-12);
    }
    for v in [0.0, 0.1, 0.2, 0.5, 0.8, 0.9999] {
        let sample = pentagon().sample([0.0, v]);
        assert!((sample.pdf() / pentagon().pdf(&sample) - 1.0).abs() < 1e-12);
    }
}

#[test]
fn a_polygon_has_a_whole_number_of_sides() {
    for n in [2.0, 3.5, 5.000_000_000_000_001, 9.0, f64::NAN] {
        let error = regular_polygon(n).unwrap_err().to_string();
        assert!(error.contains("`n in 3..=8`"), "{error}");
    }
}

#[test]
fn where_two_pieces_of_a_line_meet_a_point_counts_once() {
    fn check<R: Scalar>(nu: f64) {
        let student = right(student(R::of(nu)));
        for end in [0.25, 0.75] {
            for k in -200..=200 {
                let u = R::of(end) + R::of(f64::from(k)) * R::EPSILON * R::of(0.25);
                let sample = student.sample([u]);
                let ratio = student.pdf(&sample).value() / sample.pdf().value();
                assert!((ratio.to_f64() - 1.0).abs() < 1e-4, "nu = {nu}, u = {u:?}: {ratio:?}");
            }
        }
    }
    for nu in [0.5, 1.0, 3.5, 17.0, 100.0, 1e3, 1e5] {
        check::<f64>(nu);
        check::<f32>(nu);
    }
}

/// Only in double precision: folds, whose two preimages are one to `f32`, rims within rounding (those of a disk, too), half vectors on a
/// horizon that rounding crosses, and exp(-2 kappa).
mod only_double {
    use super::*;
    batteries! { [double]
        row_16_student_ends: right(student(1.0)), right(student(100.0)), right(student(1e6));
        row_33_cosine: cosine();
        row_34_folds: parabola(), square(), fold();
        row_36_cubic: cubic();
        row_46_elliptical_grid: elliptical_grid();
        row_44_annular_sector: right(annular_sector(1.0, 2.0, 2.5, 3.0));
        row_70_small: { let [a, b, c] = small_triangle(); right(seen_triangle(a, b, c)) };
        row_71_small: right(seen_rectangle(0.25, -0.375, 0.2500001, -0.374999, -1.0));
        row_74_von_mises_fisher: right(von_mises_fisher(10.0)), right(von_mises_fisher(0.01));
        row_74_as_printed: right(von_mises_fisher_as_printed(10.0));
        row_75_as_printed: right(henyey_greenstein_as_printed(0.75));
        row_85_anisotropic_normals_as_printed: right(anisotropic_normals_as_printed(0.25, 0.5, view()));
        row_85_heitz_normals: right(heitz_normals(0.25, view())), right(heitz_normals(0.5, Direction::from_vec(corners()[0])));
        row_90_into_air: right(refracted_ggx(0.25, 0.75, view()));
    }
}
