//! A sampler as the checks see it: coordinates and densities in `f64`.

use super::derivative::{Derivative, distance, norm};
use super::space::Space;
use crate::point::Point;
use crate::real::Scalar;
use crate::sampler::{Sampler, Uniforms};
use crate::uniform::{Pcg32, draw_uniforms};

/// A sampler with what the checks need to know about it.
pub(super) struct Probe<'a, S: Sampler<R>, R: Scalar> {
    pub(super) sampler: &'a S,
    /// Rounding unit of `R`.
    pub(super) epsilon: f64,
    /// Some sample, to make other points like it.
    pub(super) model: S::Point,
    /// Coordinates of some samples.
    pub(super) pilot: Vec<Vec<f64>>,
    /// Median distance of the samples from the origin: what rounding of coordinates is relative to.
    scale: f64,
}

impl<'a, S: Sampler<R>, R: Scalar> Probe<'a, S, R>
where
    S::Point: Space<R>,
{
    /// Draws some samples; `None` if there are none.
    pub(super) fn new(sampler: &'a S, seed: u64) -> Option<Self> {
        let mut source = Pcg32::new(seed, 1, 0);
        let samples: Vec<_> =
            (0..16_384).filter_map(|_| finite(sampler, Self::draw_array(&mut source))).collect();
        let model = samples.first()?.0;
        let pilot: Vec<_> = samples.into_iter().map(|(_, x)| x).collect();
        let mut lengths: Vec<f64> = pilot.iter().map(|x| norm(x)).collect();
        lengths.sort_by(f64::total_cmp);
        let scale = lengths[lengths.len() / 2];
        Some(Probe { sampler, epsilon: R::EPSILON.to_f64(), model, pilot, scale })
    }

    fn draw_array(source: &mut Pcg32) -> S::Uniforms {
        draw_uniforms::<R, S::Uniforms>(source)
    }

    /// Uniforms at random, as the sampler gets them.
    pub(super) fn draw(source: &mut Pcg32) -> Vec<f64> {
        Self::draw_array(source).as_ref().iter().map(|u| u.to_f64()).collect()
    }

    /// Rounded to `R` and kept below one.
    pub(super) fn uniforms(&self, u: &[f64]) -> S::Uniforms {
        let below_one = R::ONE - R::EPSILON * R::of(0.5);
        S::Uniforms::from_fn(|i| R::of(u[i]).max(R::ZERO).min(below_one))
    }

    /// The sample and its coordinates, if there is one and it is finite.
    pub(super) fn forward(&self, u: &[f64]) -> Option<(S::Point, Vec<f64>)> {
        finite(self.sampler, self.uniforms(u))
    }

    /// All preimages.
    pub(super) fn preimages(&self, x: &S::Point) -> Vec<Vec<f64>> {
        let mut found = Vec::new();
        self.sampler.preimages(x, |u, valid| {
            if valid {
                found.push(u.as_ref().iter().map(|u| u.to_f64()).collect());
            }
        });
        found
    }

    /// The density.
    pub(super) fn pdf(&self, x: &S::Point) -> f64 {
        self.sampler.pdf(x).value().to_f64()
    }

    /// Whether the sampler takes as many uniforms as its space has dimensions.
    pub(super) fn is_square() -> bool {
        S::Uniforms::COUNT == <S::Point as Point<R>>::DIMENSION
    }

    /// The derivative of the forward map by differences.
    pub(super) fn derivative(&self, u: &[f64]) -> Option<Derivative> {
        Derivative::of(&|v| self.forward(v).map(|(_, x)| x), u)
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
        let Some((_, y)) = self.forward(v) else { return false };
        let reach = self
            .neighbours(v, |_| 4.0 * self.epsilon)
            .iter()
            .filter_map(|w| self.forward(w))
            .map(|(_, z)| distance(&y, &z))
            .fold(0.0, f64::max);
        distance(&y, x) <= slack * (64.0 * self.epsilon * self.magnitude(x) + 2.0 * reach)
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

/// The sample and its coordinates, if there is one and it is finite.
fn finite<S: Sampler<R>, R: Scalar>(sampler: &S, u: S::Uniforms) -> Option<(S::Point, Vec<f64>)> {
    let (x, valid) = sampler.forward(u);
    let at = coordinates(&x);
    (valid && at.iter().all(|c| c.is_finite())).then_some((x, at))
}

/// A point's coordinates in `f64`.
pub(super) fn coordinates<R: Scalar, P: Point<R>>(x: &P) -> Vec<f64> {
    x.coordinates().as_ref().iter().map(|c| c.to_f64()).collect()
}
