//! Summaries as Markdown.

use std::fmt::Write;

use super::findings::findings;
use super::summary::{Reached, SceneSummary, Summary, TARGET_SAMPLES};

/// The table of all scenes, with what its columns mean.
pub fn table(scenes: &[SceneSummary]) -> String {
    let mut text = String::from(
        "| scene | integrator | samples | seconds | error | time to target | efficiency | slope | bias |\n\
         | --- | --- | ---: | ---: | ---: | ---: | ---: | ---: | ---: |\n",
    );
    for scene in scenes {
        for summary in &scene.curves {
            let _ = writeln!(text, "| {} | {} |", scene.scene, cells(summary).join(" | "));
        }
    }
    text
}

/// The columns of the table in words.
pub fn legend(scenes: &[SceneSummary]) -> String {
    let mut text = format!(
        "Error: root of the median relMSE after that many samples and seconds. Time to target: seconds to the \
         error that the baseline has with {TARGET_SAMPLES} samples per pixel (~ extrapolated as 1/√t, < reached \
         at the first measurement). Efficiency: 1/(error² time) relative to the baseline. Slope: exponent of the \
         error over samples with its 99 % interval. Bias: root mean square of what \
         remains of the relative error when the seeds are averaged, without what the reference explains: with `*` if \
         it is significant, otherwise the upper end of its 99 % interval.\n"
    );
    for scene in scenes {
        let target = scene.target.map_or("unknown".to_owned(), |target| format!("{target:.4}"));
        let floor = match scene.floor {
            Some(floor) => format!("its own error is {:.4}", floor.sqrt()),
            None => "its own error is not known".to_owned(),
        };
        let _ = writeln!(
            text,
            "\n{}: the baseline is {}, the target {target}; the reference is {}, {floor}.",
            scene.scene, scene.baseline, scene.reference
        );
    }
    text
}

/// Everything in words that deserves attention, as a list.
pub fn remarks(scenes: &[SceneSummary], notes: &[String]) -> String {
    let all: Vec<String> = notes.iter().cloned().chain(scenes.iter().flat_map(findings)).collect();
    if all.is_empty() {
        return "Nothing stands out: no bias, no slope other than -1/2, no seed apart.\n"
            .to_owned();
    }
    all.iter().map(|text| format!("- {text}\n")).collect()
}

/// The cells of a row after the scene.
pub fn cells(summary: &Summary) -> [String; 8] {
    let none = || "–".to_owned();
    let last = summary.points.last();
    let reached = summary.reached.map_or_else(none, |reached| match reached {
        Reached::Within(seconds) => figure(seconds),
        Reached::Before(seconds) => format!("< {}", figure(seconds)),
        Reached::Extrapolated(seconds) => format!("~ {}", figure(seconds)),
    });
    let slope = summary.slope.map_or_else(none, |slope| {
        format!("{:.2} ± {:.2}", slope.value, (slope.high - slope.low) / 2.0)
    });
    let estimate = summary.estimate.as_ref().filter(|estimate| !estimate.bias[0].is_nan());
    let bias = estimate.map_or_else(none, |estimate| {
        let root = |square: f64| (square - estimate.floor.unwrap_or(0.0)).max(0.0).sqrt();
        match estimate.biased {
            true => format!("{:.4} *", root(estimate.bias[0])),
            false => format!("< {:.4}", root(estimate.bias[2])),
        }
    });
    [
        summary.curve.label(),
        last.map_or_else(none, |point| point.spp.to_string()),
        last.map_or_else(none, |point| figure(point.seconds)),
        last.map_or_else(none, |point| format!("{:.4}", point.quartiles[1].sqrt())),
        reached,
        summary.efficiency.map_or_else(none, figure),
        slope,
        bias,
    ]
}

/// A number with three digits.
fn figure(value: f64) -> String {
    let digits = (2.0 - value.abs().max(1e-9).log10().floor()).clamp(0.0, 4.0) as usize;
    format!("{value:.digits$}")
}
