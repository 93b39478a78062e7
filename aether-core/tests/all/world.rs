//! A one-dimensional world of paths with an exact answer.
//!
//! Points of [0, 1] scatter by the kernel (1 + x y) / 2 and are mirrors too: what arrives from w goes
//! on to 1 - w, wherever the mirror is, with coefficient `mirror`. Every point y emits 2 y. A pinhole
//! at 0.3 looks at it: what it sees after any number of bounces is a polynomial.

#![allow(dead_code)] // Each test uses a part of it.

use std::cell::Cell;

use aether_core::sequence::{Arena, PathView};
use aether_core::strategy::{Conditional, Dirac, Drawn, Reads, Strategy, Vertex};
use aether_core::{PathIntegrand, UniformSource, strategies};

#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Spot(pub f64);

impl Vertex for Spot {
    type Real = f64;
    type Point = f64;
    fn point(&self) -> f64 {
        self.0
    }
}

/// What happens in the world, and how often densities are evaluated and shadow rays cast.
#[derive(Debug, Default)]
pub struct World {
    pub mirror: f64,
    pub evaluations: Cell<usize>,
    pub shadow_rays: Cell<usize>,
}

pub const PINHOLE: f64 = 0.3;
const DEGREE: usize = 12;
pub const SURVIVAL: f64 = 0.8;

impl World {
    pub fn with_mirror(mirror: f64) -> Self {
        World { mirror, ..World::default() }
    }

    /// What the pinhole sees along paths of exactly `edges` edges.
    pub fn exact(&self, edges: usize) -> f64 {
        // What leaves x towards w: the coefficients of w^i x^j.
        let mut seen = [[0.0; DEGREE]; DEGREE];
        seen[0][1] = 2.0;
        for _ in 1..edges {
            let mut next = [[0.0; DEGREE]; DEGREE];
            for (i, row) in seen.iter().enumerate() {
                for (j, c) in row.iter().enumerate().filter(|(_, c)| **c != 0.0) {
                    let n = j as f64;
                    next[0][i] += c / (2.0 * (n + 1.0));
                    next[0][i + 1] += c / (2.0 * (n + 2.0));
                    // (1 - w)^j
                    let mut binomial = 1.0;
                    for (k, row) in next.iter_mut().enumerate().take(j + 1) {
                        row[i] += self.mirror * c * binomial;
                        binomial *= -((j - k) as f64) / (k + 1) as f64;
                    }
                }
            }
            seen = next;
        }
        let term = |i: usize, j: usize, c: f64| {
            let n = j as f64;
            c * PINHOLE.powi(i as i32) * (1.0 / (n + 1.0) + PINHOLE / (n + 2.0)) / 2.0
        };
        let rows = seen.iter().enumerate();
        rows.flat_map(|(i, row)| row.iter().enumerate().map(move |(j, c)| term(i, j, *c))).sum()
    }

    /// The chance that a step takes the mirror, if it has come from somewhere.
    fn mirror_choice(&self, path: PathView<'_, Spot>) -> f64 {
        if self.mirror > 0.0 && path.back(1).is_some() { 0.3 } else { 0.0 }
    }

    fn evaluated(&self) {
        self.evaluations.set(self.evaluations.get() + 1);
    }
}

/// The pinhole: an atom.
#[derive(Clone, Copy)]
pub struct Camera;
impl Strategy<Spot> for Camera {
    fn sample<U: UniformSource<f64> + ?Sized>(
        &self,
        _: PathView<'_, Spot>,
        _: &mut U,
    ) -> Option<Drawn<Spot>> {
        Some(Drawn::atom(Spot(PINHOLE), Dirac::Position))
    }
    fn pdf(&self, _: PathView<'_, Spot>, _: &Spot) -> Conditional<f64> {
        Conditional::atom(Dirac::Position, 1.0)
    }
    fn reads(&self) -> Reads {
        Reads::NOTHING
    }
    fn same(&self, _: &Self) -> bool {
        true
    }
}

/// A step after a coin for survival: the mirror, or one of two lobes, y = u or y = √u, with
/// probabilities 1 - x and x.
#[derive(Clone, Copy)]
pub struct Step<'w>(pub &'w World);
impl Strategy<Spot> for Step<'_> {
    fn sample<U: UniformSource<f64> + ?Sized>(
        &self,
        path: PathView<'_, Spot>,
        uniforms: &mut U,
    ) -> Option<Drawn<Spot>> {
        let x = path.last()?.0;
        if uniforms.next() >= SURVIVAL {
            return None;
        }
        if uniforms.next() < self.0.mirror_choice(path) {
            let from = path.back(1)?.0;
            return Some(Drawn::atom(Spot(1.0 - from), Dirac::Direction).visible());
        }
        let (choice, u) = (uniforms.next(), uniforms.next());
        Some(Drawn::new(Spot(if choice < x { u.sqrt() } else { u })).visible())
    }
    fn pdf(&self, path: PathView<'_, Spot>, target: &Spot) -> Conditional<f64> {
        self.0.evaluated();
        let (Some(Spot(x)), Spot(y)) = (path.last(), *target) else { return Conditional::ZERO };
        let mirror = self.0.mirror_choice(path);
        match path.dirac() {
            Some(Dirac::Direction) => Conditional::atom(Dirac::Direction, SURVIVAL * mirror),
            _ => Conditional::density(SURVIVAL * (1.0 - mirror) * (1.0 - x + x * 2.0 * y)),
        }
    }
    fn reads(&self) -> Reads {
        Reads::TWO
    }
    fn same(&self, other: &Self) -> bool {
        std::ptr::eq(self.0, other.0)
    }
}

/// A point of the light, towards which more of it is sampled: density 2 y.
#[derive(Clone, Copy)]
pub struct Light<'w>(pub &'w World);
impl Strategy<Spot> for Light<'_> {
    fn sample<U: UniformSource<f64> + ?Sized>(
        &self,
        _: PathView<'_, Spot>,
        uniforms: &mut U,
    ) -> Option<Drawn<Spot>> {
        let y = (1.0 - uniforms.next()).sqrt();
        Some(Drawn::new(Spot(y)).with_value(2.0 * y))
    }
    fn pdf(&self, _: PathView<'_, Spot>, target: &Spot) -> Conditional<f64> {
        self.0.evaluated();
        Conditional::density(2.0 * target.0)
    }
    fn reads(&self) -> Reads {
        Reads::NOTHING
    }
    fn same(&self, other: &Self) -> bool {
        std::ptr::eq(self.0, other.0)
    }
}

strategies! {
    #[derive(Clone, Copy)]
    pub enum Ways<'w> for Spot { Camera(Camera), Step(Step<'w>), Light(Light<'w>) }
}

pub type Walks<'w> = Arena<Spot, Ways<'w>>;

/// What the pinhole sees.
pub struct Seen<'w>(pub &'w World);
impl PathIntegrand for Seen<'_> {
    type Vertex = Spot;
    type Value = f64;
    fn extend(&self, path: PathView<'_, Spot>) -> f64 {
        let i = path.len() - 1;
        let (Some(Spot(x)), Some(Spot(y))) = (path.back(1), path.last()) else {
            // The pinhole sees nothing of light that is not exactly there.
            return if path.carries(0, Dirac::Position) { 1.0 } else { 0.0 };
        };
        if !path.visible(i) {
            self.0.shadow_rays.set(self.0.shadow_rays.get() + 1);
        }
        if path.carries(i - 1, Dirac::Direction) { self.0.mirror } else { (1.0 + x * y) / 2.0 }
    }
    fn end(&self, path: PathView<'_, Spot>) -> f64 {
        path.last().map_or(0.0, |spot| 2.0 * spot.0)
    }
}

/// Mean and standard error.
#[derive(Default)]
pub struct Mean {
    n: f64,
    sum: f64,
    squares: f64,
}

impl Mean {
    pub fn add(&mut self, x: f64) {
        (self.n, self.sum, self.squares) = (self.n + 1.0, self.sum + x, self.squares + x * x);
    }
    /// Distance from the exact value in standard errors.
    pub fn z(&self, exact: f64) -> f64 {
        let mean = self.sum / self.n;
        let variance = (self.squares / self.n - mean * mean) / (self.n - 1.0);
        (mean - exact) / variance.sqrt()
    }
}
