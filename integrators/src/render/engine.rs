//! Passes over tiles by all cores.

use std::io::{self, Read};
use std::sync::atomic::{AtomicBool, AtomicU64, AtomicUsize, Ordering};
use std::sync::{Mutex, MutexGuard, PoisonError};
use std::time::Instant;

use super::film::{Film, PixelEstimate, relative_error};
use super::passes::{State, next_pass};
use super::progress::{Observer, Progress};
use super::splats::SplatSums;
use super::windows::{Batches, decides_at, window_errors};
use super::{AnyKernel, Budget, ErrorBudget, Layers, RenderSettings};
use crate::scene::Filter;
use crate::work::{Work, threads};

mod images;
mod state;
#[cfg(test)]
mod tests;
mod tile;

use tile::{Tile, tiles};

/// The outcome of [`render`].
#[derive(Clone, Debug, PartialEq)]
pub struct Rendered {
    /// The pixels. All have the same number of samples, unless the render was cancelled or adaptive.
    pub film: Film,
    /// Seconds from start to end, with those that making the kernel spent on the image.
    pub seconds: f64,
    /// Rays and densities.
    pub work: Work,
    /// Samples that were NaN or infinite and count as black. Any such sample is a defect of the
    /// kernel.
    pub invalid_samples: u64,
    /// The images beside the image that samples added to, each with the variance of its pixels.
    pub layers: Layers,
    /// Whether the observer ended the render before the budget was used.
    pub cancelled: bool,
}

/// Renders an image: evaluates the kernel for each pixel until the budget is used or the observer
/// cancels. See the [module](super) for how work is distributed.
pub fn render(
    kernel: &dyn AnyKernel,
    settings: &RenderSettings,
    observer: &dyn Observer,
) -> Rendered {
    Job::new(kernel, settings, observer).run()
}

/// Goes on with a render whose state an observer has kept, with a kernel and settings that are the same, apart from
/// the budget and the number of threads. The image is that of a render in one go, bit by bit.
///
/// # Errors
/// If the state cannot be read, or is that of another render.
pub fn resume(
    kernel: &dyn AnyKernel,
    settings: &RenderSettings,
    observer: &dyn Observer,
    state: &mut dyn Read,
) -> io::Result<Rendered> {
    let mut job = Job::new(kernel, settings, observer);
    job.restore(state)?;
    Ok(job.run())
}

/// A render in progress.
struct Job<'a> {
    kernel: &'a dyn AnyKernel,
    observer: &'a dyn Observer,
    budget: Budget,
    /// Each is locked once for each pass, by the one thread that drew it.
    tiles: Vec<Mutex<Tile<'a>>>,
    threads: usize,
    start: Instant,
    /// Seconds that the observer looked at the image.
    looking: f64,
    /// What this thread had counted at the start.
    before: Work,
    /// Seconds that samples had taken, and what they had computed, where this goes on with another render.
    earlier: (f64, Work),
    /// Samples of each pixel after the last complete pass, and the relative error then.
    done: u32,
    error: Option<f64>,
    /// Batches of samples that depend on each other, and whether all windows are good enough.
    batches: Batches,
    good_enough: bool,
    invalid: AtomicU64,
    /// What samples add to other pixels, if they do.
    splats: Option<Mutex<SplatSums>>,
    /// By what samples are shared among pixels, if they are.
    filter: Option<Filter>,
    layered: usize,
    size: (u32, u32),
}

impl<'a> Job<'a> {
    fn new(
        kernel: &'a dyn AnyKernel,
        settings: &RenderSettings,
        observer: &'a dyn Observer,
    ) -> Self {
        // Pixels whose samples end early go without those of others.
        let is_adaptive = matches!(settings.budget, Budget::Error(limit) if limit.adaptive);
        let is_shared = |filter: &Filter| filter.is_shared() && (kernel.splats() || !is_adaptive);
        let filter = kernel.filter().filter(is_shared);
        let has_splats = kernel.splats() || settings.layered > 0 || filter.is_some();
        let cores = || std::thread::available_parallelism().map_or(1, |n| n.get());
        Job {
            kernel,
            observer,
            budget: settings.budget,
            start: Instant::now(),
            before: Work::here(),
            earlier: Default::default(),
            tiles: tiles(settings.size, kernel),
            threads: settings.threads.unwrap_or_else(cores).max(1),
            looking: 0.0,
            done: 0,
            error: None,
            batches: Batches::default(),
            good_enough: false,
            invalid: AtomicU64::new(0),
            splats: has_splats.then(|| {
                let exponent = kernel.brightness_exponent();
                let sums = SplatSums::new(settings.size).with_brightness(exponent);
                Mutex::new(if filter.is_some() { sums.with_shares() } else { sums })
            }),
            filter,
            layered: settings.layered,
            size: settings.size,
        }
    }

    /// Renders until the budget is used or the observer cancels.
    fn run(mut self) -> Rendered {
        let (kernel, observer) = (self.kernel, self.observer);
        let mut cancelled = observer.cancelled();
        while !cancelled && let Some(samples) = next_pass(self.budget, &self.state()) {
            let samples = samples.min(kernel.largest_pass());
            if !kernel.begin_pass(self.done, self.threads, &|| observer.cancelled()) {
                cancelled = true;
                break;
            }
            // A pass that waits while its state is written goes on where each pixel is.
            while !self.run_pass(samples) {
                self.keep_state();
            }
            cancelled = observer.cancelled() && !self.complete(self.done + samples);
            if !cancelled {
                self.end_pass(samples);
            }
        }
        if observer.wants_state(true) {
            self.keep_state();
        }
        let lost = self.splats.as_ref().map_or(0, |sums| lock(sums).invalid());
        Rendered {
            seconds: self.seconds(),
            film: self.film(),
            work: self.work(),
            layers: self.layers(),
            invalid_samples: self.invalid.load(Ordering::Relaxed) + lost,
            cancelled,
        }
    }

    /// Has the observer keep the state. No thread computes meanwhile.
    fn keep_state(&mut self) {
        let begin = Instant::now();
        self.observer.keep_state(&|to| self.save(to));
        self.looking += begin.elapsed().as_secs_f64();
    }

    /// Seconds used so far.
    fn seconds(&self) -> f64 {
        self.sampling() + self.kernel.preparation().seconds
    }

    /// Seconds that samples took.
    fn sampling(&self) -> f64 {
        self.earlier.0 + self.start.elapsed().as_secs_f64() - self.looking
    }

    /// What samples up to the last pass have computed.
    fn sampled(&self) -> Work {
        let mut work = Work::here() - self.before;
        work += self.earlier.1;
        work
    }

    /// What has been computed up to the last pass.
    fn work(&self) -> Work {
        let mut work = self.sampled();
        work += self.kernel.preparation().work;
        work
    }

    fn state(&self) -> State {
        State {
            done: self.done,
            seconds: self.seconds(),
            sampling: self.sampling(),
            next_look: self.observer.next_look(&self.progress(0, 0, self.work())),
            good_enough: self.good_enough,
        }
    }

    /// Adds samples to each pixel until it has `samples` more than all had, or fewer if the observer cancels. Returns
    /// false if it has stopped earlier for the observer to keep the state.
    fn run_pass(&self, samples: u32) -> bool {
        let waits = AtomicBool::new(false);
        let (next, finished) = (AtomicUsize::new(0), AtomicUsize::new(0));
        let work = self.work();
        let cancelled = || self.observer.cancelled();
        let job = || {
            let mut worker = self.kernel.worker_until(&cancelled);
            while !waits.load(Ordering::Relaxed)
                && let Some(tile) = self.tiles.get(next.fetch_add(1, Ordering::Relaxed))
            {
                let moved = self.run_tile(&mut lock(tile), samples, &mut worker);
                if self.observer.cancelled() {
                    return;
                }
                let finished = finished.fetch_add(1, Ordering::Relaxed) + 1;
                self.observer.progress(&self.progress(samples, finished, work));
                // Something is computed in between, however often the state is wanted.
                if moved && self.observer.wants_state(false) {
                    waits.store(true, Ordering::Relaxed);
                }
            }
        };
        threads((0..self.threads.min(self.tiles.len())).map(|_| job));
        !waits.into_inner()
    }

    /// The state when `finished` tiles of a pass of `samples` are done.
    fn progress(&self, samples: u32, finished: usize, work: Work) -> Progress {
        let seconds = self.seconds();
        let part = finished as f64 / self.tiles.len() as f64;
        let drawn = f64::from(self.done) + part * f64::from(samples);
        let fraction = match self.budget {
            Budget::Samples(total) => drawn / f64::from(total),
            Budget::Seconds(limit) => seconds / limit,
            Budget::Error(limit) => (seconds / limit.seconds).max(drawn / f64::from(limit.samples)),
        };
        let fraction = fraction.clamp(0.0, 1.0);
        Progress { fraction, seconds, samples: self.done, relative_error: self.error, work }
    }

    /// Whether no pixel lacks one of `samples` samples.
    fn complete(&self, samples: u32) -> bool {
        let all = |tile: &Mutex<Tile<'_>>| {
            let tile = lock(tile);
            tile.good_enough || tile.pixels.iter().all(|p| p.count() >= samples)
        };
        let state = State { done: samples, ..self.state() };
        self.tiles.iter().all(all) && next_pass(self.budget, &state).is_none()
    }

    fn end_pass(&mut self, samples: u32) {
        self.done += samples;
        let film = self.film();
        self.error = relative_error(film.pixels().iter());
        if let Budget::Error(limit) = self.budget {
            if self.is_chained() && (self.done.is_power_of_two() || decides_at(self.done)) {
                self.batches.take(&film, self.done);
            }
            if decides_at(self.done) {
                self.judge(&film, limit);
            }
        }
        let begin = Instant::now();
        self.observer.look(&film, &self.progress(0, 0, self.work()), &|| self.layers());
        self.looking += begin.elapsed().as_secs_f64();
    }

    /// Whether samples are steps of Markov chains.
    fn is_chained(&self) -> bool {
        self.tiles.first().is_some_and(|tile| lock(tile).chain.is_some())
    }

    /// Finds out which windows are good enough.
    fn judge(&mut self, film: &Film, limit: ErrorBudget) {
        let chained = self.is_chained();
        let adaptive = limit.adaptive && self.splats.is_none();
        let variance = |index: usize, pixel: &PixelEstimate| {
            if chained { self.batches.variance(index) } else { pixel.variance_of_mean() }
        };
        let Some(errors) = window_errors(film, variance) else { return };
        self.good_enough = errors.iter().all(|error| *error <= limit.target);
        if adaptive {
            for (tile, error) in self.tiles.iter().zip(errors) {
                lock(tile).good_enough |= error <= limit.target;
            }
            self.good_enough = self.tiles.iter().all(|tile| lock(tile).good_enough);
        }
    }
}

/// Locks what threads share. A thread that panicked ends the render anyway, so its poison does not matter.
fn lock<T>(shared: &Mutex<T>) -> MutexGuard<'_, T> {
    shared.lock().unwrap_or_else(PoisonError::into_inner)
}
