//! Branches: a body is read once for each way through its comparisons.
//!
//! A comparison that the ranges of the inputs settle has one outcome. Any other forks: the body is read
//! again with the other outcome. Every way through is a *piece*, a map without branches on the part of
//! the domain where its comparisons hold, and is solved by itself.

use super::body::Body;
use super::order::{assume_both, assume_nonnegative, follows};
use super::way::Outcome;
use super::{Test, Value, proven};
use crate::expr::{Fun, Id, UNKNOWNS};
use crate::interval::Interval;
use crate::monotone::sign_at;

/// How a comparison is meant.
#[derive(Clone, Copy, Debug)]
pub(super) struct Asked {
    /// Whether it may come out either way; if not, it is known to hold for all points.
    pub(super) open: bool,
    /// Whether either outcome is right where both numbers are equal.
    pub(super) equal: bool,
    /// What to do without a proof.
    pub(super) unproven: Unproven,
}

/// What becomes of a comparison whose outcome is not proven.
#[derive(Clone, Copy, Debug)]
pub(super) enum Unproven {
    /// Both outcomes are followed.
    Fork,
    /// There is no point where the outcome is not this one, if it is seen to be so at as many points.
    Bound {
        /// The outcome.
        holds: bool,
        /// How many points are looked at.
        points: u32,
        /// Whether that must be asked of a point, as no function is undefined beyond.
        asked: bool,
    },
}

impl Body<'_> {
    /// What an earlier comparison of the same two numbers says of this one.
    fn repeated(&mut self, difference: Id, strict: bool) -> Option<bool> {
        let negated = self.graph.neg(difference);
        let declared = self.declared.iter().map(|test| (test.difference, test.strict, true));
        self.way.made.iter().copied().chain(declared).find_map(|(made, was_strict, held)| {
            if made == difference && (was_strict == strict || held == was_strict) {
                Some(held)
            } else if made == negated && (was_strict != strict || held == was_strict) {
                Some(!held)
            } else {
                None
            }
        })
    }

    /// Whether `difference > 0` (`>= 0` if not strict) on this way.
    pub(super) fn decide(&mut self, difference: Id, strict: bool) -> bool {
        let asked = Asked { open: true, equal: false, unproven: Unproven::Fork };
        self.compare(difference, strict, asked)
    }

    /// How many comparisons there were so far.
    pub(super) fn comparisons(&self) -> usize {
        self.way.position
    }

    /// Whether `difference > 0`, as the comparison in this place, whether or not those before it were made.
    pub(super) fn decide_at(&mut self, place: usize, difference: Id) -> bool {
        let none = Outcome { holds: true, open: false, proven: false, required: false };
        self.way.outcomes.resize(self.way.outcomes.len().max(place), none);
        self.way.position = place;
        self.decide(difference, true)
    }

    pub(super) fn compare(&mut self, difference: Id, strict: bool, asked: Asked) -> bool {
        let repeated = self.repeated(difference, strict);
        let settled = repeated.or_else(|| settled(self.graph.range(difference), strict));
        let settled = settled.or_else(|| {
            let known = self.known_here();
            follows(&self.graph, difference, &known)
        });
        let place = self.way.position;
        self.way.position += 1;
        let outcome = match self.way.outcomes.get(place) {
            Some(outcome) => *outcome,
            None => {
                let known = settled.is_some() || !asked.open;
                let proven = if known { None } else { self.proven(difference, strict, asked) };
                let (proven, required) = match (proven, asked.unproven) {
                    (None, Unproven::Bound { holds, points, asked }) if !known => {
                        let known = self.known_here();
                        let seen = sign_at(&self.graph, difference, points, &known);
                        let seen = seen.map(|sign| sign > 0);
                        (seen.filter(|seen| *seen == holds), asked)
                    }
                    (proven, _) => (proven, false),
                };
                let open = !known && proven.is_none();
                let holds = settled.or(proven).unwrap_or(true);
                let (proven, required) = (proven.is_some(), proven.is_some() && required);
                let outcome = Outcome { holds, open, proven, required };
                self.way.outcomes.push(outcome);
                outcome
            }
        };
        self.way.impossible |= settled.is_some_and(|holds| holds != outcome.holds);
        self.way.made.push((difference, strict, outcome.holds));
        if settled.is_none() {
            let g = &mut self.graph;
            let difference = if outcome.holds { difference } else { g.neg(difference) };
            if outcome.required {
                self.requirements.push(difference);
            } else if g.range(difference).nonpositive() {
                self.way.zeros.push(difference);
            }
            assume_nonnegative(g, difference);
            for &(made, _, held) in &self.way.made {
                let made = if held { made } else { g.neg(made) };
                if made != difference {
                    assume_both(g, made, difference);
                }
            }
            if !outcome.proven && !self.way.implied.contains(&place) {
                let strict = strict == outcome.holds;
                self.way.tests.push((place, Test { difference, strict }));
            }
        }
        outcome.holds
    }

    /// What is not negative on the way so far.
    pub(super) fn known_here(&mut self) -> Vec<Id> {
        let Self { way, declared, graph: g, .. } = self;
        let made = way.made.iter().map(|&(difference, _, holds)| (difference, holds));
        let all = made.chain(declared.iter().map(|test| (test.difference, true)));
        all.map(|(id, holds)| if holds { id } else { g.neg(id) }).collect()
    }

    /// What is proven of a comparison that ranges do not settle.
    fn proven(&self, difference: Id, strict: bool, asked: Asked) -> Option<bool> {
        let positive = proven::sign(&self.graph, difference)? > 0;
        // Where both numbers are equal, which may be somewhere, only one outcome is right.
        (asked.equal || strict != positive).then_some(positive)
    }

    /// `if condition { … } else { … }`.
    pub(super) fn branch(&mut self, e: &syn::ExprIf) -> Option<Value> {
        // What a pattern of the condition binds is known in its block.
        let taken = self.scoped(|body| {
            let holds = body.truth(&e.cond)?;
            if body.left() {
                return Some(Some(Value::Unit));
            }
            Some(if holds { Some(body.block(&e.then_branch)?) } else { None })
        })?;
        if taken.is_some() {
            return taken;
        }
        match &e.else_branch {
            Some((_, other)) => self.expr(other),
            None => Some(Value::Unit),
        }
    }

    /// |x|, as x or -x.
    pub(super) fn absolute(&mut self, x: Id) -> Id {
        if self.comparing || !self.graph.has(x, UNKNOWNS) {
            return self.graph.call(Fun::Abs, &[x]);
        }
        if self.decide(x, false) { x } else { self.graph.neg(x) }
    }

    /// The smaller (or larger) of two numbers.
    pub(super) fn extremum(&mut self, a: Id, b: Id, smaller: bool) -> Id {
        self.extremum_or(a, b, smaller, Unproven::Fork)
    }

    /// The same where it is known what to do without a proof.
    pub(super) fn extremum_or(&mut self, a: Id, b: Id, smaller: bool, unproven: Unproven) -> Id {
        let difference = self.graph.sub(b, a);
        // Of equal numbers either will do.
        let asked = Asked { open: true, equal: true, unproven };
        if self.compare(difference, true, asked) == smaller { a } else { b }
    }

    /// One with the sign of x.
    pub(super) fn signum(&mut self, x: Id) -> Id {
        let positive = self.decide(x, false);
        self.graph.int(if positive { 1 } else { -1 })
    }
}

/// What a range says of `x > 0`, or of `x >= 0`.
fn settled(range: Interval, strict: bool) -> Option<bool> {
    let (holds, fails) =
        if strict { (range.lo > 0.0, range.hi <= 0.0) } else { (range.lo >= 0.0, range.hi < 0.0) };
    (holds || fails).then_some(holds)
}
