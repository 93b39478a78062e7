//! How many digits derived samplers and their twins keep, in stiff and extreme cases.

use core::fmt::Debug;
use std::collections::BTreeMap;

use aether_core::{Point, Sampler};

use super::ByHand;
use super::pairs::Visitor;
use crate::points::{FromCoordinates, uniforms};
use crate::registry::{Item, items};
use crate::stability::{Answer, Question, Row, ask, beside};

/// The worst errors of one that was derived and of its twin, over their condition numbers, in units of 2⁻⁵² of the value
/// ([`crate::stability`]): of samples, of densities of points, and of samples with their densities.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Errors {
    /// Of what was derived.
    pub derived: [f64; 3],
    /// Of what was written by hand.
    pub by_hand: [f64; 3],
}

/// Finds the errors of each pair, by the row of the catalogue.
#[derive(Debug)]
pub struct EachPair {
    /// Only pairs with one of these in their names, if there are any.
    pub names: Vec<String>,
    /// What was found.
    pub errors: BTreeMap<u64, Errors>,
    items: Vec<Item>,
}

impl EachPair {
    /// Nothing yet.
    pub fn new(names: &[String]) -> Self {
        EachPair { names: names.to_vec(), errors: BTreeMap::new(), items: items() }
    }
}

impl Visitor for EachPair {
    fn visit<S, H>(&mut self, row: u64, name: &'static str, _: S, _: H)
    where
        S: Sampler<f64>,
        S::Point: FromCoordinates<f64> + Copy + Debug,
        H: ByHand<Uniforms = S::Uniforms, Point = S::Point>,
    {
        let is_asked = super::measure::is_asked(name, &self.names);
        let item = self.items.iter().find(|item| item.row == row);
        if let Some(item) = item.filter(|_| is_asked) {
            let rows = beside(item, |numbers, question| {
                let derived = ask::<f64>(item, numbers, &[*question]).first().copied();
                [derived, Some(says::<S, H>(numbers, question))]
            });
            let [derived, by_hand] = rows.map(worst);
            self.errors.insert(row, Errors { derived, by_hand });
        }
    }
}

/// What a twin with these parameters says.
fn says<S, H>(numbers: &[f64], question: &Question) -> Answer
where
    S: Sampler<f64>,
    S::Point: FromCoordinates<f64> + Copy,
    H: ByHand<Uniforms = S::Uniforms, Point = S::Point>,
{
    let twin = H::with(numbers);
    let u = || uniforms(&question.u);
    let (sample, own) = twin.draw(u());
    let coordinates = |x: &S::Point| x.coordinates().as_ref().iter().copied().collect();
    let point = |x: &[f64]| (!x.is_empty()).then(|| S::Point::from_coordinates(x)).flatten();
    Answer {
        sample: coordinates(&twin.sample(u())),
        valid: true,
        own,
        at_own: Some(twin.pdf(&sample)),
        pdf: question.x.as_ref().and_then(|x| point(x)).map(|x| twin.pdf(&x)),
        ..Answer::default()
    }
}

/// The worst errors of samples, of densities of points, and of samples or their densities.
fn worst(row: Row) -> [f64; 3] {
    let [sample, pdf, own] = [&row.sample, &row.pdf, &row.own].map(|tally| tally.worst_over);
    [sample, pdf, sample.max(own)]
}
