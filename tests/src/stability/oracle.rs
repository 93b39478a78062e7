//! The exact sample and density of uniforms, and their condition numbers.

use aether_core::{Point, Real, Sampler, Scalar, Uniforms};

use crate::points::FromCoordinates;
use crate::precise::{Dual, Precise};
use crate::registry::{Item, Visitor};

/// A sample and its density.
#[derive(Clone, Debug)]
pub struct Exact {
    /// The coordinates of the sample.
    pub x: Vec<Precise>,
    /// The density there.
    pub density: Precise,
}

/// A format of floating-point numbers.
#[derive(Clone, Copy, Debug)]
pub struct Format {
    /// Distance from one to the next larger number.
    pub spacing: f64,
    /// The smallest normal number; below it the spacing is that of this one.
    pub floor: f64,
    /// The largest number.
    pub ceiling: f64,
}

/// What moving each input by half a unit may cost.
#[derive(Clone, Debug)]
pub struct Conditions {
    /// Of the sample, relative to its length: uniforms and parameters move.
    pub sample: f64,
    /// Of the density: coordinates, along the manifold, and parameters move.
    pub density: f64,
    /// Of each uniform of the inverse, relative to the uniform.
    pub inverse: Vec<f64>,
}

/// The exact values at uniforms; `None` if there is no sample or the parameters are illegal.
pub fn exact(item: &Item, numbers: &[f64], u: &[Precise]) -> Option<Exact> {
    let several = item.preimages > 1;
    let (x, others) = item.visit::<Precise, _>(numbers, Place { u, several }).ok()??;
    let own = share(item, numbers, u);
    let density = others.iter().fold(own, |sum, v| sum + share(item, numbers, v));
    Some(Exact { x, density })
}

/// What one preimage gives to the density.
fn share(item: &Item, numbers: &[f64], u: &[Precise]) -> Precise {
    let column = |axis| item.visit::<Dual, _>(numbers, Slope { u, axis }).unwrap_or_default();
    volume((0..u.len()).map(column).collect()).recip()
}

struct Place<'a> {
    u: &'a [Precise],
    several: bool,
}

impl Visitor<Precise> for Place<'_> {
    type Output = Option<(Vec<Precise>, Vec<Vec<Precise>>)>;

    fn visit<S: Sampler<Precise>>(self, sampler: S) -> Self::Output
    where
        S::Point: FromCoordinates<Precise>,
    {
        let (x, valid) = sampler.forward(S::Uniforms::from_fn(|i| self.u[i]));
        if !valid {
            return None;
        }
        let mut found: Vec<(f64, Vec<Precise>)> = Vec::new();
        if self.several {
            sampler.preimages(&x, |v, exists| {
                let v = v.as_ref();
                let gap = v.iter().zip(self.u).map(|(a, b)| (*a - *b).abs().to_f64());
                if exists {
                    found.push((gap.fold(0.0, f64::max), v.to_vec()));
                }
            });
        }
        // The nearest is the sample itself.
        found.sort_by(|a, b| a.0.total_cmp(&b.0));
        let others = found.into_iter().skip(1).map(|(_, v)| v).collect();
        Some((x.coordinates().as_ref().to_vec(), others))
    }
}

struct Slope<'a> {
    u: &'a [Precise],
    axis: usize,
}

impl Visitor<Dual> for Slope<'_> {
    type Output = Vec<Precise>;

    fn visit<S: Sampler<Dual>>(self, sampler: S) -> Vec<Precise>
    where
        S::Point: FromCoordinates<Dual>,
    {
        let seed = |i| {
            if i == self.axis { Dual::variable(self.u[i]) } else { Dual::constant(self.u[i]) }
        };
        let (x, _) = sampler.forward(S::Uniforms::from_fn(seed));
        x.coordinates().as_ref().iter().map(|c| c.slope).collect()
    }
}

/// Euclidean length, without overflow.
pub fn length<R: Scalar>(v: &[R]) -> R {
    v.iter().fold(R::ZERO, |sum, x| sum.hypot(*x))
}

/// The volume that vectors span: the product of their lengths after orthogonalisation.
fn volume(mut columns: Vec<Vec<Precise>>) -> Precise {
    orthogonalise(&mut columns).iter().fold(Precise::ONE, |product, r| product * r[r.len() - 1])
}

/// Makes the columns orthonormal; the coefficients of each column as it was.
fn orthogonalise<R: Scalar>(columns: &mut [Vec<R>]) -> Vec<Vec<R>> {
    let mut triangle: Vec<Vec<R>> = Vec::new();
    for i in 0..columns.len() {
        let (done, rest) = columns.split_at_mut(i);
        let column = &mut rest[0];
        let mut coefficients = Vec::new();
        for unit in done {
            let along = unit.iter().zip(column.iter()).fold(R::ZERO, |s, (a, b)| s + *a * *b);
            column.iter_mut().zip(unit.iter()).for_each(|(x, u)| *x -= along * *u);
            coefficients.push(along);
        }
        let norm = length(column);
        column.iter_mut().for_each(|x| *x /= norm);
        coefficients.push(norm);
        triangle.push(coefficients);
    }
    triangle
}

/// How the sample and the logarithm of its density change with an input, times half the input.
struct Motion {
    sample: Vec<f64>,
    density: f64,
}

/// Differences over a step that is small against the distance from the ends of a uniform.
const STEP: f64 = 1e-12;

/// The condition numbers of the values at uniforms, for numbers of this format.
pub fn conditions(
    item: &Item,
    numbers: &[f64],
    u: &[Precise],
    at: &Exact,
    format: Format,
) -> Conditions {
    let motion = |up: Option<Exact>, down: Option<Exact>, scale: f64| {
        let (up, down) = (up?, down?);
        let change = |a: &Precise, b: &Precise| (*a - *b).to_f64() * scale;
        Some(Motion {
            sample: up.x.iter().zip(&down.x).map(|(a, b)| change(a, b)).collect(),
            density: ((up.density - down.density) / at.density).to_f64() * scale,
        })
    };
    let of_uniform = |i: usize| {
        let h = u[i].min(Precise::ONE - u[i]) * Precise::of(STEP);
        let moved = |h: Precise| {
            let mut u = u.to_vec();
            u[i] += h;
            exact(item, numbers, &u)
        };
        let scale = 0.25 * (u[i] / h).to_f64();
        motion(moved(h), moved(-h), scale)
    };
    // A parameter cannot be moved by less than its spacing.
    let step = format.spacing;
    let of_parameter = |j: usize| {
        let moved = |h: f64| {
            let mut numbers = numbers.to_vec();
            numbers[j] *= 1.0 + h;
            exact(item, &numbers, u)
        };
        let (up, down) = (moved(step), moved(-step));
        match (up.is_some(), down.is_some()) {
            (true, true) => motion(up, down, 0.25 / step),
            (true, false) => motion(up, Some(at.clone()), 0.5 / step),
            _ => motion(Some(at.clone()), down, 0.5 / step),
        }
    };
    let uniforms: Vec<Option<Motion>> = (0..u.len()).map(of_uniform).collect();
    let movable = (0..numbers.len()).filter(|j| numbers[*j] != 0.0);
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
        inverse: vec![f64::INFINITY; u.len()],
    };
    let Some(uniforms) = uniforms.iter().map(Option::as_ref).collect::<Option<Vec<_>>>() else {
        return none;
    };
    let x: Vec<f64> = at.x.iter().map(|x| x.to_f64()).collect();
    let known = |c: f64| if c.is_nan() { f64::INFINITY } else { c };
    let all = uniforms.iter().copied().chain(parameters);
    let sample = all.map(|m| length(&m.sample)).sum::<f64>() / length(&x);

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
        inverse: inverse.into_iter().map(known).collect(),
    }
}
