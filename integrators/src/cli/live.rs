//! The picture while it grows: in the terminal, and as a file that viewers reload.

use std::fmt::Write;
use std::path::{Path, PathBuf};
use std::sync::Mutex;
use std::time::Instant;

use super::arguments::RenderArguments;
use super::terminal::Terminal;
use super::warn;
use crate::image::exr::{Attribute, Exr};
use crate::image::png::srgb_encode;
use crate::image::{RgbImage, is_finite};
use crate::render::checkpoint::Checkpoint;
use crate::render::progress::StateWriter;
use crate::render::{Film, Layers, Observer, Progress};

/// Seconds between two pictures in the terminal.
const INTERVAL: f64 = 1.0;

/// Watches a render for the terminal, and shows the picture in between.
pub(super) struct Live<'t> {
    terminal: &'t Terminal,
    /// Seconds between two pictures in the terminal, if it is to show them.
    shown: Option<f64>,
    /// Seconds between two files, and where they go.
    written: Option<(f64, PathBuf)>,
    /// Seconds between two states that are kept, and in what.
    kept: Option<(f64, &'t Checkpoint)>,
    state: Mutex<State>,
}

/// When pictures were last shown and written, and how many lines the shown one has.
#[derive(Default)]
struct State {
    shown: Option<Instant>,
    written: Option<Instant>,
    kept: Option<Instant>,
    lines: usize,
}

impl<'t> Live<'t> {
    /// What the command line asks for.
    pub fn new(
        terminal: &'t Terminal,
        arguments: &RenderArguments,
        output: &Path,
        checkpoint: Option<&'t Checkpoint>,
    ) -> Self {
        let columns = terminal.columns();
        if arguments.live && columns.is_none() {
            warn("warning: --live shows nothing, for stderr is no terminal");
        }
        Self {
            terminal,
            shown: (arguments.live && columns.is_some()).then_some(INTERVAL),
            written: arguments.live_exr.map(|seconds| (seconds, output.to_owned())),
            kept: checkpoint.map(|checkpoint| (arguments.checkpoint_every, checkpoint)),
            state: Mutex::new(State { kept: Some(Instant::now()), ..State::default() }),
        }
    }

    fn show(&self, state: &mut State, image: &RgbImage) {
        let columns = self.terminal.columns().unwrap_or(80);
        let text = half_blocks(image, columns);
        // Back up over the last picture.
        let up = if state.lines > 0 { format!("\x1b[{}A", state.lines) } else { String::new() };
        state.lines = text.lines().count();
        self.terminal.print(&format!("{up}{text}"));
    }

    fn write(&self, path: &Path, film: &Film, progress: &Progress) {
        let samples = i32::try_from(progress.samples).unwrap_or(i32::MAX);
        let attributes = [
            ("samples".to_owned(), Attribute::Integer(samples)),
            ("seconds".to_owned(), Attribute::Number(progress.seconds)),
        ];
        let exr = Exr {
            rgb: film.image(),
            variance: film.variance(),
            layers: Default::default(),
            attributes: attributes.into(),
        };
        if let Err(error) = exr.write(path) {
            warn(&format!("warning: {error}"));
        }
    }
}

/// Whether so many seconds have gone by; the first time is always due.
fn is_due(last: &mut Option<Instant>, seconds: f64) -> bool {
    let due = last.is_none_or(|last| last.elapsed().as_secs_f64() >= seconds);
    if due {
        *last = Some(Instant::now());
    }
    due
}

impl Observer for Live<'_> {
    fn progress(&self, progress: &Progress) {
        self.terminal.progress(progress);
    }

    fn cancelled(&self) -> bool {
        self.terminal.cancelled()
    }

    fn look(&self, film: &Film, progress: &Progress, _: &dyn Fn() -> Layers) {
        let Ok(mut state) = self.state.lock() else { return };
        if let Some(seconds) = self.shown
            && is_due(&mut state.shown, seconds)
        {
            self.show(&mut state, &film.image());
        }
        if let Some((seconds, path)) = &self.written
            && is_due(&mut state.written, *seconds)
        {
            self.write(path, film, progress);
        }
    }

    fn wants_state(&self, ended: bool) -> bool {
        let Some((seconds, _)) = self.kept else { return false };
        // Whoever finds the lock taken leaves it to its holder.
        let due = || self.state.try_lock().is_ok_and(|mut state| is_due(&mut state.kept, seconds));
        ended || due()
    }

    fn keep_state(&self, write: StateWriter<'_>) {
        let Some((_, checkpoint)) = self.kept else { return };
        if let Err(error) = checkpoint.write(write) {
            warn(&format!("warning: cannot write `{}`: {error}", checkpoint.path().display()));
        }
        if let Ok(mut state) = self.state.lock() {
            state.kept = Some(Instant::now());
        }
    }

    fn next_look(&self, progress: &Progress) -> Option<u32> {
        let intervals = self.shown.into_iter().chain(self.written.as_ref().map(|(s, _)| *s));
        let interval = intervals.reduce(f64::min)?;
        // As many samples as fit at the speed so far.
        let fitting = f64::from(progress.samples) * interval / progress.seconds.max(1e-9);
        Some(progress.samples.saturating_add((fitting as u32).max(1)))
    }
}

/// A picture as text: each character shows two pixels, one above the other, as a half block in two colours. It has
/// at most so many columns, and pixels are means over the image's.
fn half_blocks(image: &RgbImage, columns: usize) -> String {
    let width = image.width().min(columns.max(1));
    let scale = image.width() as f64 / width as f64;
    let rows = ((image.height() as f64 / scale / 2.0).round() as usize).max(1);
    let mut text = String::new();
    for row in 0..rows {
        for column in 0..width {
            let at = |half: usize| {
                let rows = range(2 * row + half, 2 * rows, image.height());
                colour(image, range(column, width, image.width()), rows)
            };
            let ([r, g, b], [s, h, c]) = (at(0), at(1));
            let _ = write!(text, "\x1b[38;2;{r};{g};{b};48;2;{s};{h};{c}m▀");
        }
        text.push_str("\x1b[0m\n");
    }
    text
}

/// The pixels that belong to part `k` of `parts` of a side; one at least.
fn range(k: usize, parts: usize, side: usize) -> std::ops::Range<usize> {
    let begin = (k * side / parts).min(side - 1);
    begin..((k + 1) * side / parts).max(begin + 1)
}

/// The mean of pixels as it is shown.
fn colour(
    image: &RgbImage,
    columns: std::ops::Range<usize>,
    rows: std::ops::Range<usize>,
) -> [u8; 3] {
    let pixels = rows.flat_map(|y| columns.clone().map(move |x| image.pixel(x, y)));
    let pixels: Vec<[f32; 3]> = pixels.filter(is_finite).collect();
    [0, 1, 2].map(|c| {
        let sum: f32 = pixels.iter().map(|pixel| pixel[c]).sum();
        let mean = (sum / pixels.len().max(1) as f32).clamp(0.0, 1.0);
        (255.0 * srgb_encode(mean) + 0.5) as u8
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn two_pixels_a_character() {
        let image = RgbImage::from_fn(2, 2, |x, y| [x as f32, y as f32, 0.0]);
        let text = half_blocks(&image, 80);
        let expected = "\x1b[38;2;0;0;0;48;2;0;255;0m▀\x1b[38;2;255;0;0;48;2;255;255;0m▀\x1b[0m\n";
        assert_eq!(text, expected);
    }

    #[test]
    fn wide_pictures_are_reduced() {
        let image = RgbImage::filled(300, 100, [f32::NAN; 3]);
        let text = half_blocks(&image, 60);
        let shown: Vec<usize> = text.lines().map(|line| line.matches('▀').count()).collect();
        assert_eq!(shown, [60; 10]);
        assert!(text.starts_with("\x1b[38;2;0;0;0;"));
        assert_eq!(half_blocks(&RgbImage::filled(1, 1, [1.0; 3]), 10).lines().count(), 1);
    }
}
