//! Samplers that turn back, where no formula undoes them: a numerical root on each piece on which they are monotone.
//!
//! What the forward map says by itself is the oracle: a scan of it finds the preimages, and slopes in closed form the
//! density.

use aether_core::battery::{Battery, check};
use aether_core::prelude::*;
use aether_core::{Pcg32, draw_uniforms};
use tests::checks::covered;

/// Turns where 5 u⁴ = 1, at a place that nothing moves.
#[sampler]
fn quintic(u: [Uniform; 1]) -> f64 {
    u[0].powi(5) - u[0]
}

/// The parameter moves two turning points, of which one or both leave the unit interval.
#[sampler(k in 0.0..=8.0)]
fn moved(u: [Uniform; 1], k: f64) -> f64 {
    u[0].powi(5) - k * u[0].powi(2) + u[0].exp()
}

/// A turn that starts at the upper end, and wanders down to the lower one.
#[sampler(k in 0.0..=20.0)]
fn decay(u: [Uniform; 1], k: f64) -> f64 {
    u[0] * (-k * u[0]).exp() - 0.05 * u[0].powi(2)
}

/// Three pieces.
#[sampler]
fn ripple(u: [Uniform; 1]) -> f64 {
    (5.0 * u[0]).sin() + u[0]
}

/// Six pieces.
#[sampler(k in 0.9..=1.1)]
fn ripples(u: [Uniform; 1], k: f64) -> f64 {
    k * (16.0 * u[0]).sin() + u[0]
}

/// Two turning points that appear together where the parameter becomes negative.
#[sampler(k in -0.5..=0.5)]
fn folding(u: [Uniform; 1], k: f64) -> f64 {
    (u[0] - 0.3).powi(3) + 0.1 * k * (u[0].powi(2).sin() + u[0])
}

/// Polar coordinates with a radius that turns back.
#[sampler(k in 0.0..=2.0)]
fn ring(u: [Uniform; 2], k: f64) -> Vec2 {
    let r = 2.0 + u[0].powi(5) - k * u[0];
    let phi = TAU * u[1];
    Vec2::new(r * phi.cos(), r * phi.sin())
}

/// The second coordinate has no closed inverse either, and depends on the first uniform.
#[sampler(k in 0.0..=2.0)]
fn product(u: [Uniform; 2], k: f64) -> Vec2 {
    let x = u[0].powi(5) - k * u[0];
    let y = u[1] + 0.2 * u[0] * (PI * u[1]).sin();
    Vec2::new(x, y)
}

/// Both coordinates by way of one wave along a line: one equation for the place along it.
#[sampler(k in 0.0..=0.5)]
fn sheared(u: [Uniform; 2], k: f64) -> Vec2 {
    let wave = k * (3.0 * (u[0] + u[1])).sin();
    Vec2::new(u[0] + wave, u[1] + 0.5 * wave)
}

/// Where a function crosses a value between 0 and 1, by a scan.
fn scan(f: &dyn Fn(f64) -> f64, x: f64) -> Vec<f64> {
    const STEPS: usize = 20_000;
    let mut found = Vec::new();
    let mut last = (0.0, f(0.0));
    for i in 1..=STEPS {
        let u = i as f64 / STEPS as f64;
        let next = (u, f(u));
        if (last.1 > x) != (next.1 > x) {
            let (mut a, mut b) = (last.0, next.0);
            for _ in 0..60 {
                let m = 0.5 * (a + b);
                if (f(m) > x) == (last.1 > x) { a = m } else { b = m }
            }
            found.push(0.5 * (a + b));
        }
        last = next;
    }
    found
}

/// Compares preimages and densities of random samples with a scan of the map and its slope; says how many preimages
/// there were at most.
fn scanned<S>(sampler: &S, f: &dyn Fn(f64) -> f64, slope: &dyn Fn(f64) -> f64) -> usize
where
    S: Sampler<f64, Uniforms = [f64; 1], Point = f64>,
{
    let mut random = Pcg32::new(3, 1, 0);
    let mut most = 0;
    for _ in 0..200 {
        let [u]: [f64; 1] = draw_uniforms(&mut random);
        let sample = sampler.sample([u]);
        let x = sample.value();
        assert!((x - f(u)).abs() <= 4e-16 * (1.0 + x.abs()), "{u}: {x}");
        let expected = scan(f, x);
        let mut found: Vec<f64> = sampler.invert(&x).iter().map(|v| v[0]).collect();
        found.sort_by(f64::total_cmp);
        assert_eq!(found.len(), expected.len(), "{u}: {found:?}, by a scan {expected:?}");
        let mut density = 0.0;
        for (v, w) in found.iter().zip(&expected) {
            let error = 1e-15 / slope(*w).abs();
            assert!((v - w).abs() <= 8.0 * error + 1e-15, "{u}: {v}, by a scan {w}");
            density += 1.0 / slope(*w).abs();
        }
        for p in [sampler.pdf(&x).value(), sample.pdf().value()] {
            let worst = expected.iter().map(|w| slope(*w).abs()).fold(f64::INFINITY, f64::min);
            assert!((p / density - 1.0).abs() <= 1e-12 / worst.powi(2), "{u}: {p}, {density}");
        }
        most = most.max(found.len());
    }
    most
}

#[test]
fn preimages_and_densities_are_those_of_a_scan() {
    let five = |f: fn(f64) -> f64, slope: fn(f64) -> f64| (f, slope);
    let (f, slope) = five(|u| u.powi(5) - u, |u| 5.0 * u.powi(4) - 1.0);
    assert_eq!(scanned(&quintic(), &f, &slope), 2);
    let (f, slope) = five(|u| (5.0 * u).sin() + u, |u| 5.0 * (5.0 * u).cos() + 1.0);
    assert_eq!(scanned(&ripple(), &f, &slope), 3);
    for (k, most) in [(0.0, 1), (1.0, 1), (2.0, 3), (3.0, 2), (8.0, 2)] {
        let f = move |u: f64| u.powi(5) - k * u.powi(2) + u.exp();
        let slope = move |u: f64| 5.0 * u.powi(4) - 2.0 * k * u + u.exp();
        assert_eq!(scanned(&moved(k).unwrap(), &f, &slope), most, "{k}");
    }
    for (k, most) in [(0.0, 1), (0.9, 2), (2.0, 2), (20.0, 2)] {
        let f = move |u: f64| u * (-k * u).exp() - 0.05 * u * u;
        let slope = move |u: f64| (1.0 - k * u) * (-k * u).exp() - 0.1 * u;
        assert_eq!(scanned(&decay(k).unwrap(), &f, &slope), most, "{k}");
    }
    for k in [0.9, 1.0, 1.1] {
        let f = move |u: f64| k * (16.0 * u).sin() + u;
        let slope = move |u: f64| 16.0 * k * (16.0 * u).cos() + 1.0;
        assert_eq!(scanned(&ripples(k).unwrap(), &f, &slope), 6, "{k}");
    }
    for (k, most) in [(-0.5, 3), (-0.1, 3), (-1e-3, 3), (1e-3, 1), (0.5, 1)] {
        let f = move |u: f64| (u - 0.3).powi(3) + 0.1 * k * (u.powi(2).sin() + u);
        let slope =
            move |u: f64| 3.0 * (u - 0.3).powi(2) + 0.1 * k * (2.0 * u * u.powi(2).cos() + 1.0);
        assert_eq!(scanned(&folding(k).unwrap(), &f, &slope), most, "{k}");
    }
}

/// The battery over the values of a function, cut where it turns and ends, with poles on both sides of each cut.
fn battery<S>(sampler: S, f: &dyn Fn(f64) -> f64, slope: &dyn Fn(f64) -> f64)
where
    S: Sampler<f64, Uniforms = [f64; 1], Point = f64>,
{
    let mut cuts: Vec<f64> = scan(slope, 0.0).into_iter().chain([0.0, 1.0]).map(f).collect();
    cuts.sort_by(f64::total_cmp);
    let parts = (cuts.len() - 1) as f64;
    let at = |t: &[f64]| {
        let k = (t[0] * parts).min(parts - 1.0).floor();
        let share = (0.5 * PI * (t[0] * parts - k)).sin().powi(2);
        let (low, high) = (cuts[k as usize], cuts[k as usize + 1]);
        low + (high - low) * share
    };
    let place = |x: &[f64]| {
        let k = cuts[1..cuts.len() - 1].partition_point(|c| *c <= x[0]);
        let share = ((x[0] - cuts[k]) / (cuts[k + 1] - cuts[k])).clamp(0.0, 1.0);
        vec![(k as f64 + share.sqrt().asin() / (0.5 * PI)) / parts]
    };
    covered(sampler, at, place);
}

#[test]
fn numbers_pass_the_battery() {
    check(&quintic()).assert_ok();
    battery(quintic(), &|u| u.powi(5) - u, &|u| 5.0 * u.powi(4) - 1.0);
    battery(ripple(), &|u| (5.0 * u).sin() + u, &|u| 5.0 * (5.0 * u).cos() + 1.0);
    for k in [2.0, 8.0] {
        let f = |u: f64| u.powi(5) - k * u.powi(2) + u.exp();
        let slope = |u: f64| 5.0 * u.powi(4) - 2.0 * k * u + u.exp();
        battery(moved(k).unwrap(), &f, &slope);
    }
}

#[test]
fn numbers_by_pieces_that_may_vanish_pass_the_battery() {
    let k = 20.0;
    let f = |u: f64| u * (-k * u).exp() - 0.05 * u * u;
    let slope = |u: f64| (1.0 - k * u) * (-k * u).exp() - 0.1 * u;
    battery(decay(k).unwrap(), &f, &slope);
    let f = |u: f64| (16.0 * u).sin() + u;
    battery(ripples(1.0).unwrap(), &f, &|u| 16.0 * (16.0 * u).cos() + 1.0);
    for k in [-0.1, 0.1] {
        let f = |u: f64| (u - 0.3).powi(3) + 0.1 * k * (u.powi(2).sin() + u);
        let slope = |u: f64| 3.0 * (u - 0.3).powi(2) + 0.1 * k * (2.0 * u * u.powi(2).cos() + 1.0);
        battery(folding(k).unwrap(), &f, &slope);
    }
}

/// A number from `low` to `high` and its place between them, more slowly next to `low`, where a density has a pole.
fn from_a_pole(low: f64, high: f64) -> (impl Fn(f64) -> f64, impl Fn(f64) -> f64) {
    let at = move |t: f64| low + (high - low) * t * t;
    let place = move |x: f64| ((x - low).max(0.0) / (high - low)).sqrt();
    (at, place)
}

#[test]
fn rings_pass_the_battery() {
    let turn = 0.2_f64.powf(0.25);
    let lowest = turn.powi(5) - turn;
    let (radius, place) = from_a_pole(2.0 + lowest, 2.0);
    covered(
        ring(1.0).unwrap(),
        |t| Vec2::new(radius(t[0]) * (TAU * t[1]).cos(), radius(t[0]) * (TAU * t[1]).sin()),
        |x| vec![place(x[0].hypot(x[1])), x[1].atan2(x[0]).rem_euclid(TAU) / TAU],
    );
}

#[test]
fn products_pass_the_battery() {
    let turn = 0.2_f64.powf(0.25);
    let (first, place) = from_a_pole(turn.powi(5) - turn, 0.0);
    covered(product(1.0).unwrap(), |t| Vec2::new(first(t[0]), t[1]), |x| vec![place(x[0]), x[1]]);
}

#[test]
fn a_sheared_wave_passes_the_battery() {
    // Each evaluation solves for a root in up to eight pieces.
    let sampler = sheared(0.05).unwrap();
    Battery::<_, f64>::new(&sampler).evaluations(200_000).run().assert_ok();
}

#[test]
fn a_wave_has_the_preimages_of_its_place() {
    let mut most = 0;
    for (k, u) in [(0.5, [0.3, 0.7]), (0.5, [0.9, 0.2]), (0.4, [0.5, 0.55]), (0.2, [0.1, 0.4])] {
        let (sampler, det) = (sheared(k).unwrap(), |s: f64| 1.0 + 4.5 * k * (3.0 * s).cos());
        let sample = sampler.sample(u);
        let x = sample.value();
        let along = |s: f64| 2.0 * s + 1.5 * k * (6.0 * s).sin();
        let all = scan(&along, x.x + x.y).into_iter().map(|s| 2.0 * s).map(|s| {
            let wave = k * (3.0 * s).sin();
            ([x.x - wave, x.y - 0.5 * wave], det(s).abs())
        });
        let inside = |u: &[f64; 2]| u.iter().all(|u| (0.0..1.0).contains(u));
        let all: Vec<_> = all.filter(|(u, _)| inside(u)).collect();
        let expected: f64 = all.iter().map(|(_, det)| 1.0 / det).sum();
        assert_eq!(sampler.invert(&sample).iter().count(), all.len(), "{k} {u:?}");
        for p in [sample.pdf().value(), sampler.pdf(&sample).value()] {
            assert!((p / expected - 1.0).abs() < 1e-12, "{k} {u:?}: {p}, {expected}");
        }
        most = most.max(all.len());
    }
    assert!(most > 1);
}

#[test]
fn the_ring_has_the_density_of_its_radius() {
    for (k, u, v) in [(1.0, 0.1, 0.3), (0.5, 0.5, 0.9), (2.0, 0.6, 0.2), (1.0, 0.9, 0.7)] {
        let radius = |u: f64| 2.0 + u.powi(5) - k * u;
        let sampler = ring(k).unwrap();
        let sample = sampler.sample([u, v]);
        let slope = |w: f64| (5.0 * w.powi(4) - k).abs();
        let all = scan(&radius, radius(u));
        let share = |w: &f64| 1.0 / (slope(*w) * radius(*w) * TAU);
        let expected: f64 = all.iter().map(share).sum();
        for p in [sample.pdf().value(), sampler.pdf(&sample).value()] {
            assert!((p / expected - 1.0).abs() < 1e-12, "{u} {v}: {p}, {expected}");
        }
    }
}

/// Next to turning points, at ends, and with parameters for which pieces have no width, samples have a density, and
/// points beside the support have none.
fn bordering<R: Scalar>(least: f64) {
    let turn = 0.2_f64.powf(0.25);
    let around = |m: f64| (0..40).flat_map(move |i| [-1.0, 1.0].map(|s| m + s * 0.25_f64.powi(i)));
    let ends = [0.0, 1e-30, 1e-9, 1.0 - 1e-3, 1.0 - f64::from(f32::EPSILON)];
    let inside = |u: &f64| *u >= 0.0 && *u < 1.0 - least;
    let all: Vec<R> =
        around(turn).chain(around(0.3)).chain(ends).filter(inside).map(R::of).collect();
    let check = |sampler: &dyn Fn(R) -> (R, R, R)| {
        for &u in &all {
            let (x, own, at_point) = sampler(u);
            assert!(x.finite(), "{u:?}");
            assert!(own > R::ZERO && at_point > R::ZERO, "{u:?} {x:?}: {own:?}, {at_point:?}");
        }
    };
    macro_rules! of {
        ($sampler:expr) => {
            check(&|u: R| {
                let sampler = $sampler;
                let sample = Sampler::<R>::sample(&sampler, [u]);
                let x = sample.value();
                (x, sample.pdf().value(), Sampler::<R>::pdf(&sampler, &x).value())
            })
        };
    }
    of!(quintic());
    of!(ripple());
    for k in [0.0, 1e-6, 0.5, 1.0, 1.5, 1.97, 2.0, 2.5, 4.0, 8.0] {
        of!(moved(R::of(k)).unwrap());
        of!(decay(R::of(k)).unwrap());
    }
    for k in [-0.5, -0.01, -1e-6, -1e-12, 0.0, 1e-12, 1e-6, 0.5] {
        of!(folding(R::of(k)).unwrap());
    }
    let lowest = turn.powi(5) - turn;
    for x in [lowest - 1e-3, lowest - 1.0, 1e-3, 1.0, f64::INFINITY, f64::NAN] {
        assert_eq!(Sampler::<R>::pdf(&quintic(), &R::of(x)).value(), R::ZERO, "{x}");
        assert_eq!(Sampler::<R>::invert(&quintic(), &R::of(x)).iter().count(), 0, "{x}");
    }
}

#[test]
fn samples_next_to_borders_have_a_density_in_both_precisions() {
    bordering::<f64>(0.0);
    bordering::<f32>(1e-7);
}

/// A point at which the function passes from one piece to another without a turn has one preimage, however near it is.
#[test]
fn pieces_without_width_count_once() {
    for k in [0.0, 1e-3, 0.1, 0.5] {
        let sampler = folding(k).unwrap();
        for i in -400..=400 {
            let u = 0.3 + 1e-5 * f64::from(i).powi(3) / 400.0_f64.powi(2);
            let sample = sampler.sample([u]);
            let expected =
                1.0 / (3.0 * (u - 0.3).powi(2) + 0.1 * k * (2.0 * u * u.powi(2).cos() + 1.0));
            if k > 0.0 {
                let found = sampler.pdf(&sample).value();
                assert_eq!(sampler.invert(&sample).iter().count(), 1, "{k} {u}");
                assert!((found / expected - 1.0).abs() < 1e-9, "{k} {u}: {found}, {expected}");
            }
        }
    }
}

#[test]
fn single_precision() {
    for u in [0.05f32, 0.2, 0.4, 0.6, 0.8, 0.95] {
        let single = ripples(1.0f32).unwrap().sample([u]);
        let double = ripples(1.0).unwrap().pdf(&f64::from(single.value())).value();
        let found = f64::from(ripples(1.0f32).unwrap().pdf(&single).value());
        assert!((found / double - 1.0).abs() < 1e-4, "{u}: {found}, {double}");
    }
}

#[test]
fn the_documentation_says_on_how_many_pieces() {
    let text = Ripples::<f64>::DERIVATION;
    assert_eq!(text.inverse.lines().count(), 6);
    assert!(text.inverse.contains("root("));
    assert!(text.inverse.lines().all(|line| line.starts_with("u = root(")), "{}", text.inverse);
}
