//! The battery passes samplers written right by hand, and fails the same with one mistake in each.

mod atoms;
mod hand;

use core::f64::consts::{PI, TAU};

use super::*;
use crate::point::{Embedded, SurfaceId};
use hand::*;

/// The names of the checks that fail.
fn failed<const N: usize, P: Space<f64>>(sampler: Hand<N, P>) -> Vec<&'static str> {
    let report = check(&sampler);
    report.failures().map(|f| f.check).collect()
}

#[test]
fn right_samplers_pass() {
    check(&affine()).assert_ok();
    check(&exponential()).assert_ok();
    check(&cauchy()).assert_ok();
    check(&square()).assert_ok();
    check(&fold()).assert_ok();
    check(&disk()).assert_ok();
    check(&ball()).assert_ok();
    check(&cosine_hemisphere()).assert_ok();
    check(&sphere()).assert_ok();
    check(&rectangle()).assert_ok();
}

#[test]
fn what_is_wrong_at_points_fails_without_the_other_checks() {
    let mut wrong = affine();
    assert!(!Battery::<_, f64>::new(&wrong).fails());
    wrong.pdf = |x| 1.01 * (affine().pdf)(x);
    let battery = Battery::<_, f64>::new(&wrong);
    assert!(battery.fails() && battery.run().findings().len() == 6);
    // Its mass alone tells.
    let mut half = affine();
    half.defined = |[u]| u < 0.6;
    assert!(Battery::<_, f64>::new(&half).fails());
}

#[test]
fn a_report_has_a_line_for_each_check() {
    let report = check(&affine());
    assert_eq!(report.findings().len(), 6);
    assert!(report.findings().iter().all(|f| f.verdict == Verdict::Passed));
    assert!(report.to_string().contains("chi-square   ok"), "{report}");
}

#[test]
fn a_right_sampler_passes_with_other_seeds() {
    for seed in 2..7 {
        Battery::<_, f64>::new(&disk()).seed(seed).samples(50_000).run().assert_ok();
        Battery::<_, f64>::new(&cosine_hemisphere()).seed(seed).run().assert_ok();
    }
}

#[test]
fn a_defective_sampler_passes_with_the_mass_that_it_has() {
    let mut half = affine();
    half.defined = |[u]| u < 0.6;
    half.pdf = |x| inside((-2.0..1.0).contains(x), 0.2);
    half.invert = |x| [[if *x < 1.0 { (x + 2.0) / 5.0 } else { NONE }], [NONE]];
    check(&half).assert_ok();
    half.pdf = affine().pdf;
    assert!(failed(half).contains(&"mass"));
}

#[test]
fn a_density_off_by_one_percent_fails() {
    let mut line = exponential();
    line.pdf = |x| inside(*x >= 0.0 && x.is_finite(), 1.01 * (-x).exp());
    assert_eq!(failed(line), ["jacobian", "mass"]);
    let mut directions = cosine_hemisphere();
    directions.pdf = |w| inside(w.z >= 0.0 && finite(w), 1.01 * w.z / PI);
    assert_eq!(failed(directions), ["jacobian", "mass"]);
    let mut volume = ball();
    volume.pdf = |p| inside(p.length_squared() <= 1.0, 0.99 * 0.75 / PI);
    assert_eq!(failed(volume)[..2], ["jacobian", "mass"]);
    let mut surface = rectangle();
    surface.pdf = |p| (rectangle().pdf)(p) * 0.99;
    assert_eq!(failed(surface), ["jacobian"]);
    let mut own = disk();
    own.own_factor = 1.01;
    assert_eq!(failed(own), ["own density", "jacobian"]);
}

#[test]
fn a_missing_factor_fails() {
    let mut uniform = cosine_hemisphere();
    uniform.pdf = |w| inside(w.z >= 0.0 && finite(w), 0.5 / PI);
    assert_eq!(failed(uniform), ["jacobian", "chi-square"]);
}

#[test]
fn a_density_on_the_wrong_side_fails() {
    let mut both_sides = cosine_hemisphere();
    both_sides.pdf = |w| inside(finite(w), w.z.abs() / PI);
    assert_eq!(failed(both_sides), ["mass", "chi-square", "outside"]);
    // The inverse shares the mistake, so that only the forward map gives it away.
    both_sides.invert = |w| [[w.x * w.x + w.y * w.y, turn(w.x, w.y)], [NONE; 2]];
    assert!(failed(both_sides).contains(&"outside"));
}

#[test]
fn a_lost_preimage_fails() {
    let mut lossy = fold();
    lossy.invert = |x| [[0.5 + 0.5 * x.sqrt()], [NONE]];
    assert!(failed(lossy).contains(&"round trip"));
    // The density misses it too.
    lossy.pdf = |x| inside((0.0..=1.0).contains(x), 0.25 / x.sqrt());
    let checks = failed(lossy);
    assert!(checks.contains(&"mass") && checks.contains(&"chi-square"), "{checks:?}");
}

#[test]
fn a_preimage_counted_twice_fails() {
    let mut double = affine();
    double.invert = |x| [[(x + 2.0) / 5.0]; 2];
    double.pdf = |x| inside((-2.0..3.0).contains(x), 0.4);
    assert_eq!(failed(double), ["round trip", "mass", "chi-square"]);
}

#[test]
fn an_inverse_that_leads_elsewhere_fails() {
    let mut astray = disk();
    astray.invert = |p| [[p.length(), turn(p.x, p.y)], [NONE; 2]];
    assert!(failed(astray).contains(&"round trip"));
}

#[test]
fn a_density_off_the_manifold_or_on_another_fails() {
    let mut thick = sphere();
    thick.pdf = |_| 1.0 / (36.0 * PI);
    assert_eq!(failed(thick), ["outside"]);
    let mut any = rectangle();
    any.pdf = |p| inside((0.0..2.0).contains(&p.x) && (0.0..3.0).contains(&p.y), 1.0 / 6.0);
    assert_eq!(failed(any), ["outside"]);
    let mut endless = rectangle();
    endless.pdf = |p| inside(finite(p) && p.surface == SurfaceId(4), 1.0 / 6.0);
    assert_eq!(failed(endless), ["outside"]);
}

#[test]
fn a_density_of_nan_fails() {
    let mut careless = exponential();
    careless.pdf = |x| if *x < 0.0 { 0.0 } else { (-x).exp() };
    assert_eq!(failed(careless), ["outside"]);
}

#[test]
fn a_density_that_misses_part_of_the_support_fails() {
    let mut partial = disk();
    partial.pdf = |p| inside(p.length_squared() <= 1.0 && p.x < 0.9, 1.0 / PI);
    let checks = failed(partial);
    assert!(checks.contains(&"mass") && checks.contains(&"chi-square"), "{checks:?}");
}

/// A sphere by two angles.
fn cover(t: &[f64]) -> Embedded<2, 3> {
    let (theta, phi) = (PI * t[0], TAU * t[1]);
    let w = [theta.sin() * phi.cos(), theta.sin() * phi.sin(), theta.cos()];
    Embedded(core::array::from_fn(|i| CENTRE[i] + 3.0 * w[i]))
}

/// The angles of a point of the sphere.
fn place(x: &[f64]) -> Vec<f64> {
    let d: Vec<f64> = x.iter().zip(CENTRE).map(|(x, c)| x - c).collect();
    vec![d[0].hypot(d[1]).atan2(d[2]) / PI, d[1].atan2(d[0]).rem_euclid(TAU) / TAU]
}

#[test]
fn a_parametrised_surface_integrates() {
    let verdicts = |sampler| {
        let battery = Battery::<_, f64>::new(&sampler).samples(20_000).evaluations(200_000);
        let report = battery.parametrised(cover).located(place).run();
        let of = |check| report.findings().iter().find(|f| f.check == check).map(|f| f.verdict);
        ["jacobian", "mass", "chi-square"].map(of)
    };
    let (passed, failed) = (Some(Verdict::Passed), Some(Verdict::Failed));
    assert_eq!(verdicts(sphere()), [passed; 3]);
    let mut wrong = sphere();
    wrong.pdf = |p| (sphere().pdf)(p) * 1.01;
    assert_eq!(verdicts(wrong), [failed, failed, passed]);
    // As much mass, in other places.
    wrong.pdf = |p| (sphere().pdf)(p) * (1.0 + 0.1 * (p.0[2] - CENTRE[2]));
    assert_eq!(verdicts(wrong), [failed, passed, failed]);
    let half = |x: &[f64]| place(x).into_iter().map(|t| 2.0 * t).collect();
    let right = sphere();
    let battery = Battery::<_, f64>::new(&right).samples(1000).parametrised(cover);
    assert!(battery.located(half).run().failures().any(|f| f.check == "chi-square"));
}

#[test]
fn single_precision() {
    check_f32(&Exponential { rate: 1.0 }).assert_ok();
    let report = check_f32(&Exponential { rate: 1.01 });
    let checks: Vec<_> = report.failures().map(|f| f.check).collect();
    assert_eq!(checks, ["jacobian", "mass"], "{report}");
}

#[test]
fn maps_are_checked_through_a_sampler() {
    check_map(&Stretch { slope: -3.0, claimed: 3.0 }, &exponential()).assert_ok();
    assert!(!check_map(&Stretch { slope: -3.0, claimed: 3.03 }, &exponential()).is_ok());
}
