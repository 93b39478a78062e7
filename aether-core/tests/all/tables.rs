//! Tables: the battery on each, reference values, borders of pieces, random tables, errors.

use aether_core::battery::Battery;
use aether_core::discrete::WeightError;
use aether_core::prelude::*;
use aether_core::tables::*;
use proptest::prelude::*;
use proptest::test_runner::{RngAlgorithm, RngSeed};

/// Zero bins at both ends and inside.
const STEPS: [f64; 6] = [0.0, 1.0, 0.0, 3.0, 2.0, 0.0];
/// A segment that is zero, one that is flat, and zeros at ends of others.
const NODES: [f64; 8] = [0.0, 2.0, 1.0, 0.0, 0.0, 3.0, 3.0, 0.5];
/// Uneven bins, far from zero on one side.
const KNOTS: [f64; 7] = [-3.0, -2.5, 0.0, 0.125, 1.0, 4.0, 4.5];
/// A row and many cells without mass.
const IMAGE: [f64; 12] = [1.0, 0.0, 2.0, 0.0, 0.0, 0.0, 0.5, 3.0, 0.0, 4.0, 1.0, 1.0];

fn numbers<R: Scalar>(values: &[f64]) -> Vec<R> {
    values.iter().map(|v| R::of(*v)).collect()
}
fn axis<R: Scalar>(knots: &[f64]) -> Axis<R> {
    Axis::new(&numbers(knots)).unwrap()
}
fn steps<R: Scalar>() -> PiecewiseConstant1D<R> {
    PiecewiseConstant1D::on(axis(&KNOTS), &numbers(&STEPS)).unwrap()
}
fn polygon<R: Scalar>() -> PiecewiseLinear1D<R> {
    PiecewiseLinear1D::new(&numbers(&NODES)).unwrap()
}
fn spline<R: Scalar>() -> RationalQuadraticSpline<R> {
    let (widths, slopes) = (numbers(&[1.0, 2.0, 0.5]), numbers(&[1.0, 0.3, 2.0, 1.0]));
    RationalQuadraticSpline::new(&widths, axis(&[-1.0, 0.0, 0.2, 2.0]), &slopes).unwrap()
}
fn cells<R: Scalar>() -> PiecewiseConstant2D<R> {
    let y = axis(&[1.0, 1.5, 2.5, 2.75, 4.0]);
    PiecewiseConstant2D::on(axis(&[-1.0, 0.0, 0.5, 2.0]), y, &numbers(&IMAGE)).unwrap()
}
fn bilinear<R: Scalar>() -> PiecewiseLinear2D<R> {
    PiecewiseLinear2D::new(&numbers(&IMAGE), 3).unwrap()
}

/// An image of the sphere.
fn image<R: Scalar>() -> PiecewiseConstant2D<R> {
    PiecewiseConstant2D::latitude_longitude(&numbers(&IMAGE), 3).unwrap()
}

/// The battery in both precisions, with the values at which the density jumps.
macro_rules! battery {
    ($table:ident . $sampler:ident, $($axis:literal: $jumps:expr),*) => {
        Battery::new(&$table::<f64>().$sampler())$(.jumps($axis, $jumps))*.run().assert_ok();
        Battery::new(&$table::<f32>().$sampler())$(.jumps($axis, $jumps))*.run().assert_ok();
    };
}

#[test]
fn step_functions_pass_the_battery() {
    battery!(steps.sampler, 0: KNOTS);
}

#[test]
fn polygons_pass_the_battery() {
    battery!(polygon.sampler, 0: (0..8).map(|k| f64::from(k) / 7.0));
}

#[test]
fn splines_pass_the_battery() {
    battery!(spline.sampler, 0: [-1.0, 0.0, 0.2, 2.0]);
}

#[test]
fn cells_pass_the_battery() {
    battery!(cells.sampler, 0: [-1.0, 0.0, 0.5, 2.0], 1: [1.0, 1.5, 2.5, 2.75, 4.0]);
}

#[test]
fn bilinear_cells_pass_the_battery() {
    battery!(bilinear.sampler, 0: [0.0, 0.5, 1.0], 1: [0.0, 1.0 / 3.0, 2.0 / 3.0, 1.0]);
}

#[test]
fn tables_of_directions_pass_the_battery() {
    let heights = [FRAC_PI_4.cos(), 0.0, -FRAC_PI_4.cos()];
    battery!(image.directions, 0: heights, 1: [0.0, TAU / 3.0, -TAU / 3.0]);
}

#[test]
fn the_battery_notices_a_table_with_wrong_probabilities() {
    /// Samples as one table does, and claims the density of another.
    #[derive(Clone, Copy)]
    struct Liar<'t>(&'t PiecewiseConstant1D, &'t PiecewiseConstant1D);
    impl Sampler<f64> for Liar<'_> {
        type Uniforms = [f64; 1];
        type Point = f64;
        fn forward(&self, u: [f64; 1]) -> (f64, bool) {
            self.0.sampler().forward(u)
        }
        fn pdf(&self, x: &f64) -> Density<Length> {
            self.1.sampler().pdf(x)
        }
        fn pdf_of_uniforms(&self, u: [f64; 1]) -> Density<Length> {
            self.pdf(&self.forward(u).0)
        }
        fn preimages(&self, x: &f64, visit: impl FnMut([f64; 1], bool)) {
            self.0.sampler().preimages(x, visit);
        }
    }
    let (a, b) = ([1.0, 2.0, 3.0], [1.2, 2.0, 3.0]);
    let (a, b) = (PiecewiseConstant1D::new(&a).unwrap(), PiecewiseConstant1D::new(&b).unwrap());
    let report = Battery::new(&Liar(&a, &b)).jumps(0, [1.0 / 3.0, 2.0 / 3.0]).run();
    let failed: Vec<_> = report.failures().map(|finding| finding.check).collect();
    assert!(failed.contains(&"jacobian") && failed.contains(&"chi-square"), "{report}");
}

/// A value and a density at a uniform, to 1e-14 and in `f32` to 4e-6, both relative.
macro_rules! reference {
    ($table:expr, $single:expr, $u:expr, $x:expr, $p:expr) => {
        let sample = $table.sampler().sample([$u]);
        let near = |a: f64, b: f64, tolerance: f64| (a - b).abs() <= tolerance * b.abs();
        assert!(near(*sample, $x, 1e-14), "{} at {}, not {}", *sample, $u, $x);
        assert!(near(sample.pdf().value(), $p, 1e-14), "own {:?}, not {}", sample.pdf(), $p);
        let p = $table.sampler().pdf(&sample);
        assert!(near(p.value(), $p, 1e-12), "{p:?}, not {}", $p);
        let single = $single.sampler().sample([$u as f32]);
        assert!(near(f64::from(*single), $x, 4e-6), "{} at {}, not {}", *single, $u, $x);
        assert!(near(f64::from(single.pdf().value()), $p, 4e-6), "{:?}, not {}", single.pdf(), $p);
    };
}

// The numbers in the following tests were computed with mpmath to 60 digits from the maps as the
// literature has them, and rounded.

#[test]
fn step_functions_have_the_reference_values() {
    let unit = [1.0, 0.0, 3.0];
    let (table, single) = (
        PiecewiseConstant1D::new(&unit).unwrap(),
        PiecewiseConstant1D::<f32>::new(&numbers(&unit)).unwrap(),
    );
    reference!(table, single, 0.1, 0.13333333333333333, 0.75);
    reference!(table, single, 0.7, 0.8666666666666667, 2.25);
    let (knots, values) = ([-3.0, -1.0, 0.0, 0.5, 8.0], [0.1, 0.7, 0.2, 0.4]);
    let table = PiecewiseConstant1D::on(axis(&knots), &values).unwrap();
    let single = PiecewiseConstant1D::<f32>::on(axis(&knots), &numbers(&values)).unwrap();
    reference!(table, single, 0.9, 7.0, 0.1);
    reference!(table, single, 1e-20, -3.0, 0.025);
}

#[test]
fn polygons_have_the_reference_values() {
    let nodes = [0.0, 2.0, 1.0];
    let (table, single) = (
        PiecewiseLinear1D::new(&nodes).unwrap(),
        PiecewiseLinear1D::<f32>::new(&numbers(&nodes)).unwrap(),
    );
    reference!(table, single, 0.3, 0.4330127018922193, 1.3856406460551018);
    reference!(table, single, 0.9, 0.8876275643042055, 0.9797958971132712);
    reference!(table, single, 1e-20, 7.905694150420948e-11, 2.5298221281347035e-10);
    let (knots, values) = ([-2.0, -1.0, 3.0, 3.5], [1.0, 0.0, 0.0, 4.0]);
    let table = PiecewiseLinear1D::on(axis(&knots), &values).unwrap();
    let single = PiecewiseLinear1D::<f32>::on(axis(&knots), &numbers(&values)).unwrap();
    reference!(table, single, 0.999, 3.4996248592694323, 2.6646659161036386);
    reference!(table, single, 0.2, -1.6324555320336758, 0.4216370213557839);
}

#[test]
fn splines_have_the_reference_values() {
    let (table, single) = (spline::<f64>(), spline::<f32>());
    reference!(table, single, 0.1, -0.6023794614902943, 0.2146628229946974);
    reference!(table, single, 0.6, 0.034876625099495885, 13.356614905810286);
    reference!(table, single, 0.99, 1.959925788497217, 0.19687702304073978);
}

#[test]
fn bilinear_cells_have_the_reference_values() {
    let near = |a: f64, b: f64| assert!((a - b).abs() <= 1e-14 * b, "{a}, not {b}");
    let check = |corners: [f64; 4], u: [f64; 2], at: [f64; 2], p: f64| {
        let table = PiecewiseLinear2D::new(&corners, 2).unwrap();
        let sample = table.sampler().sample(u);
        near(sample.x, at[0]);
        near(sample.y, at[1]);
        near(sample.pdf().value(), p);
        near(table.sampler().pdf(&sample).value(), p);
    };
    let at = [0.37247921644897164, 0.30622577482985497];
    check([1.0, 3.0, 5.0, 7.0], [0.3, 0.2], at, 0.7424653830543408);
    let at = [1e-06; 2];
    check([0.0, 0.0, 0.0, 1.0], [1e-12; 2], at, 4e-12);
    check([2.0; 4], [0.25, 0.75], [0.25, 0.75], 1.0);
}

#[test]
fn directions_have_the_reference_values() {
    let table = PiecewiseConstant2D::new(&IMAGE, 3).unwrap();
    let check = |u: [f64; 2], direction: [f64; 3], p: f64| {
        let sample = table.directions().sample(u);
        for (c, expected) in sample.to_array().iter().zip(direction) {
            assert!((c - expected).abs() <= 1e-15, "{sample:?}, not {direction:?}");
        }
        let condition = 1.0 / (direction[0].powi(2) + direction[1].powi(2)).sqrt();
        let found = table.directions().pdf(&sample).value();
        assert!((found - p).abs() <= 1e-14 * condition * p, "{found}, not {p}");
        assert!((sample.pdf().value() - p).abs() <= 1e-14 * condition * p);
    };
    check(
        [0.3, 0.2],
        [-0.18811762708367274, 0.5789665239278934, 0.7933533402912352],
        0.07989035742214448,
    );
    check(
        [0.6, 0.1],
        [0.09933025744147317, -0.30570709807100177, 0.9469301294951057],
        0.3026023459966462,
    );
    check(
        [0.9, 0.99],
        [0.005056053129986474, -0.015560931481242768, -0.9998661379095618],
        2.9724340466257173,
    );
    check([0.25, 1e-9], [0.0, 3.2724923474893684e-09, 1.0], 14861507.066818323);
}

/// Uniforms on the knots of the choice, beside them, and at the ends.
fn extreme_uniforms() -> impl Iterator<Item = f64> {
    let shares = (0..=60).map(|k| f64::from(k) / 60.0);
    shares
        .flat_map(|u| [u, u.next_up(), u.next_down(), u * 1e-300])
        .chain([f64::MIN_POSITIVE, 1.0 / (1_u64 << 53) as f64])
        .filter(|u| (0.0..1.0).contains(u))
}

/// Every sample lies in a piece with mass, has a density, also when both are asked for at once, and is found again.
fn sound<S: Sampler<f64>>(sampler: &S, u: impl Fn(f64) -> S::Uniforms) {
    sound_to(1e-12, sampler, u);
}

/// [`sound`] with another tolerance.
fn sound_to<S: Sampler<f64>>(tolerance: f64, sampler: &S, u: impl Fn(f64) -> S::Uniforms) {
    for t in extreme_uniforms() {
        let sample = sampler.sample(u(t));
        if !sample.is_valid() {
            continue;
        }
        let (own, p) = (sample.pdf().value(), sampler.pdf(&sample).value());
        let (point, valid, density) = sampler.forward_with_pdf(u(t));
        assert!(valid && density.value() == own, "{density:?} {own} at {t}");
        assert_eq!(point.coordinates().as_ref(), sample.coordinates().as_ref());
        // A direction is rounded relative to its length, and its density goes by its distance from the pole.
        let pole = match sample.coordinates().as_ref() {
            [x, y, _] => x.hypot(*y),
            _ => 1.0,
        };
        assert!(
            sample.finite()
                && own.is_finite()
                && (own - p).abs() <= (1e-9 + 1e-15 / pole) * p + 1e-12,
            "{own} {p} at {t}"
        );
        let found = sampler.invert(&sample);
        assert_eq!(found.len(), 1, "preimages {found:?} of {:?}", sample.value());
        // Where the density is next to zero only the uniforms are near, where it is high only the point.
        let near = |a: &[f64], b: &[f64]| {
            a.iter().zip(b).all(|(a, b)| (a - b).abs() <= tolerance * b.abs().max(1.0))
        };
        let v = found.iter().next().unwrap();
        let back = sampler.forward(v).0;
        assert!(
            near(v.as_ref(), u(t).as_ref())
                || near(back.coordinates().as_ref(), sample.coordinates().as_ref()),
            "{v:?} back to {back:?}, not {:?}",
            sample.value()
        );
    }
}

#[test]
fn uniforms_on_knots_make_sound_samples() {
    sound(&steps::<f64>().sampler(), |t| [t]);
    sound(&polygon::<f64>().sampler(), |t| [t]);
    sound(&spline::<f64>().sampler(), |t| [t]);
    for v in extreme_uniforms().step_by(7) {
        sound(&cells::<f64>().sampler(), |t| [t, v]);
        sound(&cells::<f64>().sampler(), |t| [v, t]);
        sound(&bilinear::<f64>().sampler(), |t| [t, v]);
        sound(&bilinear::<f64>().sampler(), |t| [v, t]);
        let image = PiecewiseConstant2D::new(&IMAGE, 3).unwrap();
        sound(&image.directions(), |t| [t, v]);
        sound(&image.directions(), |t| [v, t]);
    }
    let steps = steps::<f64>();
    let samples = extreme_uniforms().map(|u| *steps.sampler().sample([u]));
    samples.for_each(|x| assert!(steps.sampler().pdf(&x).value() > 0.0, "{x} in a zero bin"));
}

#[test]
fn samples_on_borders_survive_a_map_and_back_in_single_precision() {
    // Texels between texels without mass: a point that comes back in the next one has no density there.
    let values: Vec<f32> = (0..64 * 32).map(|k| ((k % 64 + k / 64) % 2) as f32).collect();
    let table = PiecewiseConstant2D::new(&values, 64).unwrap();
    for k in 0..32 * 32 {
        let u = [(k % 32) as f32 / 32.0, ((k / 32) as f32 / 32.0).max(1e-6)];
        let sample = table.directions().sample(u);
        assert!(sample.pdf().value() > 0.0, "no density at {:?} of {u:?}", sample.value());
        assert_eq!(table.directions().invert(&sample).len(), 1, "{u:?}");
    }
}

#[test]
fn there_is_no_density_outside_nor_in_zero_bins() {
    let steps = steps::<f64>();
    for x in [-3.1, -2.9, 0.06, 4.2, 4.6, f64::NAN, f64::INFINITY, f64::NEG_INFINITY, -f64::MAX] {
        assert_eq!(steps.sampler().pdf(&x).value(), 0.0, "{x}");
        assert!(steps.sampler().invert(&x).is_empty(), "{x}");
    }
    let cells = cells::<f32>();
    for p in [(0.2, 1.2), (-0.5, 2.0), (f32::NAN, 1.2), (-0.5, f32::NAN), (-1.5, 1.2), (-0.5, 5.0)]
    {
        let p = Vec2::new(p.0, p.1);
        assert_eq!(cells.sampler().pdf(&p).value(), 0.0, "{p:?}");
        assert!(cells.sampler().invert(&p).is_empty(), "{p:?}");
    }
}

#[test]
fn huge_and_tiny_values_are_but_ratios() {
    for scale in [1e-310, 1e-160, 1e160, 5e307] {
        let values = [0.0, 2.0 * scale, scale];
        let x = *PiecewiseLinear1D::new(&values).unwrap().sampler().sample([0.3]);
        assert!((x - 0.4330127018922193).abs() < 1e-10, "{x} with {values:?}");
        let corners = [scale, 3.0 * scale, 3.0 * scale, scale];
        let p = PiecewiseLinear2D::new(&corners, 2).unwrap().sampler().pdf(&Vec2::new(0.5, 0.5));
        assert!((p.value() - 1.0).abs() < 1e-10, "{p:?} with {corners:?}");
    }
    // One cell with most of the mass, and a corner that is next to nothing beside another.
    let table = PiecewiseLinear2D::new(&[1e-200, 0.0, 1e-250, 1.0], 2).unwrap();
    sound(&table.sampler(), |t| [t, 0.0]);
    sound(&table.sampler(), |t| [0.0, t]);
}

#[test]
fn bad_tables_are_named() {
    let text = |error: TableError| error.to_string();
    let weights = |error| TableError::Weights(error);
    assert_eq!(PiecewiseConstant1D::<f64>::new(&[]).unwrap_err(), weights(WeightError::Empty));
    assert_eq!(PiecewiseLinear1D::new(&[0.0; 3]).unwrap_err(), weights(WeightError::AllZero));
    let negative = PiecewiseConstant2D::new(&[1.0, 1.0, -0.5, 1.0], 2).unwrap_err();
    assert_eq!(
        text(negative),
        "values of a table: weight 2 is -0.5: weights are finite and not negative"
    );
    for bad in [f64::NAN, f64::INFINITY] {
        assert!(
            text(PiecewiseLinear2D::new(&[1.0, bad, 1.0, 1.0], 2).unwrap_err())
                .contains("weight 1")
        );
        assert!(text(PiecewiseLinear1D::new(&[1.0, bad]).unwrap_err()).contains("weight 1"));
        assert!(text(PiecewiseConstant1D::new(&[bad]).unwrap_err()).contains("weight 0"));
        assert!(
            text(PiecewiseConstant2D::latitude_longitude(&[bad], 1).unwrap_err())
                .contains("weight 0")
        );
        assert!(Axis::new(&[0.0, bad]).is_err() && Axis::even(bad, 1.0, 2).is_err());
    }
    let ragged = PiecewiseConstant2D::new(&[1.0; 5], 2).unwrap_err();
    assert_eq!(text(ragged), "5 values where the table needs 4");
    assert!(PiecewiseConstant2D::new(&[1.0; 4], 0).is_err());
    assert!(PiecewiseConstant2D::latitude_longitude(&[1.0; 5], 2).is_err());
    assert!(PiecewiseLinear2D::new(&[1.0; 2], 2).is_err());
    assert!(PiecewiseLinear2D::new(&[1.0; 2], 0).is_err());
    assert!(PiecewiseLinear1D::new(&[1.0]).is_err());
    let descending = Axis::new(&[0.0, 2.0, 1.0]).unwrap_err();
    assert_eq!(descending, TableError::Knot { index: 2, value: 1.0 });
    assert!(Axis::<f64>::new(&[]).is_err() && Axis::new(&[1.0]).is_err());
    assert!(Axis::new(&[-f64::MAX, f64::MAX]).is_err());
    assert!(Axis::even(1.0, 1.0_f32.next_up(), 2).is_err() && Axis::even(0.0, 1.0, 0).is_err());
    let steep = RationalQuadraticSpline::new(&[1.0], axis(&[0.0, 1.0]), &[1.0, -1.0]).unwrap_err();
    assert!(text(steep).starts_with("piece 0 of a table"));
    assert!(RationalQuadraticSpline::new(&[1.0, 0.0], axis(&[0.0, 1.0, 2.0]), &[1.0; 3]).is_err());
}

fn settings() -> ProptestConfig {
    ProptestConfig {
        cases: 300,
        failure_persistence: None,
        rng_algorithm: RngAlgorithm::ChaCha,
        rng_seed: RngSeed::Fixed(20_170_730),
        ..ProptestConfig::default()
    }
}

/// Many zeros, many equal, and some of very different size.
fn values(count: core::ops::Range<usize>) -> impl Strategy<Value = Vec<f64>> {
    let value = prop_oneof![
        3 => Just(0.0),
        2 => Just(1.0),
        3 => 0.01..10.0_f64,
        1 => (-12.0..3.0_f64).prop_map(|e| 10.0_f64.powf(e)),
    ];
    proptest::collection::vec(value, count).prop_filter("some mass", |v| v.iter().any(|v| *v > 0.0))
}

/// Increasing knots for `bins` bins.
fn knots(bins: usize) -> impl Strategy<Value = Vec<f64>> {
    (-5.0..5.0_f64, proptest::collection::vec(0.01..3.0_f64, bins)).prop_map(|(low, widths)| {
        let mut all = vec![low];
        widths.iter().for_each(|w| all.push(all[all.len() - 1] + w));
        all
    })
}

/// The integral of a density over each bin by Gauss's rule with two points: exact for lines.
fn masses(knots: &[f64], p: impl Fn(f64) -> f64) -> Vec<f64> {
    let offset = 0.75_f64.sqrt() / 3.0;
    let gauss = |pair: &[f64]| {
        let at = |t: f64| p(pair[0] + (pair[1] - pair[0]) * t);
        (at(0.5 - offset) + at(0.5 + offset)) * 0.5 * (pair[1] - pair[0])
    };
    knots.windows(2).map(gauss).collect()
}

proptest! {
    #![proptest_config(settings())]

    #[test]
    fn random_tables_on_the_line(
        (values, knots) in values(2..20).prop_flat_map(|v| { let n = v.len(); (Just(v), knots(n)) }),
        u in 0.0..1.0_f64,
    ) {
        let inner = &knots[..knots.len() - 1];
        let table = PiecewiseConstant1D::on(axis(&knots), &values).unwrap();
        let polygon = PiecewiseLinear1D::on(axis(inner), &values).unwrap();
        for mass in [
            masses(&knots, |x| table.sampler().pdf(&x).value()),
            masses(inner, |x| polygon.sampler().pdf(&x).value()),
        ] {
            let total: f64 = mass.iter().sum();
            prop_assert!((total - 1.0).abs() < 1e-12, "{total}: {mass:?}");
        }
        // The density is the values up to one factor.
        let ratio: f64 = values.iter().zip(knots.windows(2)).map(|(v, k)| v * (k[1] - k[0])).sum();
        for (v, k) in values.iter().zip(knots.windows(2)) {
            let p = table.sampler().pdf(&(0.5 * (k[0] + k[1]))).value();
            prop_assert!((p - v / ratio).abs() <= 1e-13 * (v / ratio) + 1e-13, "{p} for {v}");
            prop_assert_eq!(p == 0.0, *v == 0.0);
        }
        // The cumulative distribution at a sample is its uniform.
        let x = *table.sampler().sample([u]);
        let below: f64 = values.iter().zip(knots.windows(2))
            .map(|(v, k)| v * (x.clamp(k[0], k[1]) - k[0])).sum::<f64>() / ratio;
        prop_assert!((below - u).abs() < 1e-12, "{below} below the sample of {u}");
        sound(&table.sampler(), |t| [t]);
        sound(&polygon.sampler(), |t| [t]);
        let back = polygon.sampler().invert(&polygon.sampler().sample([u]));
        prop_assert!(back.iter().any(|v| (v[0] - u).abs() < 1e-7), "{back:?}, not {u}");
    }

    #[test]
    fn random_tables_in_the_plane(
        columns in 2..5_usize,
        rows in proptest::collection::vec(values(4..5), 2..5),
        u in [0.0..1.0_f64, 0.0..1.0_f64],
    ) {
        let values: Vec<f64> = rows.iter().flat_map(|row| row[..columns].to_vec()).collect();
        prop_assume!(values.iter().any(|v| *v > 0.0));
        let table = PiecewiseConstant2D::new(&values, columns).unwrap();
        let count = rows.len();
        let total: f64 = (0..count * columns).map(|k| table.grid().probability(k % columns, k / columns)).sum();
        prop_assert!((total - 1.0).abs() < 1e-13);
        let mean = values.iter().sum::<f64>() / values.len() as f64;
        for (k, v) in values.iter().enumerate() {
            let centre = Vec2::new(
                ((k % columns) as f64 + 0.5) / columns as f64,
                ((k / columns) as f64 + 0.5) / count as f64,
            );
            let p = table.sampler().pdf(&centre).value();
            prop_assert!((p - v / mean).abs() <= 1e-12 * p + 1e-13, "{p} for {v} of {values:?}");
        }
        sound(&table.sampler(), |t| [t, u[1]]);
        sound(&table.sampler(), |t| [u[0], t]);
        // Where lines of very different slopes meet, x is conditioned badly in y: by their ratio.
        let values: Vec<f64> = values.iter().map(|v| if *v > 0.0 { v.max(0.01) } else { 0.0 }).collect();
        let smooth = PiecewiseLinear2D::new(&values, columns).unwrap();
        let least = values.iter().copied().filter(|v| *v > 0.0).fold(f64::INFINITY, f64::min);
        let condition = values.iter().copied().fold(0.0, f64::max) / least;
        sound_to(1e-13 * condition.max(10.0), &smooth.sampler(), |t| [t, u[1]]);
        sound_to(1e-13 * condition.max(10.0), &smooth.sampler(), |t| [u[0], t]);
        let sample = smooth.sampler().sample(u);
        let back = smooth.sampler().invert(&sample);
        prop_assert!(back.iter().any(|v| (v[0] - u[0]).abs() + (v[1] - u[1]).abs() < 1e-6), "{back:?}, not {u:?}");
        // Interpolated, at the sample, over the mean of all cells.
        let (x, y) = (sample.x * (columns - 1) as f64, sample.y * (count - 1) as f64);
        let (i, j) = ((x as usize).min(columns - 2), (y as usize).min(count - 2));
        let at = |i: usize, j: usize| values[j * columns + i];
        let (s, t) = (x - i as f64, y - j as f64);
        let bottom = (1.0 - s) * at(i, j) + s * at(i + 1, j);
        let top = (1.0 - s) * at(i, j + 1) + s * at(i + 1, j + 1);
        let value = (1.0 - t) * bottom + t * top;
        let four = |k: usize| { let (i, j) = (k % (columns - 1), k / (columns - 1)); at(i, j) + at(i + 1, j) + at(i, j + 1) + at(i + 1, j + 1) };
        let cells = (columns - 1) * (count - 1);
        let mean = (0..cells).map(four).sum::<f64>() / (4 * cells) as f64;
        let p = sample.pdf().value();
        prop_assert!((p - value / mean).abs() <= 1e-7 * p + 1e-12, "{p}, not {}", value / mean);
    }
}

/// A uniform next to one has no room for the digits that the coordinates of a direction have there.
#[test]
fn directions_next_to_the_far_pole_keep_their_digits() -> Result<(), TableError> {
    let table = PiecewiseConstant2D::new(&[1.0; 6], 3)?;
    for sine in [1e-7, 1e-11, 1e-15] {
        let below = Direction::new(0.6 * sine, 0.8 * sine, -1.0);
        let density = table.directions().pdf(&below).value() * 2.0 * PI * PI * sine;
        assert!((density - 1.0).abs() < 1e-12, "{density} at {sine}");
        let log = table.directions().log_pdf(&below) + (2.0 * PI * PI * sine).ln();
        assert!(log.abs() < 1e-12, "{log} at {sine}");
    }
    Ok(())
}

#[test]
fn more_digits_leave_a_table_as_it_is() -> Result<(), TableError> {
    // Weights that single precision has not; a bin of which it has not a digit right.
    let values = [0.1, 0.7, 0.0, 1e-7, 0.3, 0.9];
    let (line, square) = (
        PiecewiseConstant1D::new(&numbers::<f32>(&values))?,
        PiecewiseConstant2D::new(&numbers::<f32>(&values), 3)?,
    );
    let nodes = PiecewiseLinear2D::new(&numbers::<f32>(&values), 3)?;
    for k in 0..1000 {
        let [u, v] = [0.618034, 0.754878].map(|step: f32| (k as f32 * step).fract());
        let near = |a: f32, b: f64| assert!((f64::from(a) - b).abs() <= 1e-5 * b, "{a} {b}");
        let wide = [f64::from(u), f64::from(v)];
        // The same pieces and the same probabilities: densities differ by the rounding of what is computed alone.
        near(
            line.sampler().sample([u]).pdf().value(),
            line.cast::<f64>()?.sampler().sample([wide[0]]).pdf().value(),
        );
        near(
            square.sampler().sample([u, v]).pdf().value(),
            square.cast::<f64>()?.sampler().sample(wide).pdf().value(),
        );
        near(
            nodes.sampler().sample([u, v]).pdf().value(),
            nodes.cast::<f64>()?.sampler().sample(wide).pdf().value(),
        );
    }
    let other = PiecewiseConstant1D::new(&values)?;
    let differs = |x: f64| {
        other.sampler().pdf(&x).value() / line.cast::<f64>().unwrap().sampler().pdf(&x).value()
    };
    assert!((differs(0.6) - 1.0).abs() > 1e-3, "{}", differs(0.6));
    assert!(Axis::<f64>::new(&[1.0, 1.0 + 1e-12])?.cast::<f32>().is_err());
    Ok(())
}

#[test]
fn a_table_of_too_few_nodes_names_what_it_was_given() {
    let message = |error: Option<TableError>| error.map_or(String::new(), |e| e.to_string());
    assert_eq!(
        message(PiecewiseLinear1D::new(&[1.0]).err()),
        "1 values where the table needs 2 or more"
    );
    assert_eq!(
        message(PiecewiseLinear2D::new(&[1.0, 2.0], 1).err()),
        "1 nodes in a row where the table needs 2 or more"
    );
    assert_eq!(
        message(PiecewiseLinear2D::new(&[1.0, 2.0, 3.0], 3).err()),
        "1 rows of nodes where the table needs 2 or more"
    );
    // No table has half a row.
    assert_eq!(
        message(PiecewiseLinear2D::new(&[1.0; 5], 2).err()),
        "5 values where the table needs 4"
    );
    assert_eq!(
        message(PiecewiseConstant2D::new(&[1.0], 0).err()),
        "0 values in a row where the table needs 1 or more"
    );
}
