//! Markov chains of paths as the render engine runs them: several at once, each on its own.
//!
//! A chain is distributed like the brightness of what its states contribute to the image, so what a state
//! contributes counts over its brightness, times the mean brightness of all: that is estimated beforehand, from
//! independent candidates. Chains start at candidates that are drawn in proportion to their brightness, so that
//! they have no start-up bias (Veach 1997, section 11.3.1).
//!
//! Direct light is most of an image, and path tracing finds it with far less noise than chains, whose samples depend on
//! each other: it is left to that, a sample beside every two steps, and chains carry the rest.

use std::io::{self, Read, Write};
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::Instant;

use aether_core::UniformSource;
use aether_core::discrete::{Cdf, Discrete};
use aether_core::uniform::Sobol;
use glam::Vec3;
use smallvec::SmallVec;

use crate::integrator::worker;
use crate::kind::{NotCovered, SceneKind};
use crate::path::PathSettings;
use crate::render::{AnyKernel, Chain, MarkovChain, Preparation, Splats, Technique, Worker};
use crate::scene::{SamplerKind, Scene};
use crate::stored::Stored;
use crate::strategies::Pixel;
use crate::work::{Work, in_parts};
use crate::world::World;

/// An integrator made of Markov chains.
pub trait ChainIntegrator: Send + Sync {
    /// The kinds of steps, for statistics.
    const STEPS: &'static [&'static str];

    /// What is path traced, because chains leave it out.
    fn direct(&self) -> Option<PathSettings>;

    /// How many candidates there are for the start of a chain; `None` for [`usual_candidates`].
    fn candidates(&self) -> Option<usize>;

    /// What finds the brightness of candidates, by their number. One for each thread.
    fn brightness<'a, K: SceneKind>(
        &'a self,
        world: &'a World<'a, K>,
        seed: u64,
    ) -> impl FnMut(usize) -> f32;

    /// A chain from a candidate; `mean` is the mean brightness, `seed` and `number` give it its random
    /// numbers.
    fn chain<'a, K: SceneKind>(
        &'a self,
        world: &'a World<'a, K>,
        start: Start,
        statistics: &'a Statistics,
    ) -> Chain<'a>;
}

/// How many candidates there are for an image of so many pixels: one for every four, but no fewer than 10,000 and no more
/// than 100,000.
///
/// In Mitsuba's Cornell box their brightness has 1.2 times its mean as its standard deviation, so that that of 256 x 256 pixels is
/// known to a percent; each takes as long as three steps of a chain.
pub fn usual_candidates(pixels: usize) -> usize {
    (pixels / 4).clamp(10_000, 100_000)
}

/// How often steps of each kind were taken, how many of them had a proposal, and how many were accepted: over
/// all chains.
#[derive(Debug)]
pub struct Statistics {
    names: &'static [&'static str],
    /// By the chain, as threads that count at the same place wait for each other, and by the kind.
    counts: [Counts; PLACES],
}

/// Numbers of each kind of step, on cache lines of their own.
#[derive(Debug, Default)]
#[repr(align(128))]
struct Counts([[AtomicU64; 3]; KINDS]);

/// How many kinds of steps an integrator may have.
const KINDS: usize = 4;

/// How many places there are to count at.
const PLACES: usize = 64;

impl Statistics {
    /// Nothing so far, of steps of these kinds.
    pub fn new(names: &'static [&'static str]) -> Self {
        assert!(names.len() <= KINDS, "there is room for {KINDS} kinds of steps");
        Statistics { names, counts: std::array::from_fn(|_| Counts::default()) }
    }

    /// Counts a step of a chain, of the kind with this number.
    pub fn count(&self, chain: usize, kind: usize, proposed: bool, accepted: bool) {
        let counts = &self.counts[chain % PLACES].0[kind];
        for (count, happened) in counts.iter().zip([true, proposed, accepted]) {
            count.fetch_add(u64::from(happened), Ordering::Relaxed);
        }
    }

    /// The numbers of each kind: steps, proposals, and how many of these were accepted.
    pub fn counts(&self) -> impl Iterator<Item = (&'static str, [u64; 3])> + '_ {
        let sum = |kind: usize, i: usize| {
            self.counts.iter().map(|counts| counts.0[kind][i].load(Ordering::Relaxed)).sum()
        };
        let values = move |(kind, name)| (name, std::array::from_fn(|i| sum(kind, i)));
        self.names.iter().copied().enumerate().map(values)
    }
}

impl Statistics {
    fn store(&self, to: &mut dyn Write) -> io::Result<()> {
        self.counts().try_for_each(|(_, counts)| counts.store(to))
    }

    fn restore(&self, from: &mut dyn Read) -> io::Result<()> {
        for counts in &self.counts {
            counts.0.iter().flatten().for_each(|count| count.store(0, Ordering::Relaxed));
        }
        for count in self.counts[0].0[..self.names.len()].iter().flatten() {
            count.store(Stored::load(from)?, Ordering::Relaxed);
        }
        Ok(())
    }
}

/// The chain of a scene without light.
struct Still;

impl MarkovChain for Still {
    fn step(&mut self, _: &mut Splats) {}

    fn save(&self, _: &mut dyn Write) -> io::Result<()> {
        Ok(())
    }

    fn restore(&mut self, _: &mut dyn Read) -> io::Result<()> {
        Ok(())
    }
}

/// How a chain begins.
#[derive(Clone, Copy, Debug)]
pub struct Start {
    /// The number of the candidate.
    pub candidate: usize,
    /// The mean brightness of all candidates.
    pub mean: f32,
    /// The seed of the render.
    pub seed: u64,
    /// The number of the chain.
    pub number: usize,
}

/// Chains of a scene, as the render engine calls them.
pub struct ChainKernel<'s, K: SceneKind, I> {
    world: World<'s, K>,
    integrator: I,
    /// What is path traced.
    direct: Option<PathSettings>,
    seed: u64,
    /// The candidates by their brightness, and its mean; none if all are black.
    start: Option<(Cdf<f32>, f32)>,
    statistics: Statistics,
    preparation: Preparation,
}

impl<'s, K: SceneKind, I: ChainIntegrator> ChainKernel<'s, K, I> {
    /// An integrator for a scene; the same seed gives the same image. Evaluates the candidates.
    ///
    /// # Errors
    /// If the scene needs what the kind leaves out.
    pub fn new(scene: &'s Scene, integrator: I, seed: u64) -> Result<Self, NotCovered> {
        let world = World::new(scene)?;
        let (begin, before) = (Instant::now(), Work::here());
        let preparation = Preparation::default();
        let statistics = Statistics::new(I::STEPS);
        let direct = integrator.direct();
        let mut kernel =
            ChainKernel { world, integrator, direct, seed, start: None, statistics, preparation };
        let brightness = kernel.brightness();
        let mean = brightness.iter().map(|b| f64::from(*b)).sum::<f64>() / brightness.len() as f64;
        kernel.start = Cdf::new(&brightness).ok().map(|choice| (choice, mean as f32));
        let seconds = begin.elapsed().as_secs_f64();
        kernel.preparation = Preparation { seconds, work: Work::here() - before };
        Ok(kernel)
    }

    /// How many candidates there are.
    fn candidates(&self) -> usize {
        let usual = || usual_candidates(self.world.pixels());
        self.integrator.candidates().unwrap_or_else(usual)
    }

    /// The brightness of all candidates.
    fn brightness(&self) -> Vec<f32> {
        let threads = std::thread::available_parallelism().map_or(1, |n| n.get());
        in_parts(self.candidates(), threads, |part| {
            let of = self.integrator.brightness(&self.world, self.seed);
            part.map(of).map(|found| if found.is_finite() { found } else { 0.0 }).collect()
        })
    }
}

/// To how many steps of chains there is a sample of direct light.
///
/// Of Mitsuba's Cornell box with 64 mutations a pixel (`aether render --integrator mlt --spp 64`) the relMSE is 4.2e-3; that of its
/// direct light (`--integrator path --max-depth 2 --sampler ldsampler`) is 4.2e-5 with 64 samples, which take a fourth of the
/// time, and 8.1e-5 with 32.
const STEPS_BESIDE: u32 = 2;

/// A worker whose samples each count for [`STEPS_BESIDE`] ones. The steps of a pixel mostly follow each other, so that a sample is
/// taken once; only what it gives to other pixels it has to give again.
fn beside(mut worker: Worker<'_>) -> Worker<'_> {
    let mut last = None;
    Box::new(move |pixel, number, splats| {
        let (sample, waiting) = ((pixel, number / STEPS_BESIDE), splats.len());
        if let Some((known, value)) = last
            && known == sample
        {
            return value;
        }
        let value = worker(sample.0, sample.1, splats);
        last = (splats.layered == 0 && splats.len() == waiting).then_some((sample, value));
        value
    })
}

impl<K: SceneKind, I: ChainIntegrator> AnyKernel for ChainKernel<'_, K, I> {
    fn worker(&self) -> Worker<'_> {
        match &self.direct {
            // With another seed than chains, which number their streams otherwise.
            Some(direct) => {
                beside(worker(&self.world, direct, !self.seed, SamplerKind::LowDiscrepancy))
            }
            None => Box::new(|_, _, _| [0.0; 3]),
        }
    }

    fn splats(&self) -> bool {
        true
    }

    fn brightness_exponent(&self) -> i32 {
        self.world.scene.brightness_exponent()
    }

    fn preparation(&self) -> Preparation {
        self.preparation
    }

    fn chain(&self, number: usize) -> Option<Chain<'_>> {
        let Some((choice, mean)) = &self.start else { return Some(Box::new(Still)) };
        // The chains together begin more evenly than each for itself would.
        let mut uniforms = Sobol::new(self.seed, u64::MAX - 1, number as u32);
        let candidate = Discrete::<f32>::sample(choice, uniforms.next()).index;
        let start = Start { candidate, mean: *mean, seed: self.seed, number };
        Some(self.integrator.chain(&self.world, start, &self.statistics))
    }

    fn save(&self, to: &mut dyn Write) -> io::Result<()> {
        self.statistics.store(to)
    }

    fn restore(&self, from: &mut dyn Read) -> io::Result<()> {
        self.statistics.restore(from)
    }

    fn statistics(&self) -> Option<String> {
        if self.start.is_none() {
            let candidates = self.candidates();
            let beyond = if self.direct.is_some() { " that is not direct" } else { "" };
            return Some(format!(
                "no chain has begun: none of {candidates} candidates has light{beyond}"
            ));
        }
        let line = |(name, [steps, proposed, accepted]): (&str, [u64; 3])| {
            let percent = |a: u64, b: u64| 100.0 * a as f64 / b.max(1) as f64;
            let (made, taken) = (percent(proposed, steps), percent(accepted, proposed));
            format!(
                "{name}: {steps} steps, {made:.1} % with a proposal, {taken:.1} % of these accepted"
            )
        };
        Some(self.statistics.counts().map(line).collect::<Vec<_>>().join("\n"))
    }
}

/// The length of a colour whose squares may be out of range: what a path carries is not divided by its density.
fn length(colour: Vec3) -> f32 {
    let largest = colour.abs().max_element();
    if largest > 0.0 { largest * (colour / largest).length() } else { 0.0 }
}

/// What a state of a chain contributes to pixels, and what its techniques would contribute alone: mostly to one.
#[derive(Clone, Debug, Default)]
pub struct Contributions(SmallVec<[(Technique, Pixel, [Vec3; 2]); 1]>);

impl Contributions {
    /// Without any.
    pub fn clear(&mut self) {
        self.0.clear();
    }

    /// Adds what a technique contributes by its weight, and what it would alone.
    pub fn push(&mut self, technique: Technique, pixel: Pixel, value: Vec3, alone: Vec3) {
        if value != Vec3::ZERO && value.is_finite() {
            self.0.push((technique, pixel, [value, alone]));
        }
    }

    /// The sum of the lengths of their colours, so that the signs that a filter with negative lobes gives them do not matter.
    ///
    /// Of independent samples whose density is proportional to this, the errors of the three channels have the least sum of
    /// squares; with luminance, red and blue have more: of Mitsuba's Cornell box with 16 mutations a pixel (`aether render
    /// --integrator mlt --spp 16`) the relMSE is 2.1e-2 then, and 1.9e-2 so.
    pub fn brightness(&self) -> f32 {
        self.0.iter().map(|(_, _, [value, _])| length(*value)).sum()
    }

    /// Splats all of them, times a factor.
    pub fn splat(&self, factor: f32, splats: &mut Splats) {
        if factor > 0.0 && factor.is_finite() {
            for (technique, pixel, values) in &self.0 {
                let values = values.map(|value| (value * factor).to_array());
                splats.add(*pixel, values[0]);
                splats.add_by(*technique, *pixel, values);
            }
        }
    }
}

impl Stored for Contributions {
    fn store(&self, to: &mut dyn Write) -> io::Result<()> {
        self.0.to_vec().store(to)
    }

    fn load(from: &mut dyn Read) -> io::Result<Self> {
        Ok(Contributions(Vec::load(from)?.into()))
    }
}
