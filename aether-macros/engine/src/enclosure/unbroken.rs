//! Whether expressions are continuous over a box, which a proof by the sign of a slope stands on: one over a
//! number falls on both sides of zero, and rises across it.

use super::{Exponent, Over, Step};
use crate::expr::{Fun, Graph, Id, Leaf, Node, children, leaf_bit};
use crate::hash::Set;
use crate::interval::Interval;

/// Whether an expression is made of a variable by functions that only [`Over::unbroken`] finds breaks of: no choices,
/// and no functions of several arguments.
pub fn is_plain(g: &Graph, id: Id, variable: Leaf) -> bool {
    let mut seen = Set::default();
    let mut open = vec![id];
    while let Some(id) = open.pop() {
        if !seen.insert(id) || !g.has(id, leaf_bit(variable)) {
            continue;
        }
        let plain = match g.node(id) {
            Node::If(..) => false,
            Node::Call(f, args) => args.len() == 1 && !matches!(f, Fun::Turn),
            Node::Root(r) => r.inside,
            _ => true,
        };
        if !plain {
            return false;
        }
        open.extend(children(g.node(id)));
    }
    true
}

impl Over<'_> {
    /// Whether all expressions of the enclosure are continuous inside of the box. At its ends they may be infinite.
    pub fn unbroken(&mut self) -> bool {
        let steps = &self.enclosure.steps;
        while self.values.len() < steps.len() {
            let value = self.value(&steps[self.values.len()]);
            self.values.push(value);
        }
        steps.iter().zip(&self.values).all(|(step, value)| match step {
            Step::Product(factors) => factors.iter().all(|(base, exponent)| {
                let divides = match exponent {
                    Exponent::Number(e) => *e < 0.0,
                    Exponent::Part(_) => false,
                };
                !divides || !straddles(self.values[*base])
            }),
            Step::Call(Fun::Sign, a) => !straddles(self.values[*a]),
            Step::Call(Fun::Tan, _) => *value != Interval::ALL,
            _ => true,
        })
    }
}

/// Whether zero lies inside.
fn straddles(i: Interval) -> bool {
    i.lo < 0.0 && i.hi > 0.0
}

#[cfg(test)]
mod tests {
    use super::super::Enclosure;
    use super::*;

    #[test]
    fn a_pole_and_a_kink_break_what_they_lie_in() {
        let mut g = Graph::new();
        let leaf = Leaf::Unknown(0);
        let u = g.leaf(leaf, "u", Interval::new(0.0, 1.0));
        let third = g.float(0.3);
        let away = g.sub(u, third);
        let (pole, size) = (g.powi(away, -2), g.call(Fun::Abs, &[away]));
        let kink = crate::derivative::derivative(&mut g, size, leaf);
        let tan = g.call(Fun::Tan, &[u]);
        let unbroken = |id: Id, lo: f64, hi: f64| {
            let region = [Interval::new(lo, hi)];
            Enclosure::new(&g, &[id], &[leaf]).over(&region).unbroken()
        };
        for id in [pole, kink] {
            assert!(!unbroken(id, 0.0, 1.0) && unbroken(id, 0.0, 0.3) && unbroken(id, 0.3, 1.0));
        }
        assert!(unbroken(size, 0.0, 1.0));
        assert!(unbroken(tan, 0.0, 1.0) && !unbroken(tan, 0.0, 2.0));
    }

    #[test]
    fn choices_are_not_plain() {
        let mut g = Graph::new();
        let leaf = Leaf::Unknown(0);
        let u = g.leaf(leaf, "u", Interval::new(-1.0, 1.0));
        let (square, cube) = (g.powi(u, 2), g.powi(u, 3));
        let chosen = g.if_positive(u, square, cube);
        assert!(is_plain(&g, cube, leaf) && !is_plain(&g, chosen, leaf));
        assert!(is_plain(&g, chosen, Leaf::Unknown(1)));
    }
}
