//! Curves of errors: medians, slopes, efficiencies.

use super::record::{Curve, Estimate, Row};
use super::statistics::{Interval, Sums, jackknife, median, quantile, slope};

/// The number of samples of the baseline whose error others are to reach.
pub const TARGET_SAMPLES: u32 = 64;
/// How many octaves of samples, from the largest number downwards, the slope is fitted to.
const OCTAVES: f64 = 6.0;
/// How far above the floor of the reference an error must be to say something about the integrator.
pub const ABOVE_FLOOR: f64 = 4.0;

/// The errors of all seeds with one number of samples.
#[derive(Clone, Debug, PartialEq)]
pub struct Point {
    /// Samples per pixel.
    pub spp: u32,
    /// Median of the seconds.
    pub seconds: f64,
    /// Quartiles of relMSE over the seeds.
    pub quartiles: [f64; 3],
    /// relMSE by seed.
    pub by_seed: Vec<(u64, f64)>,
    /// Medians of RMSE, SMAPE and FLIP.
    pub others: [f64; 3],
}

impl Point {
    /// The sums of relMSE over seeds.
    fn sums(&self) -> Sums {
        Sums::of(&self.by_seed.iter().map(|(_, error)| *error).collect::<Vec<_>>())
    }

    /// The mean relMSE of all seeds without what the reference adds to it.
    pub fn above(&self, floor: f64) -> f64 {
        self.sums().mean_without(None) - floor
    }
}

/// When a curve reaches an error.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Reached {
    /// After so many seconds, between two measurements.
    Within(f64),
    /// It has a smaller error at its first measurement, which took so many seconds.
    Before(f64),
    /// It would after so many seconds, if its error goes on as 1/√t.
    Extrapolated(f64),
}

/// What one curve says.
#[derive(Clone, Debug, PartialEq)]
pub struct Summary {
    /// Whose it is.
    pub curve: Curve,
    /// From few samples to many.
    pub points: Vec<Point>,
    /// The exponent of the error (the root of relMSE without the floor) over samples; -1/2 for independent samples
    /// without bias.
    pub slope: Option<Interval>,
    /// When it has the error of the baseline.
    pub reached: Option<Reached>,
    /// 1 / (error² time) over that of the baseline, by the medians of relMSE without the floor.
    pub efficiency: Option<f64>,
    /// Variance and bias.
    pub estimate: Option<Estimate>,
}

/// All curves of a scene.
#[derive(Clone, Debug, PartialEq)]
pub struct SceneSummary {
    /// The name of the scene.
    pub scene: String,
    /// The label of the curve that others are compared with: path tracing, or the first.
    pub baseline: String,
    /// The error (root of relMSE) that is to be reached.
    pub target: Option<f64>,
    /// relMSE of the reference itself.
    pub floor: Option<f64>,
    /// How the reference was made.
    pub reference: String,
    /// In the order of the table.
    pub curves: Vec<Summary>,
}

/// The summaries of all scenes in the order in which they occur.
pub fn summarise(rows: &[Row], estimates: &[Estimate]) -> Vec<SceneSummary> {
    let mut scenes: Vec<&str> = Vec::new();
    for row in rows {
        if !scenes.contains(&row.curve.scene.as_str()) {
            scenes.push(&row.curve.scene);
        }
    }
    scenes.into_iter().map(|scene| summarise_scene(scene, rows, estimates)).collect()
}

fn summarise_scene(scene: &str, rows: &[Row], estimates: &[Estimate]) -> SceneSummary {
    let rows: Vec<&Row> = rows.iter().filter(|row| row.curve.scene == scene).collect();
    let of_scene = || estimates.iter().filter(|estimate| estimate.curve.scene == scene);
    let floor = of_scene().find_map(|estimate| estimate.floor);
    let mut curves: Vec<Summary> = Vec::new();
    for row in &rows {
        if curves.iter().all(|summary| summary.curve != row.curve) {
            curves.push(Summary {
                curve: row.curve.clone(),
                points: points(rows.iter().filter(|other| other.curve == row.curve)),
                slope: None,
                reached: None,
                efficiency: None,
                estimate: of_scene().find(|estimate| estimate.curve == row.curve).cloned(),
            });
        }
    }
    let is_path = |summary: &&Summary| {
        summary.curve.renderer == "aether" && summary.curve.integrator == "path"
    };
    let baseline = curves.iter().find(is_path).or(curves.first()).cloned();
    let above = floor.unwrap_or(0.0);
    let target = baseline.as_ref().and_then(|b| error_at(&b.points, TARGET_SAMPLES));
    let efficiency = |summary: &Summary| {
        let last = summary.points.last()?;
        let error = last.quartiles[1] - above;
        (error > above && last.seconds > 0.0).then(|| 1.0 / (error * last.seconds))
    };
    let base = baseline.as_ref().and_then(efficiency);
    for summary in &mut curves {
        summary.slope = fitted_slope(&summary.points, above);
        summary.reached = target.and_then(|target| reached(&summary.points, target));
        summary.efficiency = efficiency(summary).zip(base).map(|(own, base)| own / base);
    }
    SceneSummary {
        scene: scene.to_owned(),
        baseline: baseline.map(|b| b.curve.label()).unwrap_or_default(),
        target: target.map(f64::sqrt),
        floor,
        reference: of_scene().map(|e| e.reference.clone()).next().unwrap_or_default(),
        curves,
    }
}

fn points<'r>(rows: impl Iterator<Item = &'r &'r Row>) -> Vec<Point> {
    let mut rows: Vec<&Row> = rows.copied().collect();
    rows.sort_by_key(|row| (row.spp, row.seed));
    let of = |rows: &[&Row], value: fn(&Row) -> f64| -> Vec<f64> {
        rows.iter().map(|row| value(row)).collect()
    };
    let point = |rows: &[&Row]| {
        let errors = of(rows, |row| row.relmse);
        Point {
            spp: rows[0].spp,
            seconds: median(&of(rows, |row| row.seconds)),
            quartiles: [0.25, 0.5, 0.75].map(|at| quantile(&errors, at)),
            by_seed: rows.iter().map(|row| (row.seed, row.relmse)).collect(),
            others: [|row: &Row| row.rmse, |row: &Row| row.smape, |row: &Row| row.flip]
                .map(|value: fn(&Row) -> f64| median(&of(rows, value))),
        }
    };
    rows.chunk_by(|a, b| a.spp == b.spp).map(point).collect()
}

/// The median relMSE with a number of samples, on straight lines in the logarithms, with relMSE ~ 1/n beyond the ends.
fn error_at(points: &[Point], spp: u32) -> Option<f64> {
    let (first, last) = (points.first()?, points.last()?);
    let extended = |from: &Point| from.quartiles[1] * f64::from(from.spp) / f64::from(spp);
    if spp <= first.spp {
        return Some(extended(first));
    }
    let Some(k) = points.iter().position(|point| point.spp >= spp) else {
        return Some(extended(last));
    };
    let (a, b) = (&points[k - 1], &points[k]);
    let part =
        (f64::from(spp) / f64::from(a.spp)).ln() / (f64::from(b.spp) / f64::from(a.spp)).ln();
    Some(a.quartiles[1] * (b.quartiles[1] / a.quartiles[1]).powf(part))
}

/// When the median relMSE falls to a target for the first time.
fn reached(points: &[Point], target: f64) -> Option<Reached> {
    let (first, last) = (points.first()?, points.last()?);
    if first.quartiles[1] <= target {
        return Some(Reached::Before(first.seconds));
    }
    let Some(k) = points.iter().position(|point| point.quartiles[1] <= target) else {
        return Some(Reached::Extrapolated(last.seconds * last.quartiles[1] / target));
    };
    let (a, b) = (&points[k - 1], &points[k]);
    let part = (a.quartiles[1] / target).ln() / (a.quartiles[1] / b.quartiles[1]).ln();
    Some(Reached::Within(a.seconds * (b.seconds / a.seconds).powf(part)))
}

/// The slope of ln √(relMSE - floor) over ln n: relMSE is the mean over seeds, and the interval comes from leaving out
/// one seed after another, since the images of a seed are beginnings of one render.
fn fitted_slope(points: &[Point], floor: f64) -> Option<Interval> {
    let (most, seeds) = (f64::from(points.last()?.spp), points.last()?.by_seed.len());
    let counts = |point: &&Point| {
        point.by_seed.len() == seeds
            && f64::from(point.spp) >= most / OCTAVES.exp2()
            && point.above(floor) > (ABOVE_FLOOR - 1.0) * floor
    };
    let points: Vec<(u32, Sums)> =
        points.iter().filter(counts).map(|point| (point.spp, point.sums())).collect();
    if points.len() < 3 {
        return None;
    }
    jackknife(seeds, |left_out| {
        let place = |(spp, errors): &(u32, Sums)| {
            let error = errors.mean_without(left_out) - floor;
            (f64::from(*spp).ln(), 0.5 * error.ln())
        };
        slope(&points.iter().map(place).collect::<Vec<_>>()).filter(|slope| slope.is_finite())
    })
}
