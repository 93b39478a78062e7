//! Condition numbers: what rounding the inputs may cost.
//!
//! They are sums over the inputs, so that some of the inputs tell a lower bound. Mostly that is all that is asked.

use aether_core::Real;

use super::few::Few;
use super::oracle::{Exact, Format, exact, length, orthogonalise};
use super::probe::{Question, ask};
use crate::precise::Precise;
use crate::registry::Item;

/// A point with its exact values, and the format of numbers in question.
#[derive(Clone, Copy)]
pub struct Spot<'a> {
    /// The sampler.
    pub item: &'a Item,
    /// Its parameters.
    pub numbers: &'a [f64],
    /// The uniforms.
    pub u: &'a [f64],
    /// The sample and its density.
    pub exact: &'a Exact,
    /// The format.
    pub format: Format,
}

/// What moving each input by half a unit may cost.
#[derive(Clone, Copy, Debug)]
pub struct Conditions {
    /// Of the sample, relative to its length: uniforms and parameters move.
    pub sample: f64,
    /// Of the density: coordinates, along the manifold, and parameters move.
    pub density: f64,
    /// Of the density of a sample, which is computed from the uniforms or from the sample, as it was rounded:
    /// the former, or what moving uniforms and parameters costs, whichever is more.
    pub own: f64,
    /// Of each uniform of the inverse, relative to the uniform.
    pub inverse: Few<f64>,
}

/// How the sample and the logarithm of its density change with an input, times half the input.
struct Motion {
    sample: Few<f64>,
    density: f64,
}

/// Where differences come from.
#[derive(Clone, Copy, Debug)]
pub enum Source {
    /// The oracle.
    Exact,
    /// Values in `f64`, in steps of this size, which take a hundredth of the time: where two sizes agree, so do
    /// differences of the oracle, except next to the ends of a uniform.
    Double(f64),
}

/// Steps of differences in `f64`: rounding disturbs small ones, and a border that is near large ones.
pub const STEPS: [f64; 3] = [1e-9, 1e-6, 1e-4];

/// Differences at a point with respect to the uniforms and to some of the parameters.
pub struct Differences<'a> {
    spot: Spot<'a>,
    source: Source,
    /// None where the uniforms cannot be moved.
    uniforms: Option<Vec<Motion>>,
    parameters: Vec<Motion>,
}

impl<'a> Differences<'a> {
    /// With respect to the uniforms.
    pub fn new(spot: Spot<'a>, source: Source) -> Self {
        let mut new = Differences { spot, source, uniforms: None, parameters: Vec::new() };
        new.uniforms = (0..spot.u.len()).map(|i| new.of_uniform(i)).collect();
        new
    }

    /// With respect to this parameter, too.
    pub fn add(&mut self, parameter: usize) {
        if self.spot.numbers[parameter] != 0.0 && self.uniforms.is_some() {
            let motion = self.of_parameter(parameter);
            self.parameters.extend(motion);
        }
    }

    fn value(&self, numbers: &[f64], u: &[Precise]) -> Option<Exact> {
        match self.source {
            Source::Exact => exact(self.spot.item, numbers, u),
            Source::Double(_) => {
                let question = Question { u: u.iter().map(|u| u.to_f64()).collect(), x: None };
                Exact::of_double(ask::<f64>(self.spot.item, numbers, &[question]).first()?)
            }
        }
    }

    fn motion(&self, up: Option<Exact>, down: Option<Exact>, scale: f64) -> Option<Motion> {
        let (up, down) = (up?, down?);
        let change = |a: &Precise, b: &Precise| (*a - *b).to_f64() * scale;
        Some(Motion {
            sample: up.x.iter().zip(down.x.iter()).map(|(a, b)| change(a, b)).collect(),
            density: ((up.density - down.density) / self.spot.exact.density).to_f64() * scale,
        })
    }

    fn of_uniform(&self, i: usize) -> Option<Motion> {
        let step = match self.source {
            Source::Exact => 1e-12,
            Source::Double(step) => step,
        };
        let u: Few<Precise> = self.spot.u.iter().map(|u| Precise::f64(*u)).collect();
        let h = u[i].min(Precise::ONE - u[i]) * Precise::of(step);
        let moved = |h: Precise| {
            let all = u.iter().enumerate().map(|(k, u)| if k == i { *u + h } else { *u });
            self.value(self.spot.numbers, &all.collect::<Few<Precise>>())
        };
        self.motion(moved(h), moved(-h), 0.25 * (u[i] / h).to_f64())
    }

    fn of_parameter(&self, j: usize) -> Option<Motion> {
        let Spot { numbers, u, exact, format, .. } = self.spot;
        let step = match self.source {
            Source::Exact => format.spacing,
            Source::Double(step) => step.max(format.spacing),
        };
        let u: Few<Precise> = u.iter().map(|u| Precise::f64(*u)).collect();
        let moved = |h: f64| {
            let mut numbers = numbers.to_vec();
            numbers[j] *= 1.0 + h;
            self.value(&numbers, &u)
        };
        let (up, down) = (moved(step), moved(-step));
        match (up.is_some(), down.is_some()) {
            (true, true) => self.motion(up, down, 0.25 / step),
            (true, false) => self.motion(up, Some(*exact), 0.5 / step),
            _ => self.motion(Some(*exact), down, 0.5 / step),
        }
    }

    /// Condition numbers as far as the inputs were asked for; infinite where they cannot be had.
    pub fn conditions(&self) -> Conditions {
        let Spot { u, exact, format, .. } = self.spot;
        let Some(uniforms) = &self.uniforms else {
            let unknown = f64::INFINITY;
            let inverse = u.iter().map(|_| unknown).collect();
            return Conditions { sample: unknown, density: unknown, own: unknown, inverse };
        };
        let x: Few<f64> = exact.x.iter().map(|x| x.to_f64()).collect();
        let known = |c: f64| if c.is_nan() { f64::INFINITY } else { c };
        let all = uniforms.iter().chain(&self.parameters);
        let sample = all.clone().map(|m| length(&m.sample)).sum::<f64>() / length(&x);
        let from_uniforms = all.map(|m| m.density.abs()).sum::<f64>();

        let back = Back::new(uniforms);
        let mut density = 0.0;
        let mut inverse = vec![0.0; u.len()];
        let mut add = |w: Vec<f64>, change: f64| {
            density += change.abs();
            inverse.iter_mut().zip(w).for_each(|(c, w)| *c += 0.5 * w.abs());
        };
        for (j, x) in x.iter().enumerate() {
            let half = 0.5 * x.abs().max(format.floor);
            let v: Few<f64> = (0..exact.x.len()).map(|k| if k == j { half } else { 0.0 }).collect();
            let w = back.uniforms(&v);
            let change = back.slope(&w);
            add(w, change);
        }
        for m in &self.parameters {
            let w = back.uniforms(&m.sample);
            let change = m.density - back.slope(&w);
            add(w, change);
        }
        Conditions {
            sample: known(sample),
            density: known(density),
            own: known(density).max(known(from_uniforms)),
            inverse: inverse.into_iter().map(known).collect(),
        }
    }
}

/// From changes of the point to those of the uniforms: its columns are those of the Jacobian, each times half its
/// uniform.
struct Back<'a> {
    motions: &'a [Motion],
    columns: Vec<Vec<f64>>,
    triangle: Vec<Vec<f64>>,
}

impl<'a> Back<'a> {
    fn new(motions: &'a [Motion]) -> Self {
        let mut columns: Vec<Vec<f64>> = motions.iter().map(|m| m.sample.to_vec()).collect();
        let triangle = orthogonalise(&mut columns);
        Back { motions, columns, triangle }
    }

    /// The changes of uniforms, relative to half of each, that move the point by `v`.
    fn uniforms(&self, v: &[f64]) -> Vec<f64> {
        let along = |c: &Vec<f64>| c.iter().zip(v).map(|(a, b)| a * b).sum();
        let mut w: Vec<f64> = self.columns.iter().map(along).collect();
        for i in (0..w.len()).rev() {
            w[i] /= self.triangle[i][i];
            for k in 0..i {
                w[k] -= self.triangle[i][k] * w[i];
            }
        }
        w
    }

    /// The change of the logarithm of the density with these.
    fn slope(&self, w: &[f64]) -> f64 {
        w.iter().zip(self.motions).map(|(w, m)| w * m.density).sum()
    }
}
