//! What a render reports while it runs.

use std::io::{self, Write};

use super::{Film, Layers};
use crate::work::Work;

/// The state of a render.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Progress {
    /// The part of the budget that is used, in [0, 1].
    pub fraction: f64,
    /// Seconds since the start.
    pub seconds: f64,
    /// Samples that every pixel has.
    pub samples: u32,
    /// Root mean square of the standard errors of the pixels over the mean of the image, after
    /// the last pass; `None` until each pixel has two samples.
    pub relative_error: Option<f64>,
    /// Rays and densities up to the last pass.
    pub work: Work,
}

impl Progress {
    /// Seconds that remain at the speed so far; `None` before anything is done.
    pub fn seconds_left(&self) -> Option<f64> {
        (self.fraction > 0.0).then(|| self.seconds * (1.0 - self.fraction) / self.fraction)
    }
}

/// Watches a render and may end it. Called from all threads.
pub trait Observer: Sync {
    /// Called after each work unit.
    fn progress(&self, progress: &Progress);

    /// Whether to stop at the next pixel and keep what has been rendered.
    fn cancelled(&self) -> bool;

    /// Called after each pass with the image so far, in which all pixels have the same number of samples (unless
    /// sampling is adaptive), and with what makes the images beside it. The time that it takes is not counted as
    /// rendering.
    fn look(&self, film: &Film, progress: &Progress, layers: &dyn Fn() -> Layers) {
        let _ = (film, progress, layers);
    }

    /// Whether the state of the render is wanted now, to go on from it later ([`resume`](super::resume)). Asked after
    /// each work unit by all threads, and with `ended` once at the end.
    fn wants_state(&self, ended: bool) -> bool {
        let _ = ended;
        false
    }

    /// Called with what writes the state that was wanted; meanwhile the render waits. The time that it takes is not
    /// counted as rendering.
    fn keep_state(&self, write: StateWriter<'_>) {
        let _ = write;
    }

    /// The number of samples at which a pass is to end for the next [`look`](Self::look); passes grow as they
    /// like if there is none, or it has been reached.
    fn next_look(&self, progress: &Progress) -> Option<u32> {
        let _ = progress;
        None
    }
}

/// What writes the state of a render.
pub type StateWriter<'a> = &'a dyn Fn(&mut dyn Write) -> io::Result<()>;

/// The observer that neither looks nor stops.
impl Observer for () {
    fn progress(&self, _: &Progress) {}

    fn cancelled(&self) -> bool {
        false
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn time_left_extrapolates() {
        let mut progress = Progress { fraction: 0.25, seconds: 10.0, ..Progress::default() };
        assert_eq!(progress.seconds_left(), Some(30.0));
        progress.fraction = 0.0;
        assert_eq!(progress.seconds_left(), None);
    }
}
