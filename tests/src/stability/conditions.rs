//! Condition numbers: what rounding the inputs may cost.

use aether_core::Real;

use super::few::Few;
use super::oracle::{Exact, Format, exact, length, orthogonalise};
use super::probe::{Question, ask};
use crate::precise::Precise;
use crate::registry::Item;

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
    sample: Vec<f64>,
    density: f64,
}

/// The condition numbers of the values at uniforms, for numbers of this format.
pub fn conditions(
    item: &Item,
    numbers: &[f64],
    u: &[Precise],
    at: &Exact,
    format: Format,
) -> Conditions {
    let steps = Steps { uniform: 1e-12, parameter: format.spacing, moved: numbers.len() };
    differences(
        |numbers: &[f64], u: &[Precise]| exact(item, numbers, u),
        steps,
        numbers,
        u,
        at,
        format,
    )
}

/// Steps of differences in `f64`: rounding disturbs the small one, and a border that is near the large one.
pub const STEPS: [f64; 2] = [1e-9, 1e-6];

/// The same from values in `f64` with one of these steps, which takes a hundredth of the time: they agree to
/// some digits, except next to the ends of a uniform.
pub fn estimate(
    steps: Steps,
    item: &Item,
    numbers: &[f64],
    u: &[Precise],
    at: &Exact,
    format: Format,
) -> Conditions {
    let value = |numbers: &[f64], u: &[Precise]| {
        let question = Question { u: u.iter().map(|u| u.to_f64()).collect(), x: None };
        let found = *ask::<f64>(item, numbers, &[question]).first()?;
        found.valid.then(|| Exact {
            x: found.sample.iter().map(|x| Precise::f64(*x)).collect(),
            density: Precise::f64(found.own),
        })
    };
    differences(value, steps, numbers, u, at, format)
}

/// Steps of differences.
#[derive(Clone, Copy, Debug)]
pub struct Steps {
    /// Of uniforms, over their distance from the ends.
    pub uniform: f64,
    /// Of parameters, over themselves.
    pub parameter: f64,
    /// How many parameters are moved.
    pub moved: usize,
}

/// Condition numbers by differences of `value`.
fn differences(
    value: impl Fn(&[f64], &[Precise]) -> Option<Exact>,
    steps: Steps,
    numbers: &[f64],
    u: &[Precise],
    at: &Exact,
    format: Format,
) -> Conditions {
    let motion = |up: Option<Exact>, down: Option<Exact>, scale: f64| {
        let (up, down) = (up?, down?);
        let change = |a: &Precise, b: &Precise| (*a - *b).to_f64() * scale;
        Some(Motion {
            sample: up.x.iter().zip(down.x.iter()).map(|(a, b)| change(a, b)).collect(),
            density: ((up.density - down.density) / at.density).to_f64() * scale,
        })
    };
    let of_uniform = |i: usize| {
        let h = u[i].min(Precise::ONE - u[i]) * Precise::of(steps.uniform);
        let moved = |h: Precise| {
            let mut u = u.to_vec();
            u[i] += h;
            value(numbers, &u)
        };
        let scale = 0.25 * (u[i] / h).to_f64();
        motion(moved(h), moved(-h), scale)
    };
    let step = steps.parameter;
    let of_parameter = |j: usize| {
        let moved = |h: f64| {
            let mut numbers = numbers.to_vec();
            numbers[j] *= 1.0 + h;
            value(&numbers, u)
        };
        let (up, down) = (moved(step), moved(-step));
        match (up.is_some(), down.is_some()) {
            (true, true) => motion(up, down, 0.25 / step),
            (true, false) => motion(up, Some(*at), 0.5 / step),
            _ => motion(Some(*at), down, 0.5 / step),
        }
    };
    let uniforms: Vec<Option<Motion>> = (0..u.len()).map(of_uniform).collect();
    let movable = (0..steps.moved).filter(|j| numbers[*j] != 0.0);
    let parameters: Vec<Motion> = movable.filter_map(of_parameter).collect();
    combine(&uniforms, &parameters, u, at, format)
}

/// Condition numbers from what each input does; infinite where they cannot be had.
fn combine(
    uniforms: &[Option<Motion>],
    parameters: &[Motion],
    u: &[Precise],
    at: &Exact,
    format: Format,
) -> Conditions {
    let none = Conditions {
        sample: f64::INFINITY,
        density: f64::INFINITY,
        own: f64::INFINITY,
        inverse: u.iter().map(|_| f64::INFINITY).collect(),
    };
    let Some(uniforms) = uniforms.iter().map(Option::as_ref).collect::<Option<Vec<_>>>() else {
        return none;
    };
    let x: Vec<f64> = at.x.iter().map(|x| x.to_f64()).collect();
    let known = |c: f64| if c.is_nan() { f64::INFINITY } else { c };
    let all = uniforms.iter().copied().chain(parameters);
    let sample = all.clone().map(|m| length(&m.sample)).sum::<f64>() / length(&x);
    let from_uniforms = all.map(|m| m.density.abs()).sum::<f64>();

    // Columns are those of the Jacobian, each times half its uniform.
    let mut columns: Vec<Vec<f64>> = uniforms.iter().map(|m| m.sample.clone()).collect();
    let triangle = orthogonalise(&mut columns);
    // The changes of uniforms, relative to half of each, that move the point by `v`.
    let back = |v: &[f64]| {
        let mut w: Vec<f64> =
            columns.iter().map(|c| c.iter().zip(v).map(|(a, b)| a * b).sum()).collect();
        for i in (0..w.len()).rev() {
            w[i] /= triangle[i][i];
            for k in 0..i {
                w[k] -= triangle[i][k] * w[i];
            }
        }
        w
    };
    let slope = |w: &[f64]| w.iter().zip(&uniforms).map(|(w, m)| w * m.density).sum::<f64>();
    let mut density = 0.0;
    let mut inverse = vec![0.0; u.len()];
    let mut add = |w: Vec<f64>, change: f64| {
        density += change.abs();
        inverse.iter_mut().zip(w).for_each(|(c, w)| *c += 0.5 * w.abs());
    };
    for (j, x) in x.iter().enumerate() {
        let half = 0.5 * x.abs().max(format.floor);
        let v: Vec<f64> = (0..at.x.len()).map(|k| if k == j { half } else { 0.0 }).collect();
        let w = back(&v);
        let change = slope(&w);
        add(w, change);
    }
    for m in parameters {
        let w = back(&m.sample);
        let change = m.density - slope(&w);
        add(w, change);
    }
    Conditions {
        sample: known(sample),
        density: known(density),
        own: known(density).max(known(from_uniforms)),
        inverse: inverse.into_iter().map(known).collect(),
    }
}
