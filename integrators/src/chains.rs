//! Markov chains of paths as the render engine runs them: several at once, each on its own.
//!
//! A chain is distributed like the brightness of what its states contribute to the image, so what a state
//! contributes counts over its brightness, times the mean brightness of all: that is estimated beforehand, from
//! independent candidates. Chains start at candidates that are drawn in proportion to their brightness, so that
//! they have no start-up bias (Veach 1997, section 11.3.1).

use std::sync::atomic::{AtomicU64, Ordering};
use std::time::Instant;

use aether_core::discrete::{Cdf, Discrete};
use aether_core::{Pcg32, UniformSource};
use glam::Vec3;

use crate::kind::{NotCovered, SceneKind};
use crate::render::{AnyKernel, Chain, Preparation, Worker};
use crate::scene::Scene;
use crate::strategies::Pixel;
use crate::work::{Work, in_parts};
use crate::world::World;

/// An integrator made of Markov chains.
pub trait ChainIntegrator: Send + Sync {
    /// The kinds of steps, for statistics.
    const STEPS: &'static [&'static str];

    /// How many candidates there are for the start of a chain.
    fn candidates(&self) -> usize;

    /// What finds the brightness of candidates, by their number. One for each thread.
    fn brightness<'a, K: SceneKind>(
        &'a self,
        world: &'a World<'a, K>,
        seed: u64,
    ) -> impl FnMut(usize) -> f32;

    /// A chain from a candidate; `mean` is the mean brightness, `seed` and `number` give it its random
    /// numbers. Each call takes one step and splats what it contributes.
    fn chain<'a, K: SceneKind>(
        &'a self,
        world: &'a World<'a, K>,
        start: Start,
        statistics: &'a Statistics,
    ) -> Chain<'a>;
}

/// How often steps of each kind were taken, how many of them had a proposal, and how many were accepted: over
/// all chains.
#[derive(Debug)]
pub struct Statistics {
    names: &'static [&'static str],
    counts: Vec<[AtomicU64; 3]>,
}

impl Statistics {
    /// Nothing so far, of steps of these kinds.
    pub fn new(names: &'static [&'static str]) -> Self {
        Statistics { names, counts: names.iter().map(|_| Default::default()).collect() }
    }

    /// Counts a step of the kind with this number.
    pub fn count(&self, kind: usize, proposed: bool, accepted: bool) {
        for (count, happened) in self.counts[kind].iter().zip([true, proposed, accepted]) {
            count.fetch_add(u64::from(happened), Ordering::Relaxed);
        }
    }

    /// The numbers of each kind: steps, proposals, and how many of these were accepted.
    pub fn counts(&self) -> impl Iterator<Item = (&'static str, [u64; 3])> + '_ {
        let value = |count: &AtomicU64| count.load(Ordering::Relaxed);
        let values = self.counts.iter().map(move |counts| counts.each_ref().map(value));
        self.names.iter().copied().zip(values)
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
        let mut kernel =
            ChainKernel { world, integrator, seed, start: None, statistics, preparation };
        let brightness = kernel.candidates();
        let mean = brightness.iter().map(|b| f64::from(*b)).sum::<f64>() / brightness.len() as f64;
        kernel.start = Cdf::new(&brightness).ok().map(|choice| (choice, mean as f32));
        let seconds = begin.elapsed().as_secs_f64();
        kernel.preparation = Preparation { seconds, work: Work::here() - before };
        Ok(kernel)
    }

    /// The brightness of all candidates.
    fn candidates(&self) -> Vec<f32> {
        let threads = std::thread::available_parallelism().map_or(1, |n| n.get());
        in_parts(self.integrator.candidates(), threads, |part| {
            let of = self.integrator.brightness(&self.world, self.seed);
            part.map(of).map(|found| if found.is_finite() { found } else { 0.0 }).collect()
        })
    }
}

impl<K: SceneKind, I: ChainIntegrator> AnyKernel for ChainKernel<'_, K, I> {
    fn worker(&self) -> Worker<'_> {
        Box::new(|_, _, _| [0.0; 3])
    }

    fn splats(&self) -> bool {
        true
    }

    fn preparation(&self) -> Preparation {
        self.preparation
    }

    fn chain(&self, number: usize) -> Option<Chain<'_>> {
        let Some((choice, mean)) = &self.start else { return Some(Box::new(|_| {})) };
        let mut uniforms = Pcg32::new(self.seed, number as u64, u64::MAX);
        let candidate = Discrete::<f32>::sample(choice, uniforms.next()).index;
        let start = Start { candidate, mean: *mean, seed: self.seed, number };
        Some(self.integrator.chain(&self.world, start, &self.statistics))
    }

    fn statistics(&self) -> Option<String> {
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

/// What a state of a chain contributes to pixels.
#[derive(Clone, Debug, Default)]
pub struct Contributions(Vec<(Pixel, Vec3)>);

impl Contributions {
    /// Without any.
    pub fn clear(&mut self) {
        self.0.clear();
    }

    /// Adds one.
    pub fn push(&mut self, pixel: Pixel, value: Vec3) {
        if value != Vec3::ZERO && value.is_finite() {
            self.0.push((pixel, value));
        }
    }

    /// The sum of their luminances.
    pub fn brightness(&self) -> f32 {
        let luminance = |v: &Vec3| v.dot(Vec3::new(0.2126, 0.7152, 0.0722));
        self.0.iter().map(|(_, value)| luminance(value)).sum()
    }

    /// Splats all of them, times a factor.
    pub fn splat(&self, factor: f32, splats: &mut crate::render::Splats) {
        if factor > 0.0 && factor.is_finite() {
            for (pixel, value) in &self.0 {
                splats.add(*pixel, (*value * factor).to_array());
            }
        }
    }
}
