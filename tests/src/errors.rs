//! How far a sampler of the catalogue is from its reference values.

use aether_core::{Point, Sampler, Scalar, Uniforms};

use crate::points::{FromCoordinates, plain, rounded, uniforms};
use crate::reference::{Inputs, PointEntry};
use crate::registry::{Visitor, item_of, visit};

/// Relative errors at one entry of the reference data; infinite where a value is missing or NaN.
#[derive(Clone, Copy, Debug)]
pub struct Errors {
    /// Of the sample, normwise.
    pub sample: f64,
    /// Of `sampler.pdf(x)` at the sample rounded to the precision.
    pub pdf: f64,
    /// Of `sample.pdf()`.
    pub own: f64,
}

/// What a sampler of the catalogue says of uniforms and of a point.
#[derive(Clone, Debug)]
pub struct Values {
    /// The sample of the uniforms.
    pub sample: Vec<f64>,
    /// `sampler.pdf(x)`; `None` if the space has no such point.
    pub pdf: Option<f64>,
    /// `sample.pdf()`.
    pub own: f64,
}

/// Evaluates the sampler that `inputs` name, in the precision `R`, for the uniforms `u` and the point `x`.
///
/// All that the tests ask of a sampler is asked here, so that it is compiled once.
pub fn values<R: Scalar>(inputs: &Inputs, u: &[f64], x: &[f64]) -> Values {
    let found = visit::<R, _>(item_of(inputs), &inputs.numbers(), Evaluate { u, x });
    found.expect("the parameters are in their domain")
}

struct Evaluate<'a> {
    u: &'a [f64],
    x: &'a [f64],
}

impl<R: Scalar> Visitor<R> for Evaluate<'_> {
    type Output = Values;

    fn visit<S: Sampler<R>>(self, sampler: S) -> Values
    where
        S::Point: FromCoordinates<R>,
    {
        let sample = sampler.sample(uniforms(&self.uniforms(S::Uniforms::COUNT)));
        let x: Vec<R> = rounded(self.x);
        Values {
            sample: plain(sample.coordinates().as_ref()),
            pdf: S::Point::from_coordinates(&x).map(|x| sampler.pdf(&x).value().to_f64()),
            own: sample.pdf().value().to_f64(),
        }
    }
}

impl Evaluate<'_> {
    fn uniforms<R: Scalar>(&self, count: usize) -> Vec<R> {
        (0..count).map(|i| R::of(self.u.get(i).copied().unwrap_or(0.5))).collect()
    }
}

/// The errors of the catalogue's sampler at an entry, in the precision `R`.
pub fn errors<R: Scalar>(entry: &PointEntry) -> Errors {
    errors_off_by::<R>(entry, 1.0)
}

/// The same for densities multiplied by `factor`, a deliberate mistake.
pub fn errors_off_by<R: Scalar>(entry: &PointEntry, factor: f64) -> Errors {
    let found = values::<R>(&entry.inputs, &entry.u, &entry.rounded);
    // The smallest normal number: below it the format has an absolute rounding error.
    let floor = if R::EPSILON.to_f64() < 1e-10 { f64::MIN_POSITIVE } else { 1.2e-38 };
    // Rounding takes a sample off its manifold: the density there may be that of the closed form
    // at the coordinates as they are, or that of the nearest point of the manifold.
    let readings = [Some(entry.pdf_at_rounded), entry.pdf_at_projected];
    let pdf = factor * found.pdf.unwrap_or(f64::NAN);
    let own = factor * found.own;
    Errors {
        sample: distance(&found.sample, &entry.x, floor),
        pdf: readings
            .into_iter()
            .flatten()
            .map(|expected| distance(&[pdf], &[expected], floor))
            .fold(f64::INFINITY, f64::min),
        // Where the rounded sample lies on a pole, the shares of its other preimages are infinite.
        own: if entry.pdf_at_rounded.is_infinite() && own == f64::INFINITY {
            0.0
        } else {
            distance(&[own], &[entry.pdf], floor)
        },
    }
}

/// |a - b| / |b|, Euclidean; where b is as good as zero relative to the floor.
fn distance(a: &[f64], b: &[f64], floor: f64) -> f64 {
    if a == b {
        return 0.0;
    }
    // Scaled, because squares of the numbers may leave the range.
    let scale = b.iter().fold(floor, |m, x| m.max(x.abs()));
    let norm =
        |v: &mut dyn Iterator<Item = f64>| v.map(|x| (x / scale).powi(2)).sum::<f64>().sqrt();
    let gap = norm(&mut a.iter().zip(b).map(|(a, b)| a - b));
    let error = gap / norm(&mut b.iter().copied()).max(floor / scale);
    if error.is_nan() { f64::INFINITY } else { error }
}
