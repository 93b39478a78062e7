//! The exact sample and density of uniforms.

use aether_core::{Point, Real, Sampler, Scalar};

use super::few::Few;
use super::probe::Answer;
use crate::points::{FromCoordinates, uniforms};
use crate::precise::{Dual, Precise};
use crate::registry::{Item, Visitor};

/// A sample and its density.
#[derive(Clone, Copy, Debug)]
pub struct Exact {
    /// The coordinates of the sample.
    pub x: Few<Precise>,
    /// The density there.
    pub density: Precise,
}

impl Exact {
    /// What `f64` says, as if it were exact; none if that is no sample.
    pub fn of_double(found: &Answer) -> Option<Self> {
        let x = || found.sample.iter().map(|x| Precise::f64(*x)).collect();
        found.valid.then(|| Exact { x: x(), density: Precise::f64(found.own) })
    }
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

impl Format {
    /// That of a number type.
    pub fn of<R: Scalar>() -> Self {
        let floor = R::MIN_POSITIVE.to_f64();
        let double = floor < 1e-300;
        let ceiling = if double { f64::MAX } else { f64::from(f32::MAX) };
        Format { spacing: R::EPSILON.to_f64(), floor, ceiling }
    }

    /// A relative error in units; one that is as large as the value counts as that.
    pub fn units(&self, relative: f64) -> f64 {
        if relative.is_nan() { 1.0 / self.spacing } else { relative.min(1.0) / self.spacing }
    }

    /// The error of a density.
    pub fn density(&self, found: f64, exact: Precise) -> f64 {
        let expected = exact.to_f64();
        if found == f64::INFINITY && expected >= self.ceiling || found == expected {
            return 0.0;
        }
        let gap = (Precise::f64(found) - exact).abs().to_f64();
        self.units(gap / expected.max(self.floor))
    }

    /// The error of the logarithm of a density that leaves the range of numbers, as one of the density, beyond what
    /// rounding the logarithm costs; infinite if the density is not the zero or the infinity that it rounds to.
    pub fn beyond_range(&self, found: f64, log: f64, expected: f64) -> f64 {
        let rounded = match expected < 1.0 {
            true => (0.0..=2.0 * self.floor).contains(&found),
            false => found == f64::INFINITY || found >= 0.5 * self.ceiling,
        };
        let truth = expected.ln();
        let gap = (log - truth).abs() - truth.abs() * self.spacing;
        self.units(if rounded { gap.max(0.0) } else { f64::INFINITY })
    }

    /// The error of a vector.
    pub fn vector(&self, found: &[f64], exact: &[Precise]) -> f64 {
        let gap = norm(found.iter().zip(exact).map(|(a, b)| (Precise::f64(*a) - *b).to_f64()));
        let size = norm(exact.iter().map(|x| x.to_f64()));
        if gap == 0.0 { 0.0 } else { self.units(gap / size.max(self.floor)) }
    }
}

/// Euclidean length to a few roundings: without `hypot`, which takes long, where squares stay in the range of numbers.
fn norm(x: impl Iterator<Item = f64> + Clone) -> f64 {
    let squares: f64 = x.clone().map(|x| x * x).sum();
    let inside = (1e-250..1e250).contains(&squares);
    if inside { squares.sqrt() } else { x.fold(0.0, f64::hypot) }
}

/// How far the image of another preimage may be from the point, relative to that. A uniform next to the border of a piece
/// may have no digits left of how far it is from there.
const KNOWN: f64 = 1e-20;

/// How far two orders of the columns may be apart in a volume. Where columns are parallel to more digits than there are,
/// neither is right.
const AGREEMENT: f64 = 1e-12;

/// The exact values at uniforms, with a density that is not a number where 31 digits do not tell it; `None` if there is no sample or the parameters are illegal.
pub fn exact(item: &Item, numbers: &[f64], u: &[Precise]) -> Option<Exact> {
    let several = item.preimages > 1;
    let (x, others) = item.visit::<Precise, _>(numbers, Place { u, several }).ok()??;
    let own = share(item, numbers, u);
    let density = others.iter().fold(own, |sum, v| {
        let Some(v) = v else { return Precise::f64(f64::NAN) };
        let share = share(item, numbers, v);
        // A uniform that is smaller than any number has a derivative larger than any.
        let vanishes = !share.finite() && v.contains(&Precise::ZERO);
        if vanishes { sum } else { sum + share }
    });
    Some(Exact { x: Few::new(&x), density })
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
    type Output = Option<(Vec<Precise>, Vec<Option<Vec<Precise>>>)>;

    fn visit<S: Sampler<Precise>>(self, sampler: S) -> Self::Output
    where
        S::Point: FromCoordinates<Precise>,
    {
        let (x, valid) = sampler.forward(uniforms(self.u));
        if !valid {
            return None;
        }
        let mut found = Vec::new();
        if self.several {
            sampler.preimages(&x, |v, exists| found.extend(exists.then(|| v.as_ref().to_vec())));
        }
        let x = x.coordinates().as_ref().to_vec();
        let image = |v: &[Precise]| sampler.forward(uniforms(v)).0.coordinates().as_ref().to_vec();
        let others = others(self.u, &x, found, &image);
        Some((x, others))
    }
}

/// Of the preimages of `x` those that are not `u`; `None` for each that does not lead to `x`.
fn others(
    u: &[Precise],
    x: &[Precise],
    found: Vec<Vec<Precise>>,
    image: &dyn Fn(&[Precise]) -> Vec<Precise>,
) -> Vec<Option<Vec<Precise>>> {
    let gap =
        |v: &[Precise]| v.iter().zip(u).map(|(a, b)| (*a - *b).abs().to_f64()).fold(0.0, f64::max);
    let mut found: Vec<(f64, Vec<Precise>)> = found.into_iter().map(|v| (gap(&v), v)).collect();
    // The nearest is the sample itself.
    found.sort_by(|a, b| a.0.total_cmp(&b.0));
    let others = found.into_iter().skip(1).map(|(_, v)| {
        let gap: Vec<Precise> = image(&v).iter().zip(x).map(|(a, b)| *a - *b).collect();
        let known = length(&gap).to_f64() <= KNOWN * length(x).to_f64();
        known.then_some(v)
    });
    others.collect()
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
        let (x, _) = sampler.forward(uniforms(&self.seeds()));
        slopes(x.coordinates().as_ref())
    }
}

impl Slope<'_> {
    fn seeds(&self) -> Vec<Dual> {
        let seed = |(i, u): (usize, &Precise)| {
            if i == self.axis { Dual::variable(*u) } else { Dual::constant(*u) }
        };
        self.u.iter().enumerate().map(seed).collect()
    }
}

fn slopes(x: &[Dual]) -> Vec<Precise> {
    x.iter().map(|c| c.slope).collect()
}

/// Euclidean length, without overflow.
pub fn length<R: Scalar>(v: &[R]) -> R {
    v.iter().fold(R::ZERO, |sum, x| sum.hypot(*x))
}

/// The volume that vectors span: the product of their lengths after orthogonalisation.
fn volume(mut columns: Vec<Vec<Precise>>) -> Precise {
    let mut reversed: Vec<Vec<Precise>> = columns.iter().rev().cloned().collect();
    let [volume, other] = [&mut columns, &mut reversed].map(|columns| {
        let triangle = orthogonalise(columns);
        triangle.iter().fold(Precise::ONE, |product, r| product * r[r.len() - 1])
    });
    let gap = ((volume - other) / volume).abs().to_f64();
    if gap > AGREEMENT { Precise::f64(f64::NAN) } else { volume }
}

/// Makes the columns orthonormal; the coefficients of each column as it was.
pub fn orthogonalise<R: Scalar>(columns: &mut [Vec<R>]) -> Vec<Vec<R>> {
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
