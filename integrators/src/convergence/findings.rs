//! What is strange about measurements, in words.

use super::statistics::median;
use super::summary::{ABOVE_FLOOR, SceneSummary, Summary};

/// How many robust standard deviations, of the logarithm of relMSE, make an outlier.
const OUTLIER: f64 = 6.0;
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

/// Seeds differ by a factor, so errors are compared by their logarithms; how much they usually differ is
/// taken from all numbers of samples together.
fn outlier(summary: &Summary) -> Option<String> {
    let last = summary.points.last().filter(|point| point.by_seed.len() >= 4)?;
    let distance = |error: f64, middle: f64| (error / middle).ln();
    let all: Vec<f64> = (summary.points.iter())
        .filter(|point| point.by_seed.len() >= 4)
        .flat_map(|point| {
            point.by_seed.iter().map(|(_, error)| distance(*error, point.quartiles[1]).abs())
        })
        .collect();
    let spread = (1.4826 * median(&all)).max(LEAST_SPREAD);
    let far =
        |(_, error): &&(u64, f64)| distance(*error, last.quartiles[1]).abs() > OUTLIER * spread;
    let (seed, error) = last.by_seed.iter().find(far)?;
    Some(format!(
        "seed {seed} stands out: its relMSE at {} samples is {:.3e}, the median {:.3e}; a few samples \
         make up its error.",
        last.spp, error, last.quartiles[1]
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
