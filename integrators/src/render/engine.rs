//! Passes over tiles by all cores.

use std::collections::BTreeMap;
use std::io::{self, Read};
use std::sync::atomic::{AtomicBool, AtomicU64, AtomicUsize, Ordering};
use std::sync::{Mutex, MutexGuard, PoisonError};
use std::time::Instant;

use super::film::{Film, PixelEstimate, relative_error};
use super::passes::{State, next_pass};
use super::progress::{Observer, Progress};
use super::splats::SplatSums;
use super::windows::{Batches, WINDOW, decides_at, window_errors};
use super::{AnyKernel, Budget, Chain, Layer, RenderSettings, Splats, Worker};
use crate::image::RgbImage;
use crate::work::{Work, threads};

mod state;

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
    pub layers: BTreeMap<Layer, [RgbImage; 2]>,
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
        let has_splats = kernel.splats() || settings.layered > 0;
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
            splats: has_splats.then(|| Mutex::new(SplatSums::new(settings.size))),
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
            kernel.begin_pass(self.done, self.threads);
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
        let job = || {
            let mut worker = self.kernel.worker();
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
        for (index, pixel) in tile.pixels.iter_mut().enumerate() {
            if self.observer.cancelled() {
                break;
            }
            let (dx, dy) = (index as u32 % tile.width, index as u32 / tile.width);
            let position = (tile.origin.0 + dx, tile.origin.1 + dy);
            let begin = pixel.count();
            moved |= begin < target;
            if let Some(chain) = &mut tile.chain {
                (begin..target).for_each(|_| chain.step(&mut splats));
                pixel.count_chained(target.saturating_sub(begin));
            }
            // None is left where the chain has taken them.
            for number in pixel.count()..target {
                let value = worker(position, number, &mut splats);
                let valid = value.iter().all(|v| v.is_finite());
                pixel.add(if valid { value } else { [0.0; 3] });
                invalid += u64::from(!valid);
            }
            if splats.len() > COLLECTED {
                self.hand_over(&mut splats);
            }
        }
        self.hand_over(&mut splats);
        self.invalid.fetch_add(invalid, Ordering::Relaxed);
        moved
    }

    fn hand_over(&self, splats: &mut Splats) {
        if let (Some(sums), false) = (&self.splats, splats.is_empty()) {
            lock(sums).take(splats);
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
            self.judge(&film, limit.target, limit.adaptive && self.splats.is_none());
        }
        let begin = Instant::now();
        self.observer.look(&film, &self.progress(0, 0, self.work()));
        self.looking += begin.elapsed().as_secs_f64();
    }

    /// Finds out which windows are good enough.
    fn judge(&mut self, film: &Film, target: f64, adaptive: bool) {
        let chained = self.tiles.first().is_some_and(|tile| lock(tile).chain.is_some());
        if chained && (self.done.is_power_of_two() || decides_at(self.done)) {
            self.batches.take(film, self.done);
        }
        if !decides_at(self.done) {
            return;
        }
        let variance = |index: usize, pixel: &PixelEstimate| {
            if chained { self.batches.variance(index) } else { pixel.variance_of_mean() }
        };
        let Some(errors) = window_errors(film, variance) else { return };
        self.good_enough = errors.iter().all(|error| *error <= target);
        if adaptive {
            for (tile, error) in self.tiles.iter().zip(errors) {
                lock(tile).good_enough |= error <= target;
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
    fn layers(&self) -> BTreeMap<Layer, [RgbImage; 2]> {
        let Some(sums) = &self.splats else { return BTreeMap::new() };
        let (width, height) = (self.size.0 as usize, self.size.1 as usize);
        let image = |pixels: &[[[f64; 3]; 2]], part: usize| {
            RgbImage::from_fn(width, height, |x, y| pixels[y * width + x][part].map(|v| v as f32))
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
        if let Some(sums) = &self.splats {
            let (samples, sums) = (self.samples(), lock(sums));
            film.set_splats(|pixel| sums.estimate(pixel, samples));
        }
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

/// Locks what threads share. A thread that panicked ends the render anyway, so its poison does not matter.
fn lock<T>(shared: &Mutex<T>) -> MutexGuard<'_, T> {
    shared.lock().unwrap_or_else(PoisonError::into_inner)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::render::progress::StateWriter;
    use crate::render::{ErrorBudget, MarkovChain, PixelKernel};
    use crate::stored::Stored;
    use std::io::Write;
    use std::sync::atomic::AtomicU32;

    /// Noise whose mean is known: a hash of pixel and sample number, scaled to [0, 2 mean).
    struct Noise;

    impl PixelKernel for Noise {
        type Scratch = Vec<u8>;

        fn scratch(&self) -> Vec<u8> {
            Vec::new()
        }

        fn sample(&self, _: &mut Vec<u8>, pixel: (u32, u32), sample: u32) -> [f32; 3] {
            let seed = u64::from(pixel.0) << 42 | u64::from(pixel.1) << 21 | u64::from(sample);
            let mut state = seed.wrapping_mul(0x9e37_79b9_7f4a_7c15);
            [1.0, 2.0, 0.0].map(|mean| {
                state = (state ^ (state >> 31)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
                2.0 * mean * (state >> 40) as f32 / (1u32 << 24) as f32
            })
        }
    }

    fn settings(samples: u32, threads: usize) -> RenderSettings {
        let budget = Budget::Samples(samples);
        RenderSettings { threads: Some(threads), ..RenderSettings::new((37, 21), budget) }
    }

    #[test]
    fn the_image_does_not_depend_on_threads() {
        let one = render(&Noise, &settings(150, 1), &());
        for threads in [2, 3, 16, 100] {
            let many = render(&Noise, &settings(150, threads), &());
            assert!(one.film == many.film, "{threads} threads");
        }
        assert_eq!((one.film.samples(), one.cancelled), ((150, 150), false));
    }

    #[test]
    fn mean_and_variance_are_right() {
        let film = render(&Noise, &settings(1000, 2), &()).film;
        let (image, variance) = (film.image(), film.variance().unwrap());
        let pixels = image.pixels().len() as f64;
        for (channel, mean) in [(0, 1.0), (1, 2.0)] {
            let average = |i: &crate::image::RgbImage| {
                i.pixels().iter().map(|p| f64::from(p[channel])).sum::<f64>() / pixels
            };
            // The variance of a uniform number in [0, 2m) is m² / 3.
            let expected = mean * mean / 3.0 / 1000.0;
            approx::assert_relative_eq!(average(&variance), expected, max_relative = 0.01);
            let error = (expected / pixels).sqrt();
            assert!((average(&image) - mean).abs() < 4.0 * error, "{}", average(&image));
        }
        assert!(variance.pixels().iter().all(|p| p[2] == 0.0));
    }

    #[test]
    fn a_short_time_gives_one_sample_each() {
        let budget = Budget::Seconds(1e-9);
        let rendered = render(&Noise, &RenderSettings { budget, ..settings(1, 2) }, &());
        assert_eq!((rendered.film.samples(), rendered.cancelled), ((1, 1), false));
        assert_eq!(rendered.film.variance(), None);
    }

    #[test]
    fn time_ends_with_equal_sample_numbers() {
        let budget = Budget::Seconds(0.02);
        let film = render(&Noise, &RenderSettings { budget, ..settings(1, 2) }, &()).film;
        let (fewest, most) = film.samples();
        assert_eq!(fewest, most);
        let same = render(&Noise, &settings(most, 1), &()).film;
        assert!(film == same, "the same number of samples gives the same image");
    }

    /// Noise in the windows of the left half, and almost none on the right.
    struct Uneven;

    impl PixelKernel for Uneven {
        type Scratch = Vec<u8>;

        fn scratch(&self) -> Vec<u8> {
            Vec::new()
        }

        fn sample(&self, scratch: &mut Vec<u8>, pixel: (u32, u32), sample: u32) -> [f32; 3] {
            let noise = Noise.sample(scratch, pixel, sample)[0];
            [if pixel.0 < WINDOW { noise } else { 1.0 + 1e-3 * noise }; 3]
        }
    }

    #[test]
    fn an_error_ends_the_render() {
        let error = |target, adaptive| {
            let limit = ErrorBudget { target, samples: 5000, seconds: 1e9, adaptive };
            let budget = Budget::Error(limit);
            let settings = RenderSettings { size: (2 * WINDOW, WINDOW), ..settings(1, 2) };
            render(&Uneven, &RenderSettings { budget, ..settings }, &()).film
        };
        // The error of n samples is the root of 1 / 3 / n / 1.01: 4.2 % after 192, 5.1 % after 128.
        let even = error(0.045, false);
        assert_eq!(even.samples(), (192, 192));
        let uneven = error(0.045, true);
        assert_eq!(uneven.samples(), (16, 192));
        let of = |film: &Film, x: u32| film.pixels()[x as usize];
        assert_eq!((of(&uneven, 0).count(), of(&uneven, WINDOW).count()), (192, 16));
        assert_eq!(of(&uneven, 0), of(&even, 0));
        // What is asked for may be too much.
        assert_eq!(error(1e-9, false).samples(), (5000, 5000));
    }

    /// Wants to see the image at multiples of seven.
    #[derive(Default)]
    struct Look(Mutex<Vec<u32>>);

    impl Observer for Look {
        fn progress(&self, _: &Progress) {}

        fn cancelled(&self) -> bool {
            false
        }

        fn look(&self, film: &Film, progress: &Progress) {
            assert_eq!(film.samples(), (progress.samples, progress.samples));
            self.0.lock().unwrap().push(progress.samples);
        }

        fn next_look(&self, progress: &Progress) -> Option<u32> {
            Some((progress.samples / 7 + 1) * 7)
        }
    }

    #[test]
    fn the_observer_sees_what_it_asks_for() {
        let look = Look::default();
        let watched = render(&Noise, &settings(30, 2), &look);
        let seen = look.0.into_inner().unwrap();
        assert!([7, 14, 21, 28, 30].iter().all(|samples| seen.contains(samples)), "{seen:?}");
        assert!(watched.film == render(&Noise, &settings(30, 1), &()).film);
    }

    /// NaN in one sample of each pixel, negative infinity in another.
    struct Broken;

    impl PixelKernel for Broken {
        type Scratch = ();

        fn scratch(&self) {}

        fn sample(&self, _: &mut (), _: (u32, u32), sample: u32) -> [f32; 3] {
            match sample {
                1 => [f32::NAN, 1.0, 1.0],
                3 => [1.0, 1.0, f32::NEG_INFINITY],
                _ => [1.0; 3],
            }
        }
    }

    #[test]
    fn invalid_samples_are_black_and_counted() {
        let rendered = render(&Broken, &settings(4, 2), &());
        assert_eq!(rendered.invalid_samples, 2 * 37 * 21);
        assert!(rendered.film.image().pixels().iter().all(|p| *p == [0.5; 3]));
    }

    /// Cancels after a number of work units, and checks what is reported.
    struct Watch {
        cancel_after: u32,
        units: AtomicU32,
        last: Mutex<Option<Progress>>,
    }

    impl Watch {
        fn new(cancel_after: u32) -> Self {
            Self { cancel_after, units: AtomicU32::new(0), last: Mutex::new(None) }
        }
    }

    impl Observer for Watch {
        fn progress(&self, progress: &Progress) {
            assert!((0.0..=1.0).contains(&progress.fraction));
            self.units.fetch_add(1, Ordering::Relaxed);
            *self.last.lock().unwrap() = Some(*progress);
        }

        fn cancelled(&self) -> bool {
            self.units.load(Ordering::Relaxed) >= self.cancel_after
        }
    }

    #[test]
    fn cancelling_keeps_what_was_rendered() {
        // Six tiles a pass: the third pass (samples 2 and 3) is cut short.
        let rendered = render(&Noise, &settings(100, 1), &Watch::new(15));
        assert!(rendered.cancelled);
        assert_eq!(rendered.film.samples(), (2, 4));
        let full = render(&Noise, &settings(4, 1), &()).film;
        assert_eq!(rendered.film.pixels()[0], full.pixels()[0]);
        assert!(rendered.film.variance().is_some());

        let nothing = render(&Noise, &settings(100, 1), &Watch::new(0));
        assert_eq!((nothing.film.samples(), nothing.cancelled), ((0, 0), true));
    }

    /// Adds to its own pixel, to another, and to a layer.
    struct Splashing;

    impl AnyKernel for Splashing {
        fn worker(&self) -> Worker<'_> {
            Box::new(|pixel, number, splats| {
                let value = Noise.sample(&mut Vec::new(), pixel, number);
                splats.add(((pixel.0 + number) % 37, pixel.1), value);
                splats.add_to(Layer::Dx, pixel, value);
                value
            })
        }

        fn splats(&self) -> bool {
            true
        }

        /// As if each pass had to be prepared.
        fn largest_pass(&self) -> u32 {
            5
        }
    }

    /// A chain whose next state depends on the one before, and how many steps all have taken.
    #[derive(Default)]
    struct Wandering(AtomicU64);

    struct Wanderer<'a>(u64, &'a AtomicU64);

    impl MarkovChain for Wanderer<'_> {
        fn step(&mut self, splats: &mut Splats) {
            self.0 = (self.0 ^ (self.0 >> 29)).wrapping_mul(0xbf58_476d_1ce4_e5b9).wrapping_add(1);
            let place = (self.0 >> 40) as u32;
            splats.add((place % 37, place % 21), [1.0, 0.5, 0.0]);
            self.1.fetch_add(1, Ordering::Relaxed);
        }

        fn save(&self, to: &mut dyn Write) -> io::Result<()> {
            self.0.store(to)
        }

        fn restore(&mut self, from: &mut dyn Read) -> io::Result<()> {
            self.0 = u64::load(from)?;
            Ok(())
        }
    }

    impl AnyKernel for Wandering {
        fn worker(&self) -> Worker<'_> {
            Box::new(|_, _, _| [0.0; 3])
        }

        fn chain(&self, number: usize) -> Option<Chain<'_>> {
            Some(Box::new(Wanderer(number as u64, &self.0)))
        }

        fn splats(&self) -> bool {
            true
        }

        fn save(&self, to: &mut dyn Write) -> io::Result<()> {
            self.0.load(Ordering::Relaxed).store(to)
        }

        fn restore(&self, from: &mut dyn Read) -> io::Result<()> {
            self.0.store(u64::load(from)?, Ordering::Relaxed);
            Ok(())
        }
    }

    /// Keeps every state there is, and cancels after so many work units.
    struct Keeper {
        watch: Watch,
        states: Mutex<Vec<Vec<u8>>>,
    }

    impl Observer for Keeper {
        fn progress(&self, progress: &Progress) {
            self.watch.progress(progress);
        }

        fn cancelled(&self) -> bool {
            self.watch.cancelled()
        }

        fn wants_state(&self, _: bool) -> bool {
            true
        }

        fn keep_state(&self, write: StateWriter<'_>) {
            let mut state = Vec::new();
            write(&mut state).unwrap();
            self.states.lock().unwrap().push(state);
        }
    }

    /// The states of a render that is cancelled after so many work units.
    fn states(kernel: &dyn AnyKernel, settings: &RenderSettings, units: u32) -> Vec<Vec<u8>> {
        let keeper = Keeper { watch: Watch::new(units), states: Mutex::default() };
        render(kernel, settings, &keeper);
        keeper.states.into_inner().unwrap()
    }

    #[test]
    fn a_render_goes_on_from_every_state_to_the_same_image() {
        let limit = ErrorBudget { target: 0.05, samples: 600, seconds: 1e9, adaptive: true };
        let [uneven, all] = [true, false].map(|adaptive| ErrorBudget { adaptive, ..limit });
        type Make = fn() -> Box<dyn AnyKernel>;
        let cases: [(Make, Budget); 5] = [
            (|| Box::new(Noise), Budget::Samples(23)),
            (|| Box::new(Splashing), Budget::Samples(23)),
            (|| Box::<Wandering>::default(), Budget::Samples(23)),
            (|| Box::new(Uneven), Budget::Error(uneven)),
            (|| Box::<Wandering>::default(), Budget::Error(all)),
        ];
        for (case, (make, budget)) in cases.into_iter().enumerate() {
            let settings = |threads| RenderSettings { budget, ..settings(1, threads) };
            let counted = |kernel: &dyn AnyKernel| {
                let mut counted = Vec::new();
                kernel.save(&mut counted).unwrap();
                counted
            };
            let whole = make();
            let expected = render(&*whole, &settings(2), &());
            // Two threads, so that tiles differ in how far they are. Errors are judged late.
            let units = if matches!(budget, Budget::Error(_)) { 1000 } else { 100 };
            let states = states(&*make(), &settings(2), units);
            assert!(states.len() > 10, "{case}: {}", states.len());
            for (number, state) in states.iter().enumerate().step_by(states.len().div_ceil(30)) {
                let kernel = make();
                let resumed = resume(&*kernel, &settings(1), &(), &mut &state[..]).unwrap();
                assert!(resumed.film == expected.film, "case {case}, state {number}");
                assert!(resumed.layers == expected.layers, "case {case}, state {number}");
                assert_eq!(counted(&*kernel), counted(&*whole), "case {case}, state {number}");
            }
        }
    }

    #[test]
    fn states_of_other_renders_are_refused() {
        let states = states(&Noise, &settings(4, 1), 7);
        let state = states.last().unwrap();
        let error = |settings: &RenderSettings, mut state: &[u8]| {
            resume(&Noise, settings, &(), &mut state).map(|_| ()).unwrap_err().kind()
        };
        let wide = RenderSettings { size: (38, 21), ..settings(4, 1) };
        let layered = RenderSettings { layered: 3, ..settings(4, 1) };
        for other in [wide, layered] {
            assert_eq!(error(&other, state), io::ErrorKind::InvalidData);
        }
        for length in (0..state.len()).step_by(97) {
            let kind = error(&settings(4, 1), &state[..length]);
            assert_eq!(kind, io::ErrorKind::UnexpectedEof, "{length}");
        }
        let longer = [&state[..], &[0]].concat();
        assert_eq!(error(&settings(4, 1), &longer), io::ErrorKind::InvalidData);
    }

    #[test]
    fn time_goes_on_too() {
        let budget = Budget::Seconds(0.05);
        let settings = RenderSettings { budget, ..settings(1, 1) };
        let keeper = Keeper { watch: Watch::new(u32::MAX), states: Mutex::default() };
        let whole = render(&Noise, &settings, &keeper);
        let state = keeper.states.into_inner().unwrap().pop().unwrap();
        let resumed = resume(&Noise, &settings, &(), &mut &state[..]).unwrap();
        // The time was used up, and was kept.
        assert!(resumed.seconds > 0.04 && resumed.film == whole.film);
    }

    #[test]
    fn a_cancel_that_comes_too_late_changes_nothing() {
        let rendered = render(&Noise, &settings(2, 1), &Watch::new(12));
        assert_eq!((rendered.film.samples(), rendered.cancelled), ((2, 2), false));
    }

    #[test]
    fn progress_ends_at_one() {
        let watch = Watch::new(u32::MAX);
        render(&Noise, &settings(8, 1), &watch);
        let last = watch.last.lock().unwrap().unwrap();
        assert_eq!((last.fraction, last.samples), (1.0, 4));
        // The relative error of four uniform samples of mean 1, 2 and 0.
        let expected = (5.0f64 / 3.0 / 4.0 / 3.0).sqrt();
        approx::assert_relative_eq!(last.relative_error.unwrap(), expected, max_relative = 0.05);
    }
}
