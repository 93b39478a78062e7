//! Metropolis light transport on primary samples (Kelemen, Szirmay-Kalos, Antal and Csonka 2002): the states of
//! the chain are the uniforms that bidirectional path tracing draws, so that it needs no densities of
//! mutations.

use std::io::{self, Read, Write};

use aether_core::Pcg32;
use aether_core::uniform::{UniformSource, first_block_of_piece};

use crate::bidirectional::Bidirectional;
use crate::chains::{ChainIntegrator, Contributions, Start, Statistics};
use crate::integrator::Integrator;
use crate::kind::SceneKind;
use crate::path::{DIRECT, PathSettings};
use crate::render::shares::Shares;
use crate::render::{Chain, MarkovChain, Splats};
use crate::stored::Stored;
use crate::strategies::Pixel;
use crate::world::World;

/// Settings of Metropolis light transport on primary samples.
#[derive(Clone, Debug, PartialEq)]
pub struct PrimarySample {
    /// What turns uniforms into light.
    pub inner: Bidirectional,
    /// How often all uniforms are drawn anew.
    pub large_step: f32,
    /// How many independent samples the brightness of the image is estimated from; `None` for a number that
    /// grows with the image ([`usual_candidates`](crate::chains::usual_candidates)).
    pub candidates: Option<usize>,
    /// Whether direct light and lights that the camera sees are left to path tracing, where there is longer light and
    /// all techniques are used.
    pub direct: bool,
}

impl PrimarySample {
    /// With the usual settings.
    pub fn new(inner: Bidirectional) -> Self {
        PrimarySample { inner, large_step: 0.3, candidates: None, direct: true }
    }
}

/// A coordinate of a primary sample, and the step in which it was last changed.
#[derive(Clone, Copy, Debug)]
struct Coordinate {
    value: f32,
    changed: u64,
}

/// The uniforms of the state of a chain, numbered by blocks of sampling dimensions. They are brought up to
/// date when they are asked for.
#[derive(Debug)]
struct Primary {
    blocks: Vec<Vec<Coordinate>>,
    at: (usize, usize),
    /// What is added to the numbers of blocks, for the current piece of the sample.
    beyond: u32,
    random: Pcg32,
    step: u64,
    /// Whether the step under way draws all coordinates anew, and when that was last accepted.
    large: bool,
    last_large: u64,
    /// What the step under way has changed, to be put back if it is not accepted.
    before: Vec<(usize, usize, Coordinate)>,
}

/// The block that the pixel is drawn from; no path uses it.
const PIXEL: u32 = 7;

impl Primary {
    fn new(random: Pcg32) -> Self {
        Primary {
            blocks: Vec::new(),
            at: (0, 0),
            beyond: 0,
            random,
            step: 0,
            large: true,
            last_large: 0,
            before: Vec::new(),
        }
    }

    /// Begins a step, which is large with some probability.
    fn begin(&mut self, large: f32) {
        self.large = self.draws() < large;
        self.step += 1;
        self.before.clear();
    }

    fn draws(&mut self) -> f32 {
        self.random.next()
    }

    fn accept(&mut self) {
        if self.large {
            self.last_large = self.step;
        }
    }

    fn reject(&mut self) {
        self.step -= 1;
        for (block, index, before) in self.before.drain(..).rev() {
            self.blocks[block][index] = before;
        }
    }

    fn pixel(&mut self, (width, height): (u32, u32)) -> Pixel {
        self.start(PIXEL);
        let mut along = |size: u32| ((self.next() * size as f32) as u32).min(size - 1);
        (along(width), along(height))
    }

    /// A small step: the distance is between 1/1024 and 1/64, distributed like its inverse.
    fn near(&mut self, value: f32) -> f32 {
        let u: f32 = self.random.next();
        let (back, u) = if u < 0.5 { (true, 2.0 * u) } else { (false, 2.0 * u - 1.0) };
        let distance = (1.0 / 64.0) * (-(16.0f32).ln() * u).exp();
        let moved = if back { value - distance } else { value + distance };
        // The unit interval is closed to a circle.
        let wrapped = moved - moved.floor();
        wrapped.min(1.0 - 0.5 * f32::EPSILON)
    }
}

impl Stored for Coordinate {
    fn store(&self, to: &mut dyn Write) -> io::Result<()> {
        (self.value, self.changed).store(to)
    }

    fn load(from: &mut dyn Read) -> io::Result<Self> {
        let (value, changed) = Stored::load(from)?;
        Ok(Coordinate { value, changed })
    }
}

/// The state between two steps.
impl Stored for Primary {
    fn store(&self, to: &mut dyn Write) -> io::Result<()> {
        self.blocks.store(to)?;
        (self.random.words(), self.step, self.last_large).store(to)
    }

    fn load(from: &mut dyn Read) -> io::Result<Self> {
        let (blocks, words, step, last_large) = Stored::load(from)?;
        Ok(Primary { blocks, step, last_large, ..Primary::new(Pcg32::from_words(words)) })
    }
}

impl UniformSource<f32> for Primary {
    fn next(&mut self) -> f32 {
        let (block, index) = self.at;
        self.at.1 += 1;
        if self.blocks.len() <= block {
            self.blocks.resize(block + 1, Vec::new());
        }
        while self.blocks[block].len() <= index {
            // As if it had been drawn with the last large step.
            let value = self.random.next();
            self.blocks[block].push(Coordinate { value, changed: self.last_large });
        }
        let mut coordinate = self.blocks[block][index];
        self.before.push((block, index, coordinate));
        if self.large || coordinate.changed < self.last_large {
            coordinate.value = self.random.next();
            coordinate.changed = self.last_large;
        }
        if !self.large {
            for _ in coordinate.changed..self.step {
                coordinate.value = self.near(coordinate.value);
            }
        }
        coordinate.changed = self.step;
        self.blocks[block][index] = coordinate;
        coordinate.value
    }

    fn start(&mut self, block: u32) {
        self.at = (block.wrapping_add(self.beyond) as usize, 0);
    }

    fn piece(&mut self, number: u32) {
        self.beyond = first_block_of_piece(number);
    }
}

impl ChainIntegrator for PrimarySample {
    const STEPS: &'static [&'static str] = &["small", "large"];

    fn direct(&self) -> Option<PathSettings> {
        let path = &self.inner.path;
        let all = path.techniques.is_all();
        (self.direct && all && path.most_vertices() > DIRECT).then(|| path.direct())
    }

    fn candidates(&self) -> Option<usize> {
        self.candidates
    }

    fn brightness<'a, K: SceneKind>(
        &'a self,
        world: &'a World<'a, K>,
        seed: u64,
    ) -> impl FnMut(usize) -> f32 {
        let mut evaluate = self.evaluation(world);
        let mut found = Contributions::default();
        move |candidate| {
            evaluate(&mut Primary::new(Pcg32::new(seed, candidate as u64, 0)), &mut found);
            found.brightness()
        }
    }

    fn chain<'a, K: SceneKind>(
        &'a self,
        world: &'a World<'a, K>,
        start: Start,
        statistics: &'a Statistics,
    ) -> Chain<'a> {
        let mut evaluate = self.evaluation(world);
        let mut state = Primary::new(Pcg32::new(start.seed, start.candidate as u64, 0));
        let (mut current, proposal) = (Contributions::default(), Contributions::default());
        evaluate(&mut state, &mut current);
        state.random = Pcg32::new(start.seed, start.number as u64, 1);
        Box::new(PrimaryChain {
            settings: self,
            evaluate,
            state,
            current,
            proposal,
            start,
            statistics,
        })
    }
}

/// A chain of primary samples.
struct PrimaryChain<'a, E> {
    settings: &'a PrimarySample,
    /// What a primary sample contributes to the image.
    evaluate: E,
    state: Primary,
    current: Contributions,
    /// Memory for the next one.
    proposal: Contributions,
    start: Start,
    statistics: &'a Statistics,
}

impl<E: FnMut(&mut Primary, &mut Contributions) + Send> MarkovChain for PrimaryChain<'_, E> {
    fn step(&mut self, splats: &mut Splats) {
        let PrimaryChain { state, current, proposal, start, .. } = self;
        state.begin(self.settings.large_step);
        (self.evaluate)(state, proposal);
        let (old, new) = (current.brightness(), proposal.brightness());
        let probability = if new < old { new / old } else { 1.0 };
        current.splat((1.0 - probability) * start.mean / old, splats);
        proposal.splat(probability * start.mean / new, splats);
        let accepted = state.draws() < probability;
        self.statistics.count(start.number, usize::from(state.large), true, accepted);
        if accepted {
            state.accept();
            std::mem::swap(current, proposal);
        } else {
            state.reject();
        }
    }

    fn save(&self, to: &mut dyn Write) -> io::Result<()> {
        self.state.store(to)?;
        self.current.store(to)
    }

    fn restore(&mut self, from: &mut dyn Read) -> io::Result<()> {
        (self.state, self.current) = Stored::load(from)?;
        Ok(())
    }
}

impl PrimarySample {
    /// What a primary sample contributes to the image.
    fn evaluation<'a, K: SceneKind>(
        &'a self,
        world: &'a World<'a, K>,
    ) -> impl FnMut(&mut Primary, &mut Contributions) + Send + 'a {
        let mut scratch = self.inner.scratch(world);
        let fewest = if self.direct().is_some() { DIRECT + 1 } else { 2 };
        let inner = Bidirectional { fewest_vertices: fewest, ..self.inner };
        let film = world.scene.film;
        let (size, mut shares) = ((film.width, film.height), Shares::default());
        move |uniforms, found| {
            found.clear();
            let pixel = uniforms.pixel(size);
            let mut is_begun = false;
            inner.paths(world, &mut scratch, uniforms, pixel, |it| {
                let mut add = |receiver, response: f32| {
                    found.push(it.technique, receiver, it.value * response, it.alone * response);
                };
                if !it.is_own {
                    return film.receivers(it.film).for_each(|(pixel, by)| add(pixel, by));
                }
                if !std::mem::replace(&mut is_begun, true) {
                    world.share(&mut shares, pixel, it.film);
                }
                shares.each().for_each(|(pixel, share)| add(pixel, share * shares.total()));
            });
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A step of 3 blocks with `count` numbers each; small steps bring up to date late what the last large one
    /// has not asked for.
    fn step(state: &mut Primary, count: usize, accepted: bool) -> Vec<f32> {
        state.begin(0.3);
        let mut drawn = Vec::new();
        for block in 0..3 {
            state.start(block);
            drawn.extend((0..count).map(|_| state.next()));
        }
        if accepted {
            state.accept()
        } else {
            state.reject()
        }
        drawn
    }

    #[test]
    fn a_kept_state_goes_on_with_the_same_numbers() {
        let steps: Vec<_> = (0..120).map(|k| (1 + k * 7 % 11, k % 3 > 0)).collect();
        let (mut state, mut files, mut drawn) =
            (Primary::new(Pcg32::new(1, 2, 3)), Vec::new(), Vec::new());
        for (count, accepted) in &steps {
            let mut file = Vec::new();
            state.store(&mut file).unwrap();
            files.push(file);
            drawn.push(step(&mut state, *count, *accepted));
        }
        for (k, file) in files.iter().enumerate() {
            let mut kept = Primary::load(&mut &file[..]).unwrap();
            for (later, (count, accepted)) in steps.iter().enumerate().skip(k) {
                assert_eq!(step(&mut kept, *count, *accepted), drawn[later], "{k}, {later}");
            }
        }
    }
}
