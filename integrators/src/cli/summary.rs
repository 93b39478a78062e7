//! What is said of a render that is over.

use std::iter::once;
use std::path::{Path, PathBuf};

use super::terminal::{duration, percent};
use crate::render::film::relative_error;
use crate::render::{Layer, Rendered};

/// One line about the files written and the quality reached.
pub(super) fn summary(output: &Path, pictures: &[PathBuf], rendered: &Rendered) -> String {
    let samples = match rendered.film.samples() {
        (fewest, most) if fewest == most => format!("{most}"),
        (fewest, most) => format!("{fewest} to {most}"),
    };
    let files = once(output).chain(pictures.iter().map(PathBuf::as_path));
    let files: Vec<String> = files.map(|file| file.display().to_string()).collect();
    let mut line = format!(
        "{}: {samples} samples per pixel in {}",
        files.join(", "),
        duration(rendered.seconds)
    );
    if let Some(error) = relative_error(rendered.film.pixels().iter()) {
        // What gradients add to it is not known.
        let sampled = if rendered.layers.contains_key(&Layer::Dx) { " of the samples" } else { "" };
        line += &format!(", error{sampled} {}", percent(error));
    }
    line
}

/// What was computed, and how fast.
pub(super) fn statistics(rendered: &Rendered) -> String {
    let work = rendered.work;
    let samples: f64 = rendered.film.pixels().iter().map(|pixel| f64::from(pixel.count())).sum();
    let line = |name: &str, count: u64| {
        let (count, seconds) = (count as f64, rendered.seconds.max(1e-9));
        format!(
            "{name:<14}{count:.4e}, {:.2} per sample, {:.3e} per second",
            count / samples.max(1.0),
            count / seconds
        )
    };
    [
        line("samples", samples as u64),
        line("rays, nearest", work.nearest),
        line("rays, any", work.occlusion),
        line("densities", work.densities),
    ]
    .join("\n")
}
