//! The checks at single points of the support: round trip, own density, Jacobian.

use super::Settings;
use super::probe::Probe;
use super::report::{Report, Verdict};
use super::space::Kind;
use crate::uniform::{Pcg32, Sobol};

/// How many interior points are tried, half of them stratified.
const INTERIOR: u32 = 400;
/// How many combinations of extreme uniforms are tried at most.
const EXTREME: usize = 125;
/// Interior uniforms keep this distance from zero and one, so that differences have room.
const MARGIN: f64 = 1e-4;

/// Runs the three checks.
pub(super) fn check(probe: &Probe, settings: &Settings, report: &mut Report) {
    let interior = interior(probe, settings.seed);
    let extreme = extreme(probe.sampler.uniforms(), settings.least);
    let everywhere = || interior.iter().chain(&extreme);

    let failure = everywhere().find_map(|u| round_trip(probe, u));
    let lost = || interior.iter().find_map(|u| lost_preimage(probe, u));
    report.conclude(
        "round trip",
        failure.or_else(lost),
        format!("{} points, {} of them extreme", interior.len() + extreme.len(), extreme.len()),
    );

    let mut worst = 0.0;
    let failure = everywhere().find_map(|u| own_density(probe, u, &mut worst));
    let success = format!("worst relative difference {worst:.1e} beyond the condition");
    report.conclude("own density", failure, success);

    let jumps = &settings.jumps;
    let smooth = interior.into_iter().filter(|u| !jumps_beside(probe, u, jumps));
    jacobian(probe, &smooth.collect::<Vec<_>>(), report);
}

/// How far uniforms are moved at least to take differences.
const LEAST_STEP: f64 = 1e-3;

/// Whether a jump of the density lies within every difference.
fn jumps_beside(probe: &Probe, u: &[f64], jumps: &[(usize, f64)]) -> bool {
    if jumps.is_empty() || probe.sampler.kind() != Kind::Flat {
        return false;
    }
    let beside = probe.neighbours(u, |_| LEAST_STEP);
    let images: Vec<Vec<f64>> =
        beside.iter().filter_map(|v| probe.forward(v)).map(|(_, x)| x).collect();
    jumps.iter().any(|&(axis, value)| {
        let below = images.iter().filter(|x| x.get(axis).is_some_and(|x| *x < value)).count();
        below > 0 && below < images.len()
    })
}

/// Stratified and random points, as the sampler's numbers represent them.
fn interior(probe: &Probe, seed: u64) -> Vec<Vec<f64>> {
    let inside = |mut u: Vec<f64>| -> Vec<f64> {
        u.iter_mut().for_each(|u| *u = MARGIN + (1.0 - 2.0 * MARGIN) * *u);
        probe.sampler.rounded(&u)
    };
    let mut source = Pcg32::new(seed, 2, 0);
    let random = (0..INTERIOR / 2).map(|_| inside(probe.sampler.draw(&mut source)));
    let stratified = (0..INTERIOR / 2)
        .map(|k| inside(probe.sampler.draw_stratified(&mut Sobol::new(seed, 2, k))));
    random.chain(stratified).collect()
}

/// Combinations of uniforms at and next to the ends.
fn extreme(count: usize, least: f64) -> Vec<Vec<f64>> {
    let values = [0.0, least, 1.0 / (1_u64 << 60) as f64, 0.5, 1.0 - 0.5 * f64::EPSILON];
    (0..values.len().pow(count.min(3) as u32).min(EXTREME))
        .map(|k| (0..count).map(|i| values[(k / values.len().pow(i as u32 % 3)) % 5]).collect())
        .collect()
}

/// What is wrong with the preimages of the sample of `u`, if anything.
fn round_trip(probe: &Probe, u: &[f64]) -> Option<String> {
    let (x, at) = probe.forward(u)?;
    let found = x.preimages();
    if found.is_empty() {
        return Some(format!("the sample {at:?} of the uniforms {u:?} has no preimage"));
    }
    let astray = found.iter().find(|v| !probe.maps_to(v, &at, 1.0))?;
    let image = probe.forward(astray).map(|(_, y)| y);
    Some(format!("preimage {astray:?} of {at:?} (uniforms {u:?}) maps forward to {image:?}"))
}

/// Whether `u` itself is missing among the preimages of its sample, or there twice. Says nothing
/// where the map is too flat to tell its uniforms apart.
fn lost_preimage(probe: &Probe, u: &[f64]) -> Option<String> {
    if !probe.is_square() {
        return None;
    }
    let (x, at) = probe.forward(u)?;
    let derivative = probe.derivative(u)?;
    let condition = probe.magnitude(&at) / derivative.least();
    let tolerance = 1e3 * probe.epsilon * (1.0 + condition);
    if tolerance > 0.01 || derivative.error > 0.01 {
        return None;
    }
    let near = |v: &&Vec<f64>| v.iter().zip(u).all(|(v, u)| (v - u).abs() <= tolerance);
    let found = x.preimages();
    match found.iter().filter(near).count() {
        1 => None,
        0 => Some(format!("the uniforms {u:?} of {at:?} are not among its preimages {found:?}")),
        n => Some(format!("the uniforms {u:?} of {at:?} are found {n} times: {found:?}")),
    }
}

/// How `sample.pdf()` differs from `sampler.pdf(&sample)`, if it does; records the difference
/// relative to the density, less what the condition explains.
fn own_density(probe: &Probe, u: &[f64], worst: &mut f64) -> Option<String> {
    let (x, at) = probe.forward(u)?;
    let own = |u: &[f64]| probe.sampler.own_density(u);
    let (own_here, general) = (own(u), x.pdf());
    let text = || {
        format!("at {at:?} (uniforms {u:?}): sample.pdf() is {own_here:e}, sampler.pdf {general:e}")
    };
    if !(own_here >= 0.0 && general >= 0.0) {
        return Some(text());
    }
    if own_here == general {
        return None;
    }
    // How much the density moves as the coordinates do by rounding, seen through the uniforms.
    let extents = probe.derivative(u).map(|d| d.extents).unwrap_or_default();
    let magnitude = probe.magnitude(&at);
    let step = |axis: usize| {
        let stretch = extents.get(axis).map_or(1.0, |extent| (magnitude / extent).max(1.0));
        16.0 * probe.epsilon * stretch
    };
    let rounded = probe.neighbours(u, step).into_iter().chain([probe.inwards(u, step)]);
    let moved = rounded
        .chain(probe.undetermined(u, &at))
        .map(|v| (own(&v) - own_here).abs())
        .filter(|change| !change.is_nan())
        .fold(0.0, f64::max);
    let excess = ((own_here - general).abs() - 10.0 * moved) / own_here.max(general);
    *worst = worst.max(excess);
    (excess > tolerance(probe.epsilon)).then(text)
}

/// Relative tolerance of a density: 1e-9 in `f64`, 1e-4 in `f32`.
pub(super) fn tolerance(epsilon: f64) -> f64 {
    epsilon.powf(0.575)
}

/// Compares the density of a sample with the Jacobians at all of its preimages.
fn jacobian(probe: &Probe, interior: &[Vec<f64>], report: &mut Report) {
    if !probe.is_square() {
        let detail = "uniforms and dimensions differ in number: no determinant".to_owned();
        return report.add("jacobian", Verdict::NotApplicable, detail);
    }
    let (mut resolved, mut worst, mut failure) = (0, 0.0_f64, None);
    for u in interior {
        let Some((expected, error)) = density_by_differences(probe, u) else { continue };
        resolved += 1;
        let density = probe.sampler.own_density(u);
        let difference = (density / expected - 1.0).abs();
        worst = worst.max(difference);
        let right = difference <= 10.0 * error + 10.0 * probe.epsilon.sqrt();
        if !right && failure.is_none() {
            let at = probe.forward(u).map(|(_, x)| x);
            failure = Some(format!(
                "at {at:?} (uniforms {u:?}): density {density:e}, by differences {expected:e}"
            ));
        }
    }
    let figures = format!("{resolved} points, worst relative difference {worst:.1e}");
    let sampled = interior.iter().filter(|u| probe.forward(u).is_some()).count();
    if failure.is_none() && resolved * 10 < sampled {
        failure = Some(format!("differences resolve the derivative at too few points: {figures}"));
    }
    report.conclude("jacobian", failure, figures);
}

/// The density of the sample of `u` from derivatives by differences at all of its preimages, and
/// its relative error; `None` where they do not resolve it.
fn density_by_differences(probe: &Probe, u: &[f64]) -> Option<(f64, f64)> {
    let (x, at) = probe.forward(u)?;
    let (mut density, mut error) = (0.0, 0.0_f64);
    // What lies beyond all numbers next to an end has no density to speak of.
    for v in x.preimages().into_iter().filter(|v| !probe.is_beyond(v, &at)) {
        let inside = v.iter().all(|v| (0.5 * MARGIN..1.0 - 0.5 * MARGIN).contains(v));
        let derivative = if inside { probe.derivative(&v)? } else { return None };
        density += derivative.volume().recip();
        error = error.max(derivative.error);
    }
    // Coarser estimates would not see an error of one part in a hundred.
    (density > 0.0 && error < 5e-4).then_some((density, error))
}
