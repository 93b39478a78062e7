//! Samplers that turn back, where no formula undoes them: a numerical root on each piece on which they are monotone.
//!
//! What the forward map says by itself is the oracle: a scan of it finds the preimages, and slopes in closed form the
//! density.

use aether_core::battery::Battery;
use aether_core::prelude::*;
use aether_core::{Pcg32, draw_uniforms};

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
    let y = (1.0 + u[0]) * u[1] + u[1].powi(5);
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
    for (k, most) in [(0.0, 1), (0.9, 1), (2.0, 2), (20.0, 2)] {
        let f = move |u: f64| u * (-k * u).exp() - 0.05 * u * u;
        let slope = move |u: f64| (1.0 - k * u) * (-k * u).exp() - 0.1 * u;
        assert_eq!(scanned(&decay(k).unwrap(), &f, &slope), most, "{k}");
    }
    for k in [0.9, 1.0, 1.1] {
        let f = move |u: f64| k * (16.0 * u).sin() + u;
        let slope = move |u: f64| 16.0 * k * (16.0 * u).cos() + 1.0;
        assert_eq!(scanned(&ripples(k).unwrap(), &f, &slope), 5, "{k}");
    }
    for (k, most) in [(-0.5, 3), (-0.1, 3), (-1e-3, 3), (1e-3, 1), (0.5, 1)] {
        let f = move |u: f64| (u - 0.3).powi(3) + 0.1 * k * (u.powi(2).sin() + u);
        let slope =
            move |u: f64| 3.0 * (u - 0.3).powi(2) + 0.1 * k * (2.0 * u * u.powi(2).cos() + 1.0);
        assert_eq!(scanned(&folding(k).unwrap(), &f, &slope), most, "{k}");
    }
}

/// The battery, told of the values at turning points and ends, at which the density jumps.
fn battery<S>(sampler: &S, jumps: &[f64])
where
    S: Sampler<f64, Uniforms = [f64; 1], Point = f64>,
{
    Battery::new(sampler).jumps(0, jumps.iter().copied()).run().assert_ok();
}

/// The values at both ends, and at zeros of the slope.
fn extremes(f: &dyn Fn(f64) -> f64, slope: &dyn Fn(f64) -> f64) -> Vec<f64> {
    scan(slope, 0.0).into_iter().chain([0.0, 1.0]).map(f).collect()
}

#[test]
fn numbers_pass_the_battery() {
    let f = |u: f64| u.powi(5) - u;
    battery(&quintic(), &extremes(&f, &|u| 5.0 * u.powi(4) - 1.0));
    let f = |u: f64| (5.0 * u).sin() + u;
    battery(&ripple(), &extremes(&f, &|u| 5.0 * (5.0 * u).cos() + 1.0));
    for k in [0.0, 2.0, 8.0] {
        let f = |u: f64| u.powi(5) - k * u.powi(2) + u.exp();
        let slope = |u: f64| 5.0 * u.powi(4) - 2.0 * k * u + u.exp();
        battery(&moved(k).unwrap(), &extremes(&f, &slope));
    }
    for k in [0.0, 1.0, 20.0] {
        let f = |u: f64| u * (-k * u).exp() - 0.05 * u * u;
        let slope = |u: f64| (1.0 - k * u) * (-k * u).exp() - 0.1 * u;
        battery(&decay(k).unwrap(), &extremes(&f, &slope));
    }
    let f = |u: f64| (16.0 * u).sin() + u;
    battery(&ripples(1.0).unwrap(), &extremes(&f, &|u| 16.0 * (16.0 * u).cos() + 1.0));
    for k in [-0.5, 0.1] {
        let f = |u: f64| (u - 0.3).powi(3) + 0.1 * k * (u.powi(2).sin() + u);
        let slope = |u: f64| 3.0 * (u - 0.3).powi(2) + 0.1 * k * (2.0 * u * u.powi(2).cos() + 1.0);
        battery(&folding(k).unwrap(), &extremes(&f, &slope));
    }
}

#[test]
fn points_in_the_plane_pass_the_battery() {
    for k in [0.5, 1.0, 2.0] {
        aether_core::battery::check(&ring(k).unwrap()).assert_ok();
        aether_core::battery::check(&product(k).unwrap()).assert_ok();
    }
    for k in [0.0, 0.1, 0.5] {
        aether_core::battery::check(&sheared(k).unwrap()).assert_ok();
    }
}

#[test]
fn the_ring_has_the_density_of_its_radius() {
    let k = 1.0;
    let radius = |u: f64| 2.0 + u.powi(5) - k * u;
    for (u, v) in [(0.1, 0.3), (0.5, 0.9), (0.6, 0.2), (0.9, 0.7)] {
        let sample = ring(k).unwrap().sample([u, v]);
        let all = scan(&radius, radius(u));
        let expected: f64 =
            all.iter().map(|w| 1.0 / ((5.0 * w.powi(4) - k).abs() * radius(*w) * TAU)).sum();
        assert_eq!(all.len(), 2);
        for p in [sample.pdf().value(), ring(k).unwrap().pdf(&sample).value()] {
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
}
