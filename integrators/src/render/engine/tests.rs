//! The engine with kernels whose answers are known.

use super::*;
use crate::film_filter::{FilmProfile, PixelPoints};
use crate::render::progress::StateWriter;
use crate::render::windows::WINDOW;
use crate::render::{Cancelled, Chain, Layer, MarkovChain, PixelKernel, Splats, Worker};
use crate::scene::SamplerKind;
use crate::stored::Stored;
use crate::uniforms::Uniforms;
use crate::world::profile_integral;
use aether_core::sequence::first_block;
use aether_core::{Sampler, UniformSource};
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

    fn look(&self, film: &Film, progress: &Progress, _: &dyn Fn() -> Layers) {
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

/// Samples of one that also add one to another pixel. While the fifth sample is computed, or what a pass needs, the render is
/// cancelled.
struct Slow {
    /// How many samples have begun.
    begun: AtomicU32,
    cancelled: AtomicBool,
    is_slow_to_begin: bool,
}

impl Slow {
    fn new(is_slow_to_begin: bool) -> Self {
        let (begun, cancelled) = (AtomicU32::new(0), AtomicBool::new(false));
        Slow { begun, cancelled, is_slow_to_begin }
    }
}

impl AnyKernel for Slow {
    fn worker(&self) -> Worker<'_> {
        self.worker_until(&|| false)
    }

    fn worker_until<'a>(&'a self, cancelled: Cancelled<'a>) -> Worker<'a> {
        Box::new(move |_, _, splats| {
            splats.add((0, 0), [1.0; 3]);
            if self.begun.fetch_add(1, Ordering::Relaxed) == 4 {
                self.cancelled.store(true, Ordering::Relaxed);
            }
            if cancelled() {
                splats.give_up();
            }
            [1.0; 3]
        })
    }

    fn splats(&self) -> bool {
        true
    }

    fn begin_pass(&self, _: u32, _: usize, cancelled: Cancelled<'_>) -> bool {
        self.cancelled.store(self.is_slow_to_begin, Ordering::Relaxed);
        !cancelled()
    }
}

impl Observer for Slow {
    fn progress(&self, _: &Progress) {}

    fn cancelled(&self) -> bool {
        self.cancelled.load(Ordering::Relaxed)
    }
}

#[test]
fn a_sample_that_is_given_up_does_not_count() {
    let slow = Slow::new(false);
    let rendered = render(&slow, &settings(1, 1), &slow);
    assert!(rendered.cancelled);
    let counts: Vec<u32> = rendered.film.pixels().iter().map(|pixel| pixel.count()).collect();
    assert_eq!(counts.iter().sum::<u32>(), 4);
    // Light paths do not depend on pixels: each of four adds as much as if there were no others.
    let first = rendered.film.image().pixels()[0][0];
    assert_eq!(first, 1.0 + 37.0 * 21.0);
}

#[test]
fn nothing_is_sampled_before_all_that_it_needs_is_made() {
    let slow = Slow::new(true);
    let rendered = render(&slow, &settings(1, 2), &slow);
    assert!(rendered.cancelled);
    assert_eq!((rendered.film.samples(), slow.begun.into_inner()), ((0, 0), 0));
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

/// Shares samples of a picture with noise by a filter, brighter in the third channel.
struct Blurred {
    filter: Filter,
    picture: fn(f64, f64) -> f64,
    seed: u32,
}

impl Blurred {
    /// Of a picture without edges.
    fn waves(filter: Filter) -> Self {
        let picture = |x: f64, y: f64| (0.7 * x).sin() + 2.0 * (0.9 * y).cos() + 4.0;
        Blurred { filter, picture, seed: 3 }
    }

    /// What a pixel is to be.
    fn expected(&self, pixel: (u32, u32)) -> f64 {
        const STEPS: u32 = 96;
        let radius = f64::from(self.filter.radius());
        let at = |k: u32| radius * (2.0 * (f64::from(k) + 0.5) / f64::from(STEPS) - 1.0);
        let (mut sum, mut all) = (0.0, 0.0);
        for (i, j) in (0..STEPS).flat_map(|i| (0..STEPS).map(move |j| (i, j))) {
            let [dx, dy] = [i, j].map(at);
            let weight = f64::from(self.filter.profile(dx as f32) * self.filter.profile(dy as f32));
            let [x, y] = [pixel.0, pixel.1].map(|k| f64::from(k) + 0.5);
            sum += weight * (self.picture)(x + dx, y + dy);
            all += weight;
        }
        sum / all
    }
}

impl AnyKernel for Blurred {
    fn worker(&self) -> Worker<'_> {
        let profile = FilmProfile::new(self.filter);
        Box::new(move |pixel, number, splats| {
            let film = &crate::scene::Film { width: 37, height: 21, filter: self.filter };
            let mut uniforms =
                Uniforms::of_pixel(SamplerKind::Independent, self.seed.into(), pixel, film, number);
            let mut draw = |block| {
                uniforms.start(block);
                [uniforms.next(), uniforms.next()]
            };
            let (u, [noise, _]) = (draw(first_block(1)), draw(first_block(2)));
            let point = PixelPoints::new(profile.as_ref(), pixel).sample(u);
            let of = |x: f32, pixel: u32| self.filter.profile(x - (pixel as f32 + 0.5));
            let own = of(point.x, pixel.0) * of(point.y, pixel.1);
            if own == 0.0 {
                return [0.0; 3];
            }
            let counts = splats.lie().map_or(own, |shares| {
                shares.move_to(film, pixel, *point);
                own.abs()
            });
            let picture = (self.picture)(point.x.into(), point.y.into()) as f32;
            let integral = profile_integral(self.filter).powi(2);
            let value = (picture + noise - 0.5) * counts / (point.pdf().value() * integral);
            [value, 0.0, 10.0 * value]
        })
    }

    fn filter(&self) -> Option<Filter> {
        Some(self.filter)
    }
}

#[test]
fn shared_samples_have_the_mean_and_about_the_variance_that_they_should() {
    let filters = [
        Filter::Tent { radius: 1.0 },
        Filter::Tent { radius: 2.3 },
        Filter::Gaussian { stddev: 0.5 },
        // Not shared.
        Filter::Cubic { b: 1.0 / 3.0, c: 1.0 / 3.0 },
    ];
    for filter in filters {
        let kernel = Blurred::waves(filter);
        let film = render(&kernel, &settings(1000, 2), &()).film;
        let variance = film.variance().unwrap();
        let (mut squares, mut count) = (0.0, 0.0);
        for y in 0..21u32 {
            for x in 0..37u32 {
                let expected = kernel.expected((x, y));
                let found = film.pixels()[(y * 37 + x) as usize].mean()[0];
                let spread = f64::from(variance.pixel(x as usize, y as usize)[0]);
                let z = (found - expected) / spread.sqrt();
                squares += z * z;
                count += 1.0;
                // Of 3108 numbers.
                assert!(z.abs() < 6.0, "{filter:?}, pixel {x}, {y}: {found} {expected} {z}");
            }
        }
        // The picture differs over a filter more than the lattice of samples shows.
        let mean_square: f64 = squares / count;
        println!("{filter:?}: {mean_square}");
        assert!((0.05..1.2).contains(&mean_square), "{filter:?}: {mean_square}");
    }
}

#[test]
fn the_variance_beside_a_small_lamp_is_not_that_of_the_lamp() {
    let picture = |x: f64, y: f64| if (x - 18.2).hypot(y - 10.3) < 0.4 { 1000.0 } else { 1.0 };
    let filter = Filter::Tent { radius: 1.0 };
    const SEEDS: u32 = 60;
    let pixels = 37 * 21;
    let (mut sums, mut said) = (vec![[0.0; 2]; pixels], vec![0.0; pixels]);
    for seed in 0..SEEDS {
        let film = render(&Blurred { filter, picture, seed }, &settings(64, 2), &()).film;
        for (index, pixel) in film.pixels().iter().enumerate() {
            let mean = pixel.mean()[0];
            sums[index] = [sums[index][0] + mean, sums[index][1] + mean * mean];
            said[index] += pixel.variance_of_mean().unwrap()[0] / f64::from(SEEDS);
        }
    }
    // The expected relMSE, by the scatter of renders and as they say.
    let (mut found, mut expected) = (0.0, 0.0);
    for ([sum, squares], said) in sums.into_iter().zip(said) {
        let n = f64::from(SEEDS);
        let (mean, variance) = (sum / n, (squares - sum * sum / n) / (n - 1.0));
        found += variance / (mean * mean + 0.01) / pixels as f64;
        expected += said / (mean * mean + 0.01) / pixels as f64;
    }
    println!("{found} {expected}");
    assert!((0.5..2.0).contains(&(expected / found)), "{found}, said to be {expected}");
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
    let cases: [(Make, Budget); 6] = [
        (|| Box::new(Noise), Budget::Samples(23)),
        (|| Box::new(Splashing), Budget::Samples(23)),
        (|| Box::new(Blurred::waves(Filter::Gaussian { stddev: 0.5 })), Budget::Samples(23)),
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
fn an_end_is_none_for_a_smaller_error() {
    let limit = |target| ErrorBudget { target, samples: 5000, seconds: 1e9, adaptive: false };
    let of = |target| RenderSettings {
        budget: Budget::Error(limit(target)),
        ..RenderSettings::new((2 * WINDOW, WINDOW), Budget::Samples(1))
    };
    let keeper = Keeper { watch: Watch::new(u32::MAX), states: Mutex::default() };
    let coarse = render(&Uneven, &of(0.1), &keeper).film;
    let state = keeper.states.into_inner().unwrap().pop().unwrap();
    let resumed = |target| resume(&Uneven, &of(target), &(), &mut &state[..]).unwrap().film;
    assert!(resumed(0.1) == coarse);
    let fine = render(&Uneven, &of(0.045), &()).film;
    assert!(resumed(0.045) == fine && fine.samples() > coarse.samples());
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
