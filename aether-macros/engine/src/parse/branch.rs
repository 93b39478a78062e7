//! Branches: a body is read once for each way through its comparisons.
//!
//! A comparison that the ranges of the inputs settle has one outcome. Any other forks: the body is read
//! again with the other outcome. Every way through is a *piece*, a map without branches on the part of
//! the domain where its comparisons hold, and is solved by itself.

use std::collections::BTreeMap;

use quote::ToTokens;
use syn::{BinOp, Expr, ExprBinary, Ident};

use super::body::Body;
use super::order::{assume_both, assume_nonnegative, assume_order, follows};
use super::{Test, Value, proven};
use crate::expr::{Fun, Id, Leaf, Node, UNKNOWNS};
use crate::interval::Interval;
use crate::monotone::sign_at;
use crate::rational::Q;
use crate::walk::{self, Look};

/// A body may fall into this many pieces.
pub(super) const MAX_PIECES: usize = 32;
/// `floor` is taken apart if its argument passes this many integers.
const MAX_STEPS: f64 = 16.0;

/// The outcome of one comparison, and whether the other one is possible.
#[derive(Clone, Copy, Debug)]
struct Outcome {
    holds: bool,
    open: bool,
    /// Whether that is proven, so that no point has to be asked.
    proven: bool,
    /// Whether there is no point where it comes out otherwise.
    required: bool,
}

/// How a comparison is meant.
#[derive(Clone, Copy, Debug)]
pub(super) struct Asked {
    /// Whether it may come out either way; if not, it is known to hold for all points.
    open: bool,
    /// Whether either outcome is right where both numbers are equal.
    equal: bool,
    /// What to do without a proof.
    unproven: Unproven,
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

/// The integers that the argument of a `floor` passes.
#[derive(Clone, Copy, Debug)]
struct Span {
    first: i64,
    last: i64,
    /// The parameter whose value is one more than the last of them, if it is a whole number.
    count: Option<Id>,
}

/// One way through the comparisons of a body.
#[derive(Clone, Debug, Default)]
pub struct Way {
    outcomes: Vec<Outcome>,
    position: usize,
    /// Tests that are implied by the ranges of this reading's inputs, by their place.
    implied: Vec<usize>,
    /// What has to hold for a point to take this way, with the place of the comparison.
    pub(super) tests: Vec<(usize, Test)>,
    /// Comparisons made on this reading: difference, whether strict, and the outcome.
    made: Vec<(Id, bool, bool)>,
    /// What each `floor` passes, by the place of its first comparison and the number of those before it, of which some make no
    /// comparison: later readings know more of its argument, and have to make the same comparisons.
    spans: BTreeMap<(usize, usize), Span>,
    /// How many there were on this reading.
    floors: usize,
    /// What follows for the parameters if any point takes this way.
    pub(super) existence: Vec<Test>,
    /// Whether a comparison was found to have the other outcome wherever this way leads.
    pub(super) impossible: bool,
    /// What is zero wherever this way leads, by a comparison that holds nowhere else.
    pub(super) zeros: Vec<Id>,
    /// Parameters that are zero wherever this way leads.
    pub(super) vanishing: Vec<Leaf>,
}

impl Way {
    /// The same way again, from the start, where some of the tests need not be made.
    pub(super) fn again(&self, implied: Vec<usize>) -> Way {
        Way {
            outcomes: self.outcomes.clone(),
            implied,
            spans: self.spans.clone(),
            vanishing: self.vanishing.clone(),
            ..Way::default()
        }
    }

    /// Whether it has led through no comparison that may come out otherwise.
    pub(super) fn is_straight(&self) -> bool {
        self.outcomes.is_empty()
    }

    /// The next way, in the order of a depth-first search; `None` after the last.
    pub(super) fn next(mut self) -> Option<Way> {
        while let Some(last) = self.outcomes.pop() {
            if last.open && last.holds {
                let place = self.outcomes.len();
                self.outcomes.push(Outcome {
                    holds: false,
                    open: false,
                    proven: false,
                    required: false,
                });
                self.spans.retain(|(begin, _), _| *begin <= place);
                return Some(self.again(vec![]));
            }
        }
        None
    }
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

    fn compare(&mut self, difference: Id, strict: bool, asked: Asked) -> bool {
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

    /// The value of a comparison or of a logical operator; `None` if the operator is neither.
    pub(super) fn logic(&mut self, b: &ExprBinary) -> Option<Option<Value>> {
        let strict = match b.op {
            BinOp::Lt(_) | BinOp::Gt(_) => true,
            BinOp::Le(_) | BinOp::Ge(_) => false,
            BinOp::And(_) | BinOp::Or(_) => return Some(self.short_circuit(b)),
            BinOp::Eq(_) | BinOp::Ne(_) => {
                let values = self.expr(&b.left).zip(self.expr(&b.right));
                let (left, right) = match values {
                    Some(values) => values,
                    None => return Some(None),
                };
                if let Some(equal) = self.equal(&left, &right) {
                    return Some(Some(Value::Bool(equal == matches!(b.op, BinOp::Eq(_)))));
                }
                return Some(self.error(b, "real numbers are equal with probability zero: compare with `<`, `<=`, `>` or `>=`"));
            }
            _ => return None,
        };
        Some(self.comparison(b, strict))
    }

    /// What a declared relation between parameters says, made known to the graph.
    pub(super) fn relate(&mut self, b: &ExprBinary) -> Option<Test> {
        let strict = matches!(b.op, BinOp::Lt(_) | BinOp::Gt(_));
        let mut unknown = UnknownNames { known: &self.names, found: vec![], sampled: vec![] };
        [&b.left, &b.right].into_iter().for_each(|side| walk::expr(&mut unknown, side));
        if let Some(name) = unknown.sampled.first().cloned() {
            return self.error(&name, format!("a relation is between parameters, and `{name}` is what is sampled: write it as a branch of the body"));
        }
        if let Some(name) = unknown.found.first().cloned() {
            return self.error(&name, format!("`{name}` is no parameter, and a relation is between the parameters of the function: add it to them, or write its value"));
        }
        let (larger, smaller, _) = self.operands(b)?;
        let difference = self.graph.sub(larger, smaller);
        if self.graph.has(difference, UNKNOWNS) {
            return self.error(b, "a relation is between parameters: this one depends on what is sampled; write it as a branch of the body");
        }
        assume_nonnegative(&mut self.graph, difference);
        self.declared.push(Test { difference, strict });
        Some(Test { difference, strict })
    }

    fn comparison(&mut self, b: &ExprBinary, strict: bool) -> Option<Value> {
        let (larger, smaller, whole) = self.operands(b)?;
        Some(Value::Bool(match whole {
            true => self.whole_exceeds(larger, smaller, strict),
            false => self.exceeds(larger, smaller, strict),
        }))
    }

    /// Whether one number is larger than another on this way, or as large if not strict.
    pub(super) fn exceeds(&mut self, larger: Id, smaller: Id, strict: bool) -> bool {
        let difference = self.graph.sub(larger, smaller);
        let holds = self.decide(difference, strict);
        // The difference may no longer show what was compared.
        let (larger, smaller) = if holds { (larger, smaller) } else { (smaller, larger) };
        assume_order(&mut self.graph, larger, smaller);
        holds
    }

    /// What is larger and what is smaller if the comparison holds, and whether both are integers.
    fn operands(&mut self, b: &ExprBinary) -> Option<(Id, Id, bool)> {
        // Inside a comparison the size of a number is a number like any other.
        let outer = std::mem::replace(&mut self.comparing, true);
        let (left, right) = (self.expr(&b.left), self.expr(&b.right));
        self.comparing = outer;
        let (left, right) = (left?, right?);
        let whole = matches!((&left, &right), (Value::Integer(_), Value::Integer(_)));
        let (left, right) = match (left.real(), right.real()) {
            (Value::Scalar(left), Value::Scalar(right)) => (left, right),
            (Value::Vector(_) | Value::Point(..), _) | (_, Value::Vector(_) | Value::Point(..)) => {
                return self.error(b, "vectors have no order: compare coordinates, `a.x < b.x`, or lengths, `a.length() < b.length()`");
            }
            (left, right) => {
                let (left, right) = (left.describe(), right.describe());
                return self.error(
                    b,
                    format!("numbers are compared, and this compares {left} with {right}"),
                );
            }
        };
        Some(match b.op {
            BinOp::Lt(_) | BinOp::Le(_) => (right, left, whole),
            _ => (left, right, whole),
        })
    }

    fn short_circuit(&mut self, b: &ExprBinary) -> Option<Value> {
        let left = self.truth(&b.left)?;
        if left == matches!(b.op, BinOp::Or(_)) {
            return Some(Value::Bool(left));
        }
        self.truth(&b.right).map(Value::Bool)
    }

    /// The value of an expression that must be a truth value.
    pub(super) fn truth(&mut self, e: &Expr) -> Option<bool> {
        if let Expr::Let(test) = e {
            let value = self.expr(&test.expr)?;
            return self.fits(&test.pat, &value);
        }
        match self.expr(e)? {
            Value::Bool(b) => Some(b),
            Value::Unit if self.left() => Some(false),
            other => {
                let what = other.describe();
                self.error(e, format!("a comparison is needed here, and this is {what}"))
            }
        }
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

    /// The largest integer not above x, as a number: a piece for each integer that x passes.
    pub(super) fn floor(&mut self, at: &impl ToTokens, x: Id) -> Option<Id> {
        let own = (self.way.position, self.way.floors);
        self.way.floors += 1;
        let Span { first, last, count } = match self.way.spans.get(&own) {
            Some(span) => *span,
            None => {
                let range = self.graph.range(x);
                if !range.width().is_finite() || range.width() > MAX_STEPS {
                    return self.error(at, "this jumps at every integer, and how many its argument passes is not known (or too many): declare the domains of the parameters, as in `#[sampler(k in 1.0..=8.0)]`");
                }
                let (first, last) = (libm::floor(range.lo) as i64, libm::ceil(range.hi) as i64 - 1);
                let span = Span { first, last, count: self.steps(x) };
                self.way.spans.insert(own, span);
                span
            }
        };
        let last = last.max(first);
        // A whole number of steps ends the last one, too.
        let end = if count.is_some() { last + 1 } else { last };
        let found = (first..end).find(|&k| {
            let above = self.graph.int(k + 1);
            let difference = self.graph.sub(above, x);
            self.compare(
                difference,
                true,
                Asked { open: k < last, equal: false, unproven: Unproven::Fork },
            )
        });
        let found = found.unwrap_or(last);
        if let Some(count) = count {
            self.exceed(count, found);
        }
        Some(self.graph.int(found))
    }

    /// The parameter n if x is n u for a uniform u: below one, it leads to integers below n.
    fn steps(&mut self, x: Id) -> Option<Id> {
        let whole = self.whole.clone();
        whole.into_iter().find(|&n| {
            let u = self.graph.div(x, n);
            matches!(self.graph.node(u), Node::Leaf(Leaf::Unknown(_)))
                && self.graph.range(u) == Interval::new(0.0, 1.0)
        })
    }

    /// Makes it known that a whole number exceeds another one wherever this way leads.
    fn exceed(&mut self, count: Id, found: i64) {
        let least = (found + 1) as f64;
        let g = &mut self.graph;
        if g.range(count).lo >= least {
            return;
        }
        let difference = g.sum(Q::int(-found - 1), &[(Q::ONE, count)]);
        self.way.existence.push(Test { difference, strict: false });
        g.assume(count, Interval::new(least, f64::INFINITY));
    }
}

/// Finds names that nothing is known of (those in capitals are constants), and uniforms.
struct UnknownNames<'n> {
    known: &'n std::collections::HashMap<String, Value>,
    found: Vec<Ident>,
    /// Names of arrays of uniforms.
    sampled: Vec<Ident>,
}

impl Look for UnknownNames<'_> {
    fn path(&mut self, path: &syn::ExprPath) -> bool {
        if let Some(name) = path.path.get_ident() {
            let text = name.to_string();
            if let Some(Value::Uniforms(_)) = self.known.get(&text) {
                self.sampled.push(name.clone());
            }
            if !self.known.contains_key(&text) && text.chars().any(char::is_lowercase) {
                self.found.push(name.clone());
            }
        }
        false
    }

    // The name of a function is none of a parameter.
    fn expr(&mut self, expr: &Expr) -> bool {
        let Expr::Call(call) = expr else { return true };
        call.args.iter().for_each(|argument| walk::expr(self, argument));
        false
    }
}

/// What a range says of `x > 0`, or of `x >= 0`.
fn settled(range: Interval, strict: bool) -> Option<bool> {
    let (holds, fails) =
        if strict { (range.lo > 0.0, range.hi <= 0.0) } else { (range.lo >= 0.0, range.hi < 0.0) };
    (holds || fails).then_some(holds)
}

#[cfg(test)]
mod tests {
    use crate::interpret::Item;

    fn steps(domain: &str) -> Result<Item, String> {
        let body = "{ let k = (n * u[0]).floor(); k + (n * u[0] - k) * (n * u[0] - k) }";
        let text = format!("fn steps(u: [Uniform; 1], n: f64) -> f64 {body}");
        Item::new(domain.parse().unwrap(), text.parse().unwrap(), true)
    }

    #[test]
    fn a_whole_number_of_steps_has_as_many_pieces() {
        let item = steps("n in 2..=4").unwrap();
        for n in [2.0, 3.0, 4.0] {
            for u in [0.1_f64, 0.3, 0.6, 0.9] {
                let k = (n * u).floor();
                let x = k + (n * u - k).powi(2);
                assert!((item.forward(&[n], &[u]).unwrap()[0] - x).abs() < 1e-15);
                let expected = 1.0 / (2.0 * (n * u - k) * n);
                let found = item.pdf(&[n], &[x]);
                assert!((found / expected - 1.0).abs() < 1e-12, "{n} {u}: {found} {expected}");
            }
            // There is no step beyond the last.
            assert_eq!(item.pdf(&[n], &[n + 0.25]), 0.0);
        }
    }

    /// A `floor` of what stays below one compares nothing, and one after it is none the less of its own argument.
    #[test]
    fn each_floor_is_that_of_its_own_argument() {
        let text = "fn f(u: [Uniform; 1]) -> f64 { (0.5 * u[0]).floor() + (3.0 * u[0]).fract() }";
        let item = Item::new("".parse().unwrap(), text.parse().unwrap(), true).unwrap();
        for u in [0.1_f64, 0.5, 0.9] {
            let x = (3.0 * u).fract();
            assert!((item.forward(&[], &[u]).unwrap()[0] - x).abs() < 1e-15);
            assert!((item.pdf(&[], &[x]) - 1.0).abs() < 1e-12);
            assert_eq!(item.preimages(&[], &[x]).len(), 3);
        }
    }

    #[test]
    fn too_many_steps_are_refused() {
        assert!(steps("n in 2..=17").is_err_and(|e| e.contains("jumps at every integer")));
        assert!(steps("n in 2..").is_err_and(|e| e.contains("jumps at every integer")));
    }
}
