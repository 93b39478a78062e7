//! What a sampler says of uniforms and points, many in one visit: making a sampler may cost more than asking it.

use aether_core::{Point, Sampler, Scalar, Uniforms};

use super::few::Few;
use crate::points::{FromCoordinates, plain, rounded, uniforms};
use crate::registry::{Item, Visitor};

/// What a sampler with certain parameters is asked.
#[derive(Clone, Copy, Debug, Default)]
pub struct Question {
    /// Uniforms.
    pub u: Few<f64>,
    /// A point, if anything is asked beside the sample and its own density.
    pub x: Option<Few<f64>>,
}

/// What it says.
#[derive(Clone, Copy, Debug, Default)]
pub struct Answer {
    /// The sample.
    pub sample: Few<f64>,
    /// Whether there is one.
    pub valid: bool,
    /// `sample.pdf()`.
    pub own: f64,
    /// `sampler.pdf(sample)`.
    pub at_own: Option<f64>,
    /// `sampler.pdf(x)`.
    pub pdf: Option<f64>,
    /// `sampler.log_pdf(x)`, where that density is not a normal number.
    pub log_pdf: Option<f64>,
    /// The preimage of `x` that is nearest to the uniforms.
    pub back: Option<Few<f64>>,
    /// Whether one of the preimages is NaN.
    pub nan: bool,
}

/// The answers to these questions; none if the parameters are not in their domain.
pub fn ask<R: Scalar>(item: &Item, numbers: &[f64], questions: &[Question]) -> Vec<Answer> {
    item.visit::<R, _>(numbers, Ask(questions)).unwrap_or_default()
}

struct Ask<'a>(&'a [Question]);

impl<R: Scalar> Visitor<R> for Ask<'_> {
    type Output = Vec<Answer>;

    fn visit<S: Sampler<R>>(self, sampler: S) -> Vec<Answer>
    where
        S::Point: FromCoordinates<R>,
    {
        self.0.iter().map(|question| answer(sampler, question)).collect()
    }
}

fn answer<R: Scalar, S: Sampler<R>>(sampler: S, question: &Question) -> Answer
where
    S::Point: FromCoordinates<R>,
{
    let u: Few<R> = rounded(&question.u);
    let sample = sampler.sample(uniforms(&u));
    let mut found = Answer {
        sample: plain(sample.coordinates().as_ref()),
        valid: sample.is_valid(),
        own: sample.pdf().value().to_f64(),
        ..Answer::default()
    };
    let Some(x) = &question.x else { return found };
    found.at_own = Some(sampler.pdf(&sample).value().to_f64());
    let x: Few<R> = rounded(x);
    let point = if x.is_empty() { None } else { S::Point::from_coordinates(&x) };
    if let Some(x) = point {
        let pdf = sampler.pdf(&x).value();
        found.pdf = Some(pdf.to_f64());
        let normal = pdf.gt(R::MIN_POSITIVE) && pdf.lt(R::INFINITY);
        if !normal {
            found.log_pdf = Some(sampler.log_pdf(&x).to_f64());
        }
        sampler.preimages(&x, |v, exists| {
            if exists {
                found.has_preimage(plain(v.as_ref()), &question.u);
            }
        });
    }
    found
}

impl Answer {
    /// Keeps a preimage if it is nearer to the uniforms than the one that is known.
    fn has_preimage(&mut self, v: Few<f64>, u: &[f64]) {
        self.nan |= v.iter().any(|v| v.is_nan());
        let gap = |v: &[f64]| v.iter().zip(u).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
        if self.back.is_none_or(|known| gap(&v) < gap(&known)) {
            self.back = Some(v);
        }
    }
}

/// How many uniforms a sampler has; none if the parameters are not in their domain.
pub fn dimensions<R: Scalar>(item: &Item, set: &[f64]) -> Option<usize> {
    item.visit::<R, _>(set, Dimensions).ok()
}

struct Dimensions;
impl<R: Scalar> Visitor<R> for Dimensions {
    type Output = usize;
    fn visit<S: Sampler<R>>(self, _: S) -> usize
    where
        S::Point: FromCoordinates<R>,
    {
        S::Uniforms::COUNT
    }
}

/// Whether the parameters are in their domain; if not, says so.
pub fn legal<R: Scalar>(item: &Item, set: &[f64], dropped: &mut Vec<String>) -> bool {
    if set.iter().any(|x| !x.is_finite()) {
        dropped.push(format!("{set:?} overflows"));
        return false;
    }
    let made = item.visit::<R, _>(set, Dimensions);
    if let Err(error) = &made {
        dropped.push(error.to_string());
    }
    made.is_ok()
}
