//! Rounding down: a piece for each integer that the argument passes.

use quote::ToTokens;

use super::Test;
use super::body::Body;
use super::branch::{Asked, Unproven};
use crate::expr::{Id, Leaf, Node};
use crate::interval::Interval;
use crate::rational::Q;

/// `floor` is taken apart if its argument passes this many integers.
const MAX_STEPS: f64 = 16.0;

/// The integers that the argument of a `floor` passes.
#[derive(Clone, Copy, Debug)]
pub(super) struct Span {
    first: i64,
    last: i64,
    /// The parameter whose value is one more than the last of them, if it is a whole number.
    count: Option<Id>,
}

impl Body<'_> {
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
