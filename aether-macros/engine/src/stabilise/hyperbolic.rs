//! Inverse hyperbolic functions next to where they cancel with a number.

use crate::expr::{Fun, Graph, Id, Node};
use crate::rational::Q;

/// acosh(1 + s) as ln_1p(s + √s √(2 + s)).
pub(super) fn beside_one(g: &mut Graph, a: Id) -> Option<Id> {
    let Node::Sum(c, terms) = g.node(a).clone() else { return None };
    if c != Q::ONE {
        return None;
    }
    let (s, more) = (g.sum(Q::ZERO, &terms), g.sum(Q::int(2), &terms));
    let roots = [s, more].map(|x| g.sqrt(x));
    let root = g.mul(roots[0], roots[1]);
    let beyond = g.add(s, root);
    Some(g.call(Fun::Ln1p, &[beyond]))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::eval::evaluate;
    use crate::expr::Leaf;
    use crate::interval::Interval;
    use crate::stabilise::ends::one_minus;

    #[test]
    fn what_is_left_of_one_keeps_its_digits() {
        let mut g = Graph::new();
        let x = g.leaf(Leaf::Param(0), "x", Interval::ALL);
        let cosine = g.call(Fun::Cosh, &[x]);
        let gap = one_minus(&mut g, Q::int(-3), &[(Q::int(3), cosine)]).unwrap();
        let beside = g.sum(Q::ONE, &[(Q::ONE, x)]);
        let inverse = beside_one(&mut g, beside).unwrap();
        let at = |id, x: f64| evaluate(&g, id, &|_| x);
        for x in [1e-12, 1e-6, 0.1] {
            // The series of 3 (cosh(x) - 1) and of acosh(1 + x), to where the next terms are below rounding.
            let square = x * x;
            let terms = [1.0, 1.0 / 12.0, 1.0 / 360.0, 1.0 / 20_160.0, 1.0 / 1_814_400.0];
            let exact = 1.5 * terms.iter().rev().fold(0.0, |sum, t| sum * square + t) * square;
            assert!((at(gap, x) - exact).abs() <= 4.0 * f64::EPSILON * exact, "{x}");
            let back = at(inverse, x);
            let half = (0.5 * back).sinh();
            assert!((2.0 * half * half - x).abs() <= 8.0 * f64::EPSILON * x, "{x}");
        }
        assert!(one_minus(&mut g, Q::ONE, &[(Q::ONE, cosine)]).is_none());
        assert!(beside_one(&mut g, cosine).is_none());
    }
}
