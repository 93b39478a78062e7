//! A sampler as the checks see it: coordinates and densities in `f64`.

use super::derivative::{Derivative, Numbers, distance, norm};
use super::subject::{AnySpot, Subject};
use crate::uniform::Pcg32;

/// A sampler with what the checks need to know about it. Of one with atoms, the continuous part: to the checks, the uniforms
/// that lead to an atom have no sample.
pub(super) struct Probe<'a> {
    pub(super) sampler: &'a dyn Subject,
    /// Rounding unit of the sampler's numbers.
    pub(super) epsilon: f64,
    /// Some sample, to make other points like it.
    pub(super) model: AnySpot<'a>,
    /// Coordinates of some samples.
    pub(super) pilot: Vec<Vec<f64>>,
    /// Median distance of the samples from the origin: what rounding of coordinates is relative to.
    scale: f64,
}

impl<'a> Probe<'a> {
    /// Draws some samples; `None` if there are none.
    pub(super) fn new(sampler: &'a dyn Subject, seed: u64) -> Option<Self> {
        let mut source = Pcg32::new(seed, 1, 0);
        let (mut model, mut pilot) = (None, Vec::new());
        for _ in 0..16_384 {
            if let Some((x, at)) = finite(sampler, &sampler.draw(&mut source)) {
                model.get_or_insert(x);
                pilot.push(at);
            }
        }
        let mut lengths: Vec<f64> = pilot.iter().map(|x| norm(x)).collect();
        lengths.sort_by(f64::total_cmp);
        let model = model?;
        let scale = lengths[lengths.len() / 2];
        Some(Probe { sampler, epsilon: sampler.epsilon(), model, pilot, scale })
    }

    /// The sample of uniforms, which are rounded and kept below one, and its coordinates, if there is one and it
    /// is finite.
    pub(super) fn forward(&self, u: &[f64]) -> Option<(AnySpot<'a>, Vec<f64>)> {
        finite(self.sampler, u)
    }

    /// Whether the sampler takes as many uniforms as its space has dimensions.
    pub(super) fn is_square(&self) -> bool {
        self.sampler.uniforms() == self.sampler.dimension()
    }

    /// The derivative of the forward map by differences.
    pub(super) fn derivative(&self, u: &[f64]) -> Option<Derivative> {
        let rounded = |v: &[f64]| self.sampler.rounded(v);
        let numbers = Numbers { epsilon: self.epsilon, rounded: &rounded };
        Derivative::of(&|v| self.forward(v).map(|(_, x)| x), u, &numbers)
    }

    /// The magnitude that the rounding of a point is relative to.
    pub(super) fn magnitude(&self, x: &[f64]) -> f64 {
        norm(x).max(self.scale)
    }

    /// Whether `v` maps forward to `x` but for rounding: of the coordinates, and of `v` by a few
    /// units in the last place of one.
    pub(super) fn maps_to(&self, v: &[f64], x: &[f64], slack: f64) -> bool {
        if !v.iter().all(|v| (0.0..1.0).contains(v)) {
            return false;
        }
        self.lands_on(v, x, slack) || self.is_beyond(v, x)
    }

    /// Whether the image of `v` is `x` but for rounding.
    fn lands_on(&self, v: &[f64], x: &[f64], slack: f64) -> bool {
        let Some((_, y)) = self.forward(v) else { return false };
        let mut beside = self.neighbours(v, |_| 4.0 * self.epsilon);
        // Along the sides of a corner nothing may change that does across it.
        beside.push(self.inwards(v, |_| 4.0 * self.epsilon));
        let reach = beside
            .iter()
            .filter_map(|w| self.forward(w))
            .map(|(_, z)| distance(&y, &z))
            .fold(0.0, f64::max);
        distance(&y, x) <= slack * (64.0 * self.epsilon * self.magnitude(x) + 2.0 * reach)
    }

    /// Whether `v` lies next to where a map to the line goes to infinity, at an end of the uniform or of a piece, and `x` further
    /// out than what is mapped from there: no number is as near to that place as the uniforms of `x` are.
    pub(super) fn is_beyond(&self, v: &[f64], x: &[f64]) -> bool {
        let ([v], [x]) = (v, x) else { return false };
        let image = |steps: f64| {
            let w = v + 4.0 * steps * self.epsilon;
            let found = if (0.0..1.0).contains(&w) { self.forward(&[w]) } else { None };
            found.map(|(_, at)| at[0])
        };
        // Where the map turns back, `x` may be as far out as it goes.
        let rounding = 64.0 * self.epsilon * self.magnitude(&[*x]);
        if image(0.0).is_some_and(|y| (y - x).abs() <= rounding) {
            return false;
        }
        [-1.0, 1.0].into_iter().any(|inwards: f64| {
            let (Some(next), Some(further)) = (image(inwards), image(2.0 * inwards)) else {
                return false;
            };
            let goes_on = |y: f64| (y - next) * (next - further) > 0.0;
            let ends = image(0.0).is_none() || !image(-inwards).is_some_and(goes_on);
            ends && goes_on(*x)
        })
    }

    /// Uniforms beside `u` with each moved by `step(axis)` towards the middle of the cube: at a corner, rounding moves all.
    pub(super) fn inwards(&self, u: &[f64], step: impl Fn(usize) -> f64) -> Vec<f64> {
        let moved = |(axis, u): (usize, &f64)| u + (0.5 - u).signum() * step(axis).min(0.5);
        u.iter().enumerate().map(moved).collect()
    }

    /// Uniforms that lead to the same point as `u` although one of them differs by much: in a corner where that one
    /// has no meaning, the density of the point may be that of any of them.
    pub(super) fn undetermined(&self, u: &[f64], at: &[f64]) -> Vec<Vec<f64>> {
        let near = 4.0 * self.epsilon * norm(at);
        let others = (0..u.len()).flat_map(|axis| [0.25, 0.5, 0.75].map(|value| (axis, value)));
        let others = others.map(|(axis, value)| {
            let mut v = u.to_vec();
            v[axis] = value;
            v
        });
        let same = |v: &Vec<f64>| self.forward(v).is_some_and(|(_, x)| distance(&x, at) <= near);
        others.filter(same).collect()
    }

    /// The uniforms beside `u` along each axis, at a distance of `step(axis)`, inside the cube.
    pub(super) fn neighbours(&self, u: &[f64], step: impl Fn(usize) -> f64) -> Vec<Vec<f64>> {
        let mut all = Vec::with_capacity(2 * u.len());
        for axis in 0..u.len() {
            for side in [-1.0, 1.0] {
                let mut v = u.to_vec();
                v[axis] = (v[axis] + side * step(axis)).clamp(0.0, 1.0 - 0.5 * self.epsilon);
                all.push(v);
            }
        }
        all
    }
}

/// The sample and its coordinates, if there is one and it is finite and on no atom.
fn finite<'a>(sampler: &'a dyn Subject, u: &[f64]) -> Option<(AnySpot<'a>, Vec<f64>)> {
    let x = sampler.forward(u).filter(|x| x.atom().is_none())?;
    let at = x.coordinates();
    at.iter().all(|c| c.is_finite()).then_some((x, at))
}
