//! What coordinates, or their squares, add up to, and the forms of expressions of the point that follow from it.

use super::near_one::by_the_rest;
use super::opposed::{Pair, without_length};
use super::parts::Whole;
use super::units::{Stretched, by_one, by_the_other_side, by_the_others};
use crate::expr::{Graph, Id};
use crate::poly::Expander;

/// What is known of sums of the coordinates and of their squares.
pub(super) struct Sums<'a> {
    /// The combination of coordinates that is one.
    pub whole: Option<&'a Whole>,
    /// The places of coordinates that are together a unit vector.
    pub units: Vec<Vec<u8>>,
    /// Coordinates that are together a unit vector over known lengths.
    pub stretched: Vec<Stretched>,
    /// The point with each of the parameters that are unit vectors.
    pub pairs: Vec<Pair>,
    /// Directions are simplified by their length wherever that pays, before forms are chosen.
    pub is_direction: bool,
}

impl Sums<'_> {
    /// Adds to some forms those in which sums of two unit vectors are free of the errors of their lengths.
    pub(super) fn extend(&self, g: &mut Graph, forms: &mut Vec<Id>) {
        let freed: Vec<Id> =
            forms.iter().filter_map(|&form| without_length(g, form, &self.pairs)).collect();
        forms.extend(freed);
    }

    /// Forms of an expression of the point in which constants are what coordinates, or their squares, add up to, or parts of
    /// lengths are told by the rest.
    pub(super) fn put_into(&self, g: &mut Graph, id: Id) -> Vec<Id> {
        let mut forms = vec![];
        if let Some(whole) = self.whole {
            let normal = Expander::new(g).normal_form(id);
            let both = [Some(id), normal].into_iter().flatten();
            forms.extend(both.map(|form| whole.put_into(g, form)));
        }
        if !self.is_direction {
            forms.extend(by_the_others(g, id, &self.units));
            forms.extend(by_the_other_side(g, id, &self.units));
            forms.extend(self.stretched.iter().filter_map(|s| s.by_the_others(g, id)));
        }
        forms.extend(by_the_rest(g, id));
        forms
    }

    /// Forms of an expression of a direction in which the squares of two coordinates are told by the third.
    pub(super) fn by_one(&self, g: &mut Graph, id: Id) -> Vec<Id> {
        let units = self.units.iter().filter(|_| self.is_direction);
        let each = units.flat_map(|unit| unit.iter().map(move |&x| (unit, x)));
        each.filter_map(|(unit, x)| by_one(g, id, unit, x)).collect()
    }
}
