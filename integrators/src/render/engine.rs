//! Passes over tiles by all cores.

use std::collections::BTreeMap;
use std::io::{self, Read};
use std::sync::atomic::{AtomicBool, AtomicU64, AtomicUsize, Ordering};
use std::sync::{Mutex, MutexGuard, PoisonError};
use std::time::Instant;

use super::film::{Film, PixelEstimate, relative_error};
use super::gathered::Gathered;
use super::passes::{State, next_pass};
use super::progress::{Observer, Progress};
use super::splats::SplatSums;
use super::windows::{Batches, WINDOW, decides_at, window_errors};
use super::{AnyKernel, Budget, Chain, ErrorBudget, Layers, RenderSettings, Splats, Worker};
use crate::image::RgbImage;
use crate::scene::Filter;
use crate::work::{Work, threads};

mod state;
#[cfg(test)]
mod tests;

/// The side of a tile in pixels: tiles are the windows whose error is judged.
const TILE: u32 = WINDOW;

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

/// How many contributions to other pixels a thread collects before it hands them over.
const COLLECTED: usize = 1 << 14;

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

    /// [`Job::run_pass`] for a tile: whether any pixel got a sample.
    fn run_tile(&self, tile: &mut Tile<'_>, samples: u32, worker: &mut Worker<'_>) -> bool {
        if tile.good_enough {
            return false;
        }
        let (target, mut moved) = (self.done + samples, false);
        let (mut invalid, mut splats) = (0, Splats::new(self.layered));
        splats.is_shared = self.filter.is_some();
        let sums = self.splats.as_ref().map(lock);
        let (scale, most_shared) = sums.map_or((1.0, f64::MAX), |sums| (sums.scale(), sums.most()));
        let mut gathered = self.filter.map(|filter| {
            let rows = tile.pixels.len() as u32 / tile.width;
            Gathered::new(filter, self.size, tile.origin, (tile.width, rows)).scaled_by(scale)
        });
        'pixels: for (index, pixel) in tile.pixels.iter_mut().enumerate() {
            if self.observer.cancelled() {
                break;
            }
            let (dx, dy) = (index as u32 % tile.width, index as u32 / tile.width);
            let position = (tile.origin.0 + dx, tile.origin.1 + dy);
            let begin = pixel.count();
            for number in begin..target {
                splats.begin();
                let value = worker(position, number, &mut splats);
                if splats.is_given_up() {
                    break 'pixels;
                }
                moved = true;
                // What others get a share of may not be beyond all measure.
                let most = match splats.shares() {
                    Some(_) => most_shared.min(f32::MAX.into()),
                    None => f32::MAX.into(),
                };
                let valid = value.iter().all(|v| f64::from(v.abs()) <= most);
                let mut value = if valid { value } else { [0.0; 3] };
                invalid += u64::from(!valid);
                match (&mut gathered, splats.shares()) {
                    (Some(gathered), Some(shares)) => {
                        gathered.add(shares, value);
                        let counts = shares.own().map_or(1.0, |(_, counts)| counts);
                        value = value.map(|v| v * counts);
                        if gathered.is_full() {
                            self.hand_over_gathered(gathered);
                        }
                    }
                    (Some(_), None) => splats.add(position, value),
                    _ => {}
                }
                match &mut tile.chain {
                    None => pixel.add(value),
                    Some(chain) => {
                        chain.step(&mut splats);
                        pixel.add_chained(value);
                    }
                }
            }
            if splats.len() > COLLECTED {
                self.hand_over(&mut splats);
            }
        }
        self.hand_over(&mut splats);
        gathered.iter_mut().for_each(|gathered| self.hand_over_gathered(gathered));
        self.invalid.fetch_add(invalid, Ordering::Relaxed);
        moved
    }

    fn hand_over(&self, splats: &mut Splats) {
        if let (Some(sums), false) = (&self.splats, splats.is_empty()) {
            lock(sums).take(splats);
        }
    }

    fn hand_over_gathered(&self, gathered: &mut Gathered) {
        if let Some(sums) = &self.splats {
            gathered.hand_over(&mut lock(sums));
        }
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

    /// The mean number of samples of a pixel. Light paths do not depend on the pixel that they were sampled
    /// with: in a pass that was cut short, what counts is how many there were.
    fn samples(&self) -> f64 {
        let of = |tile: &Mutex<Tile<'_>>| {
            lock(tile).pixels.iter().map(|p| u64::from(p.count())).sum::<u64>()
        };
        let pixels = f64::from(self.size.0) * f64::from(self.size.1);
        self.tiles.iter().map(of).sum::<u64>() as f64 / pixels
    }

    /// The images beside the image.
    fn layers(&self) -> Layers {
        let Some(sums) = &self.splats else { return BTreeMap::new() };
        let (width, height) = (self.size.0 as usize, self.size.1 as usize);
        let image = |pixels: &[[[f64; 3]; 2]], part: usize| {
            RgbImage::from_fn(width, height, |x, y| pixels[y * width + x][part].map(single))
        };
        let layers = lock(sums).layers(self.samples());
        let images = |pixels: Vec<_>| [image(&pixels, 0), image(&pixels, 1)];
        layers.into_iter().map(|(layer, pixels)| (layer, images(pixels))).collect()
    }

    /// The image so far.
    fn film(&self) -> Film {
        let mut film = Film::new(self.size);
        for tile in &self.tiles {
            let tile = lock(tile);
            for (index, pixel) in tile.pixels.iter().enumerate() {
                let (dx, dy) = (index as u32 % tile.width, index as u32 / tile.width);
                *film.pixel_mut(tile.origin.0 + dx, tile.origin.1 + dy) = *pixel;
            }
        }
        let Some(sums) = &self.splats else { return film };
        let (samples, sums) = (self.samples(), lock(sums));
        let mut own = Vec::new();
        if let Some(filter) = self.filter {
            (film, own) = film.shared(filter);
            film.limit_variance(|pixel| sums.shared_at_most(pixel, own[pixel]));
        }
        film.set_splats(|pixel| {
            let [mut mean, variance] = sums.estimate(pixel, samples);
            let shared = own.get(pixel).map_or([0.0; 3], |samples| sums.shared(pixel, *samples));
            mean.iter_mut().zip(shared).for_each(|(mean, shared)| *mean += shared);
            [mean, variance]
        });
        film
    }
}

/// A square part of the image (smaller at the right and lower border).
struct Tile<'a> {
    origin: (u32, u32),
    width: u32,
    pixels: Vec<PixelEstimate>,
    chain: Option<Chain<'a>>,
    /// Whether it needs no more samples.
    good_enough: bool,
}

/// Cuts an image into tiles, row by row from the top left.
fn tiles((width, height): (u32, u32), kernel: &dyn AnyKernel) -> Vec<Mutex<Tile<'_>>> {
    let mut tiles = Vec::new();
    for y in (0..height).step_by(TILE as usize) {
        for x in (0..width).step_by(TILE as usize) {
            let (columns, rows) = (TILE.min(width - x), TILE.min(height - y));
            let pixels = vec![PixelEstimate::default(); (columns * rows) as usize];
            let chain = kernel.chain(tiles.len());
            let tile = Tile { origin: (x, y), width: columns, pixels, chain, good_enough: false };
            tiles.push(Mutex::new(tile));
        }
    }
    tiles
}

/// A number in single precision, where what is beyond its range is its end.
fn single(v: f64) -> f32 {
    v.min(f64::from(f32::MAX)) as f32
}

/// Locks what threads share. A thread that panicked ends the render anyway, so its poison does not matter.
fn lock<T>(shared: &Mutex<T>) -> MutexGuard<'_, T> {
    shared.lock().unwrap_or_else(PoisonError::into_inner)
}
