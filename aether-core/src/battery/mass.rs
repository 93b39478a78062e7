//! Mass of the density over the whole space, and samples against it.

use super::cubature::{Bounds, Integral, MOST, integrate};
use super::derivative::Derivative;
use super::partition::{Grid, Tree, cut};
use super::pearson::Pearson;
use super::probe::Probe;
use super::report::{Report, Verdict};
use super::space::Chart;
use super::{Manifold, Settings};
use crate::uniform::Pcg32;

/// Levels of the partition: 2^8 bins.
const LEVELS: usize = 8;
const CUBE: Bounds = [(-1.0, 1.0); MOST];
/// Cells are refined down to this error.
const PRECISE: f64 = 1e-6;
/// Cells where the density fills a small corner may hide this much from the standard error.
const BIAS: f64 = 1e-3;
/// An integral coarser than this decides nothing.
const COARSE: f64 = 1.5e-3;

/// Fresh samples: their coordinates, and how many uniforms gave none.
pub(super) struct Draws {
    points: Vec<Vec<f64>>,
    missing: usize,
    /// The share of uniforms that give a sample, if it is known.
    share: Option<f64>,
}

impl Draws {
    /// Draws `count` times from a sampler of which this share of the uniforms gives a sample, if that is known.
    pub(super) fn new(probe: &Probe, seed: u64, count: usize, share: Option<f64>) -> Self {
        let mut source = Pcg32::new(seed, 3, 0);
        let points: Vec<_> = (0..count)
            .filter_map(|_| probe.forward(&probe.sampler.draw(&mut source)))
            .map(|(_, x)| x)
            .collect();
        Draws { missing: count - points.len(), points, share }
    }

    fn count(&self) -> f64 {
        (self.points.len() + self.missing) as f64
    }

    /// How many uniforms there were, and how many of them gave none.
    fn counted(&self) -> (f64, f64) {
        (self.count(), self.missing as f64)
    }

    /// The share of uniforms that give a sample, and five standard errors of it.
    fn mass(&self) -> (f64, f64) {
        if let Some(mass) = self.share {
            return (mass, 0.0);
        }
        let mass = self.points.len() as f64 / self.count();
        (mass, 5.0 * (mass * (1.0 - mass) / self.count()).sqrt())
    }
}

/// Checks the density over a space that has a chart.
pub(super) fn check(probe: &Probe, draws: &Draws, settings: &Settings, report: &mut Report) {
    let Some(chart) = Chart::new(probe.sampler.kind(), &probe.pilot) else {
        let detail = "only the sampler knows the manifold: give `.parametrised(…)`".to_owned();
        report.add("mass", Verdict::NotApplicable, detail);
        let detail = "only the sampler knows the manifold".to_owned();
        return report.add("chi-square", Verdict::NotApplicable, detail);
    };
    let dimension = chart.dimension();
    let mut pilot: Vec<_> = probe.pilot.iter().map(|x| chart.cube(x)).collect();
    let mut parts = Vec::new();
    let tree = Tree::grow(&mut pilot, CUBE, dimension, LEVELS, &mut parts);
    for (axis, value) in settings.jumps.iter().filter(|(axis, _)| *axis < dimension) {
        cut(&mut parts, *axis, chart.coordinate(*axis, *value));
    }
    let integral = integrate(&parts, dimension, PRECISE, settings.evaluations, |t| {
        let (x, factor) = chart.point(t);
        let density = probe.model.moved_to(&x).pdf();
        // The factor is infinite where the cube's face stands for infinity.
        if density == 0.0 { 0.0 } else { density * factor }
    });
    report_mass(draws, &integral, report);

    let mut counts = vec![0.0; integral.bins.len()];
    draws.points.iter().for_each(|x| counts[tree.leaf(&chart.cube(x))] += 1.0);
    chi_square(draws.counted(), &counts, &integral, settings.false_alarm_rate, report);
}

/// Checks the density over a manifold that the user has parametrised.
pub(super) fn check_over(
    probe: &Probe,
    draws: &Draws,
    settings: &Settings,
    manifold: &Manifold<'_, '_>,
    report: &mut Report,
) {
    let dimension = probe.sampler.dimension();
    if dimension > MOST {
        let detail = "cubature goes up to four dimensions".to_owned();
        return report.add("mass", Verdict::NotApplicable, detail);
    }
    let cover = manifold.cover;
    let map = |t: &[f64]| Some(cover(t).coordinates());
    let grid = Grid::new(dimension);
    // Each evaluation differentiates the parametrisation too.
    let evaluations = settings.evaluations / 10;
    let integral = integrate(&grid.parts(), dimension, PRECISE, evaluations, |t| {
        let density = cover(&t[..dimension]).pdf();
        if density == 0.0 {
            return 0.0;
        }
        density * Derivative::roughly(&map, &t[..dimension]).map_or(0.0, |d| d.volume())
    });
    report_mass(draws, &integral, report);

    let Some(place) = manifold.place else {
        let detail = "where on the manifold a sample lies is not known: give `.located(…)`";
        return report.add("chi-square", Verdict::NotApplicable, detail.to_owned());
    };
    let mut counts = vec![0.0; integral.bins.len()];
    let mut outside = 0;
    for x in &draws.points {
        match grid.cell(&place(x)) {
            Some(cell) => counts[cell] += 1.0,
            None => outside += 1,
        }
    }
    if outside > 0 {
        let detail = format!("{outside} samples are where the parametrisation does not reach");
        return report.add("chi-square", Verdict::Failed, detail);
    }
    chi_square(draws.counted(), &counts, &integral, settings.false_alarm_rate, report);
}

fn report_mass(draws: &Draws, integral: &Integral, report: &mut Report) {
    let (expected, noise) = draws.mass();
    let (total, error) = (integral.total(), integral.error());
    let figures = format!(
        "the density integrates to {total:.5} (standard error {error:.0e}), {expected:.5} expected"
    );
    let right = (total - expected).abs() <= BIAS + 5.0 * error + noise;
    let failure = if error > COARSE {
        Some(format!("{figures}: not resolved, allow more `.evaluations(…)`"))
    } else {
        // A NaN is not right.
        (!right).then(|| figures.clone())
    };
    report.conclude("mass", failure, figures);
}

/// Pearson's test of the counts in each bin, of `n` in all with those that are missing, against the mass of the density there,
/// whose own variance adds to that of the count.
pub(super) fn chi_square(
    (n, missing): (f64, f64),
    counts: &[f64],
    integral: &Integral,
    false_alarm_rate: f64,
    report: &mut Report,
) {
    let mut pearson = Pearson::default();
    let bins = integral.bins.iter().zip(&integral.variances);
    for (number, (count, (mass, variance))) in counts.iter().zip(bins).enumerate() {
        pearson.add(&format!("bin {number}"), *count, (mass * n, variance * n * n));
    }
    let none = n * (1.0 - integral.total());
    pearson.add("no sample", missing, (none, (integral.error() * n).powi(2)));
    let subject = format!("{n} samples in {} bins", counts.len());
    pearson.conclude(("chi-square", &subject), false_alarm_rate, report);
}
