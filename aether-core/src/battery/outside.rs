//! Density where there should be none, and none where there should be some.

use super::derivative::{distance, dot};
use super::probe::Probe;
use super::report::Report;
use super::space::{Chart, Kind};
use super::subject::{AnySpot, Spot};
use crate::uniform::{Pcg32, UniformSource};

/// How many samples are the origin of points to try.
const ORIGINS: usize = 64;
/// How many points of a charted space are tried.
const SPREAD: usize = 2000;
/// A point has a preimage if it maps forward to within this many times the usual rounding.
const SLACK: f64 = 16.0;

/// Tries points all over the space and off the manifold.
pub(super) fn check(probe: &Probe, seed: u64, report: &mut Report) {
    let mut source = Pcg32::new(seed, 4, 0);
    let origins: Vec<_> = (0..ORIGINS)
        .filter_map(|_| {
            let u = probe.sampler.draw(&mut source);
            probe.forward(&u).map(|(x, _)| (u, x))
        })
        .collect();
    let (mut candidates, mut forbidden) = (Vec::new(), Vec::new());
    for (u, x) in &origins {
        forbidden.extend(not_points(&**x));
        candidates.extend(beside(probe, u, &**x));
    }
    if let (Some(chart), Some((_, x))) =
        (Chart::new(probe.sampler.kind(), &probe.pilot), origins.first())
    {
        let mut anywhere = || -1.0 + 2.0 * UniformSource::<f64>::next(&mut source);
        candidates.extend((0..SPREAD).map(|_| {
            let (y, _) = chart.point(&core::array::from_fn(|_| anywhere()));
            x.moved_to(&y)
        }));
    }
    let failure = forbidden
        .iter()
        .find_map(|y| {
            let (p, found) = (y.pdf(), y.preimages());
            let wrong = p != 0.0 || !found.is_empty();
            wrong.then(|| format!("{y:?} has density {p:e} and preimages {found:?}"))
        })
        .or_else(|| candidates.iter().find_map(|y| contradiction(probe, &**y)));
    report.conclude(
        "outside",
        failure,
        format!("{} points and {} that are none", candidates.len(), forbidden.len()),
    );
}

/// NaN, infinity, and the same place on another manifold: never in the support.
fn not_points<'a>(x: &dyn Spot<'a>) -> Vec<AnySpot<'a>> {
    let at = x.coordinates();
    let mut all: Vec<AnySpot<'a>> = x.elsewhere().into_iter().collect();
    for bad in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
        all.push(x.moved_to(&vec![bad; at.len()]));
        for axis in 0..at.len() {
            let mut y = at.clone();
            y[axis] = bad;
            all.push(x.moved_to(&y));
        }
    }
    all
}

/// Points in special position to a sample: mirrored, scaled, off along the normals, and beyond the
/// rim along the tangents.
fn beside<'a>(probe: &Probe, u: &[f64], x: &dyn Spot<'a>) -> Vec<AnySpot<'a>> {
    let kind = probe.sampler.kind();
    let at = x.coordinates();
    let mut all: Vec<Vec<f64>> = Vec::new();
    if kind != Kind::Identified && kind != Kind::Joint {
        all.push(at.iter().map(|x| -x).collect());
        for axis in 0..at.len() {
            let mut y = at.clone();
            y[axis] = -y[axis];
            all.push(y);
        }
    }
    if kind == Kind::Flat || kind == Kind::Embedded {
        all.extend([1e-3, 10.0, 1e4].map(|k| at.iter().map(|x| x * k).collect()));
    }
    let size = probe.magnitude(&at);
    let square = probe.is_square();
    if let (Kind::Embedded | Kind::Identified, true, Some(d)) = (kind, square, probe.derivative(u))
    {
        let moved = |along: &[f64], step: f64| -> Vec<f64> {
            at.iter().zip(along).map(|(x, a)| x + step * a).collect()
        };
        let normals = d.normals(at.len());
        if kind == Kind::Embedded {
            for normal in &normals {
                for step in [probe.epsilon.powf(0.45), 1e-3, 0.3] {
                    all.extend([1.0, -1.0].map(|side| moved(normal, side * step * size)));
                }
            }
        }
        if kind == Kind::Embedded || is_flat(probe, &at, &normals) {
            for tangent in &d.tangents {
                all.extend([0.1, -0.1, 1.0, -1.0, 100.0].map(|k| moved(tangent, k * size)));
            }
        }
    }
    all.iter().map(|y| x.moved_to(y)).collect()
}

/// Whether all samples lie in the plane through `at` across the normals.
fn is_flat(probe: &Probe, at: &[f64], normals: &[Vec<f64>]) -> bool {
    probe.pilot.iter().all(|x| {
        let offset: Vec<f64> = x.iter().zip(at).map(|(x, a)| x - a).collect();
        let limit = probe.epsilon.sqrt() * probe.magnitude(at).max(distance(x, at));
        normals.iter().all(|n| dot(n, &offset).abs() <= limit)
    })
}

/// What is contradictory about a point: a density without a preimage, or the other way round.
fn contradiction(probe: &Probe, y: &dyn Spot) -> Option<String> {
    let (at, p, found) = (y.coordinates(), y.pdf(), y.preimages());
    if p.is_nan() || p < 0.0 {
        return Some(format!("density {p} at {at:?}"));
    }
    let mut reaching = found.iter().filter(|v| probe.maps_to(v, &at, SLACK));
    if p > 0.0 {
        let explained =
            reaching.next().is_some() || found.iter().any(|v| in_tail(probe, v, &at, p));
        return (!explained).then(|| {
            format!("density {p:e} at {at:?}, which no uniforms map to (preimages {found:?})")
        });
    }
    let inside = |v: &&Vec<f64>| v.iter().all(|v| (1e-6..1.0 - 1e-6).contains(v));
    reaching
        .filter(|v| !probe.is_beyond(v, &at))
        .find(inside)
        .filter(|v| probe.derivative(v).is_some())
        .map(|v| format!("no density at {at:?}, which the uniforms {v:?} map to"))
}

/// Whether `v` is next to an end of [0, 1), or to uniforms without a sample, and what lies between its image and
/// `at` has no mass to speak of: the uniforms that map to a long tail are closer to one, to zero, or to where a
/// flight escapes, than any number is.
fn in_tail(probe: &Probe, v: &[f64], at: &[f64], p: f64) -> bool {
    let last = v.iter().any(|v| *v >= 1.0 - 4.0 * probe.epsilon);
    // A uniform that underflowed to zero stands for one of the least size; its image may be at
    // infinity, where only the density tells how little mass is beyond.
    let least = v.iter().any(|v| *v <= f64::from(f32::MIN_POSITIVE) * probe.epsilon);
    let image = |v: &[f64]| {
        let (_, y) = probe.forward(v)?;
        y.iter().all(|y| y.is_finite()).then_some(y)
    };
    let beside: Vec<_> = roundings(v, probe.epsilon).map(|v| image(&v)).collect();
    let edge = beside.iter().any(Option::is_none);
    let gap = match image(v).into_iter().chain(beside.into_iter().flatten()).next() {
        Some(image) => distance(&image, at),
        None if least => distance(at, &vec![0.0; at.len()]).max(1.0),
        None => f64::INFINITY,
    };
    (last || least || edge)
        && p * gap.powi(probe.sampler.dimension() as i32) <= 64.0 * probe.epsilon
}

/// Uniforms a few roundings from these.
fn roundings(v: &[f64], epsilon: f64) -> impl Iterator<Item = Vec<f64>> {
    (0..v.len()).flat_map(move |axis| {
        [-4.0, 4.0].map(|steps| {
            let mut near = v.to_vec();
            near[axis] = (near[axis] + steps * epsilon).clamp(0.0, 1.0 - 0.5 * epsilon);
            near
        })
    })
}
