//! Functions that jump at integers, all by `floor`: a piece for each integer that is passed.

use quote::ToTokens;

use super::body::Body;
use crate::expr::{Id, UNKNOWNS};
use crate::rational::Q;

impl Body<'_> {
    /// The smallest integer not below x.
    pub(super) fn ceiling(&mut self, at: &impl ToTokens, x: Id) -> Option<Id> {
        let opposite = self.graph.neg(x);
        let below = self.floor(at, opposite)?;
        Some(self.graph.neg(below))
    }

    /// x without what it has beyond an integer, on both sides of zero.
    pub(super) fn truncated(&mut self, at: &impl ToTokens, x: Id) -> Option<Id> {
        if self.is_negative(x) { self.ceiling(at, x) } else { self.floor(at, x) }
    }

    /// The nearest integer; of two, the one that is farther from zero.
    pub(super) fn rounded(&mut self, at: &impl ToTokens, x: Id) -> Option<Id> {
        let negative = self.is_negative(x);
        let away = if negative { Q::HALF.neg() } else { Q::HALF };
        let moved = self.graph.sum(away, &[(Q::ONE, x)]);
        if negative { self.ceiling(at, moved) } else { self.floor(at, moved) }
    }

    /// What truncated division by `period` leaves, with the sign of x.
    pub(super) fn remainder(&mut self, at: &impl ToTokens, x: Id, period: Id) -> Option<Id> {
        let turns = self.graph.div(x, period);
        let turns = self.truncated(at, turns)?;
        let whole = self.graph.mul(turns, period);
        Some(self.graph.sub(x, whole))
    }

    /// What division by `period` leaves, never negative.
    pub(super) fn rest(&mut self, at: &impl ToTokens, x: Id, period: Id) -> Option<Id> {
        // Whatever its sign, the rest is not negative.
        let period = self.absolute(period);
        let turns = self.graph.div(x, period);
        let turns = self.floor(at, turns)?;
        let whole = self.graph.mul(turns, period);
        Some(self.graph.sub(x, whole))
    }

    /// The integer that goes with [`Self::rest`].
    pub(super) fn turns(&mut self, at: &impl ToTokens, x: Id, period: Id) -> Option<Id> {
        let turns = self.graph.div(x, period);
        if self.is_negative(period) { self.ceiling(at, turns) } else { self.floor(at, turns) }
    }

    fn is_negative(&mut self, x: Id) -> bool {
        if self.graph.range(x).nonnegative() {
            return false;
        }
        // At zero all of these are continuous from the side that is taken.
        let known = !self.graph.has(x, UNKNOWNS) && self.graph.range(x).nonpositive();
        known || !self.decide(x, false)
    }
}
