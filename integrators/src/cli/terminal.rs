//! The progress bar, and Ctrl-C.

use std::io::{self, IsTerminal, Write};
use std::sync::{Mutex, OnceLock};
use std::time::{Duration, Instant};

use indicatif::{ProgressBar, ProgressStyle};

use super::{INTERRUPTED, warn};
use crate::render::{Observer, Progress};

/// When Ctrl-C came first; a static because a signal handler lives as long as the process.
static FIRST: OnceLock<Instant> = OnceLock::new();

/// What follows within this time is the same Ctrl-C: a program that passes it on to a group signals some of it twice.
const SAME: Duration = Duration::from_millis(500);

/// Steps of the bar from empty to full.
const STEPS: u64 = 1000;
/// Time between two updates of the bar.
const INTERVAL: Duration = Duration::from_millis(100);

/// Shows progress on a terminal, nothing elsewhere, and cancels on Ctrl-C.
pub(super) struct Terminal {
    bar: Option<ProgressBar>,
    /// When the bar was last updated.
    shown: Mutex<Option<Instant>>,
}

impl Terminal {
    /// Takes over Ctrl-C: the first ends the render, the second the program, if it is one.
    pub fn new() -> Self {
        let handler = || {
            if FIRST.get_or_init(Instant::now).elapsed() > SAME {
                std::process::exit(i32::from(INTERRUPTED));
            }
        };
        if let Err(error) = ctrlc::set_handler(handler) {
            warn(&format!("warning: Ctrl-C will lose the image: {error}"));
        }
        Self { bar: io::stderr().is_terminal().then(bar), shown: Mutex::new(None) }
    }

    /// Removes the bar.
    pub fn finish(&self) {
        if let Some(bar) = &self.bar {
            bar.finish_and_clear();
        }
    }

    /// The columns of the terminal, if stderr is one.
    pub fn columns(&self) -> Option<usize> {
        self.bar.as_ref()?;
        Some(console::Term::stderr().size_checked().map_or(80, |(_, columns)| columns.into()))
    }

    /// Prints a text that is to stay, above the bar.
    pub fn print(&self, text: &str) {
        let write = || {
            // There is nowhere left to report a failure to do so.
            let _ = io::stderr().write_all(text.as_bytes());
        };
        match &self.bar {
            Some(bar) => bar.suspend(write),
            None => write(),
        }
    }

    /// Whether it is time for an update; never for two threads at once.
    fn is_due(&self) -> bool {
        // A thread that finds the lock taken leaves the update to its holder.
        let Ok(mut shown) = self.shown.try_lock() else { return false };
        let due = shown.is_none_or(|last| last.elapsed() >= INTERVAL);
        if due {
            *shown = Some(Instant::now());
        }
        due
    }
}

impl Observer for Terminal {
    fn progress(&self, progress: &Progress) {
        if let Some(bar) = &self.bar
            && self.is_due()
        {
            bar.set_position((progress.fraction * STEPS as f64) as u64);
            bar.set_message(message(progress));
        }
    }

    fn cancelled(&self) -> bool {
        FIRST.get().is_some()
    }
}

fn bar() -> ProgressBar {
    let bar = ProgressBar::new(STEPS);
    let template = "{bar:40} {percent:>3} %  {msg}";
    bar.set_style(ProgressStyle::with_template(template).unwrap_or(ProgressStyle::default_bar()));
    bar
}

/// Time left, samples so far and current error.
fn message(progress: &Progress) -> String {
    let mut message = format!("{} spp", progress.samples);
    if let Some(seconds) = progress.seconds_left() {
        message = format!("{} left, {message}", duration(seconds));
    }
    if let Some(error) = progress.relative_error {
        message += &format!(", error {}", percent(error));
    }
    message
}

/// A ratio in percent with three significant digits at least.
pub(super) fn percent(ratio: f64) -> String {
    let percent = 100.0 * ratio;
    let digits = (2.0 - percent.abs().log10().floor()).clamp(0.0, 6.0);
    // `percent` = 0 has an infinite logarithm, which the clamp turns into 6 digits.
    format!("{percent:.*} %", digits as usize)
}

/// A duration in units that a person would choose.
pub(super) fn duration(seconds: f64) -> String {
    let whole = seconds.round() as u64;
    match whole {
        _ if seconds < 9.95 => format!("{seconds:.1} s"),
        ..60 => format!("{whole} s"),
        60..3600 => format!("{} min {:02} s", whole / 60, whole % 60),
        3600.. => format!("{} h {:02} min", whole / 3600, whole / 60 % 60),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn texts() {
        assert_eq!(duration(0.25), "0.2 s");
        assert_eq!(duration(59.4), "59 s");
        assert_eq!(duration(59.6), "1 min 00 s");
        assert_eq!(duration(3725.0), "1 h 02 min");
        assert_eq!((percent(0.012345), percent(1.5)), ("1.23 %".into(), "150 %".into()));
        assert_eq!(percent(0.0), "0.000000 %");
        let (fraction, relative_error) = (0.5, Some(0.05));
        let half =
            Progress { fraction, seconds: 20.0, samples: 8, relative_error, ..Progress::default() };
        assert_eq!(message(&half), "20 s left, 8 spp, error 5.00 %");
    }
}
