//! What is strange about measurements, in words.

use super::statistics::{CONFIDENCE, Sums, median, student};
use super::summary::{ABOVE_FLOOR, SceneSummary, Summary};

/// The least standard deviation of the logarithm that seeds are taken to have.
const LEAST_SPREAD: f64 = 0.02;

/// What deserves attention about the curves of a scene: slopes that are not -1/2, biases, seeds that
/// stand out, and measurements that the reference is not good enough for.
pub fn findings(scene: &SceneSummary) -> Vec<String> {
    scene.curves.iter().flat_map(|summary| of_curve(scene, summary)).collect()
}

fn of_curve(scene: &SceneSummary, summary: &Summary) -> Vec<String> {
    let parts = [slope(summary), bias(scene, summary), outlier(summary), floor(scene, summary)];
    let named = |text| format!("{}, {}: {text}", scene.scene, summary.curve.label());
    parts.into_iter().flatten().map(named).collect()
}

fn slope(summary: &Summary) -> Option<String> {
    let slope = summary.slope.filter(|slope| !slope.contains(-0.5))?;
    let why = if slope.value > -0.5 {
        "slower than independent samples of finite variance do; it has a bias, or its images have not \
         yet met the rare bright samples that make up its variance"
    } else {
        "faster than independent samples do; its samples are stratified, or few images have met the \
         rare bright samples that make up its variance"
    };
    Some(format!(
        "the error falls as n^{:.2} (99 % interval {:.2} to {:.2}), not as n^-0.5: {why}.",
        slope.value, slope.low, slope.high
    ))
}

fn bias(scene: &SceneSummary, summary: &Summary) -> Option<String> {
    let estimate = summary.estimate.as_ref().filter(|estimate| estimate.biased)?;
    let [value, low, high] = estimate.bias;
    let floor = match scene.floor {
        Some(floor) => format!("the reference explains {:.2e}", floor.sqrt()),
        None => "the error of the reference is not known".to_owned(),
    };
    let root = |x: f64| x.max(0.0).sqrt();
    Some(format!(
        "biased: the mean of {} seeds at {} samples differs from the reference by {:.2e} of a pixel's \
         value (99 % interval {:.2e} to {:.2e}, root mean square; {floor}), which more samples do not remove.",
        estimate.seeds,
        estimate.spp,
        root(value),
        root(low),
        root(high)
    ))
}

/// Seeds differ by factors, so errors are compared by their logarithms: a seed stands out if it lies further from the
/// mean of the others than Student's t allows with their standard deviation (the externally studentised residual;
/// Grubbs 1950). Among normal logarithms, one curve in a hundred has such a seed by chance.
fn outlier(summary: &Summary) -> Option<String> {
    let last = summary.points.last().filter(|point| point.by_seed.len() >= 4)?;
    let n = last.by_seed.len() as f64;
    let limit = student(1.0 - (1.0 - CONFIDENCE) / n, n - 2.0) * (1.0 + 1.0 / (n - 1.0)).sqrt();
    let errors: Vec<f64> = last.by_seed.iter().map(|(_, error)| error.ln()).collect();
    // Squared distances from their middle tell those from the mean of the others.
    let (sums, centre) = (Sums::of(&errors), median(&errors));
    let squares = Sums::of(&errors.iter().map(|x| (x - centre).powi(2)).collect::<Vec<_>>());
    let distance = |k: usize| {
        let mean = sums.mean_without(Some(k));
        let squares = squares.without(Some(k)) - (n - 1.0) * (mean - centre).powi(2);
        (errors[k] - mean).abs() / (squares / (n - 2.0)).max(0.0).sqrt().max(LEAST_SPREAD)
    };
    let distances = (0..last.by_seed.len()).map(|k| (k, distance(k)));
    let (k, _) = distances.filter(|(_, d)| *d > limit).max_by(|a, b| a.1.total_cmp(&b.1))?;
    let (seed, error) = last.by_seed[k];
    Some(format!(
        "seed {seed} stands out: its relMSE at {} samples is {error:.3e}, the median {:.3e}; a few samples \
         make up its error.",
        last.spp, last.quartiles[1]
    ))
}

fn floor(scene: &SceneSummary, summary: &Summary) -> Option<String> {
    let (last, floor) = (summary.points.last()?, scene.floor?);
    (last.above(floor) < (ABOVE_FLOOR - 1.0) * floor).then(|| {
        format!(
            "at {} samples its relMSE ({:.2e}) is close to that of the reference itself ({floor:.2e}): what \
             it says beyond is about the reference.",
            last.spp, last.quartiles[1]
        )
    })
}
