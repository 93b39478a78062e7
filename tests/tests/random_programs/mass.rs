//! The mass of the density over boxes, against the share of the plain function's samples in them.

use super::*;

/// How many samples, and how many points of each box.
const SAMPLES: usize = 4000;
/// Of right programs this many standard deviations are passed with probability 1e-10 for each of
/// about 700 boxes.
const LIMIT: f64 = 6.4;

/// Coordinates in which volume is the measure of the space: height and azimuth on the sphere.
fn chart(kind: Kind, x: &[f64]) -> Vec<f64> {
    if kind == Kind::Sphere { vec![x[2], x[1].atan2(x[0])] } else { x.to_vec() }
}

fn point(kind: Kind, t: &[f64]) -> Vec<f64> {
    if kind != Kind::Sphere {
        return t.to_vec();
    }
    let r = ((1.0 - t[0]) * (1.0 + t[0])).max(0.0).sqrt();
    vec![r * t[1].cos(), r * t[1].sin(), t[0]]
}

/// Deviations of the mass in three boxes, the largest of which has all but the tails.
fn deviations(case: &Case, factor: f64) -> Vec<f64> {
    let mut random = Pcg32::new(11, 2, 0);
    let mut draw = || -> [f64; 3] { draw_uniforms(&mut random) };
    let samples: Vec<Vec<f64>> = (0..SAMPLES)
        .filter_map(|_| case.plain(&draw()[..case.uniforms]))
        .map(|x| chart(case.kind, &x))
        .collect();
    let axes = samples[0].len();
    let quantile = |axis: usize, q: f64| {
        let mut values: Vec<f64> = samples.iter().map(|x| x[axis]).collect();
        values.sort_by(f64::total_cmp);
        values[((SAMPLES - 1) as f64 * q) as usize]
    };
    let mut out = Vec::new();
    for (low, high) in [(0.01, 0.99), (0.1, 0.6), (0.4, 0.9)] {
        let ends: Vec<(f64, f64)> =
            (0..axes).map(|k| (quantile(k, low), quantile(k, high))).collect();
        let inside =
            |x: &&Vec<f64>| x.iter().zip(&ends).all(|(x, (low, high))| (low..high).contains(&x));
        let share = samples.iter().filter(inside).count() as f64 / SAMPLES as f64;
        let size: f64 = ends.iter().map(|(low, high)| high - low).product();
        let (mut sum, mut squares) = (0.0, 0.0);
        for _ in 0..SAMPLES {
            let u = draw();
            let t: Vec<f64> =
                ends.iter().zip(u).map(|((low, high), u)| low + (high - low) * u).collect();
            let p = factor * size * (case.pdf)(&point(case.kind, &t));
            sum += p;
            squares += p * p;
        }
        let n = SAMPLES as f64;
        let mass = sum / n;
        let variance = (squares / n - mass * mass) / n + share * (1.0 - share) / n;
        out.push((mass - share) / (variance + 0.25 / (n * n)).sqrt());
    }
    out
}

fn flat() -> impl Iterator<Item = Case> {
    programs::all().into_iter().filter(|c| matches!(c.kind, Kind::Flat | Kind::Sphere))
}

#[test]
fn mass_of_boxes_is_the_share_of_samples() {
    let mut wrong = Vec::new();
    for case in flat() {
        let z = deviations(&case, 1.0);
        if !z.iter().all(|z| z.abs() < LIMIT) {
            wrong.push(format!("{}: {z:.1?} standard deviations off", case.name));
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

#[test]
fn a_density_that_misses_a_third_is_noticed() {
    let noticed = |case: &Case| deviations(case, 2.0 / 3.0).iter().any(|z| z.abs() > LIMIT);
    let (count, seen) = flat().fold((0, 0), |(n, k), c| (n + 1, k + usize::from(noticed(&c))));
    assert!(10 * seen >= 9 * count, "only {seen} of {count} would be noticed");
}
