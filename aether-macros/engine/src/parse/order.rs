//! What follows when one number is known to be larger than another.

use crate::expr::{Fun, Graph, Id, Node};
use crate::interval::Interval;
use crate::rational::Q;

/// Makes it known that an expression is not negative, and what follows for its parts.
pub(crate) fn assume_nonnegative(g: &mut Graph, difference: Id) {
    let negated = g.neg(difference);
    g.assume(difference, Interval::POSITIVE);
    g.assume(negated, Interval::new(f64::NEG_INFINITY, 0.0));
    let Node::Sum(c, terms) = g.node(difference).clone() else { return };
    let (above, below): (Vec<_>, Vec<_>) = terms.into_iter().partition(|(q, _)| !q.is_negative());
    let below: Vec<(Q, Id)> = below.into_iter().map(|(q, t)| (q.neg(), t)).collect();
    let (up, down) = if c.is_negative() { (Q::ZERO, c.neg()) } else { (c, Q::ZERO) };
    let (larger, smaller) = (g.sum(up, &above), g.sum(down, &below));
    assume_order(g, larger, smaller);
}

/// From X >= Y >= 0: X² - Y² is not negative, and Y / X at most one; from |x| >= |y|: y / x is within one.
pub(super) fn assume_order(g: &mut Graph, larger: Id, smaller: Id) {
    let zero = g.int(0);
    if larger == zero || smaller == zero {
        return;
    }
    if !(g.range(larger).nonnegative() && g.range(smaller).nonnegative()) {
        return;
    }
    let [above, below] = [larger, smaller].map(|side| g.powi(side, 2));
    for sign in [1, -1] {
        let squares = g.sum(Q::ZERO, &[(Q::int(sign), above), (Q::int(-sign), below)]);
        g.assume(squares, Interval::POSITIVE.scale(sign as f64));
    }
    let plain = |g: &Graph, id: Id| match g.node(id) {
        Node::Call(Fun::Abs, args) => (args[0], true),
        _ => (id, false),
    };
    let ((x, signed_x), (y, signed_y)) = (plain(g, larger), plain(g, smaller));
    let lowest = if signed_x || signed_y { -1.0 } else { 0.0 };
    // A sum and its negative are two expressions.
    for (sign_x, sign_y) in [(1, 1), (1, -1), (-1, 1), (-1, -1)] {
        let signed = |g: &mut Graph, sign, id| g.sum(Q::ZERO, &[(Q::int(sign), id)]);
        let (x, y) = (signed(g, sign_x, x), signed(g, sign_y, y));
        g.assume_quotient(y, x, Interval::new(lowest, 1.0).scale((sign_x * sign_y) as f64));
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::expr::Leaf;

    #[test]
    fn squares_and_quotients_of_numbers_in_order() {
        let mut g = Graph::new();
        let [r, d] =
            [0, 1].map(|i| g.leaf(Leaf::Out(i), ["r", "d"][i as usize], Interval::POSITIVE));
        let [r2, d2] = [r, d].map(|x| g.powi(x, 2));
        let (difference, squares, quotient) = (g.sub(d, r), g.sub(d2, r2), g.div(r, d));
        assert!(!g.range(squares).nonnegative());
        assume_nonnegative(&mut g, difference);
        assert!(g.range(squares).nonnegative());
        let opposite = g.neg(squares);
        assert!(g.range(opposite).nonpositive());
        assert!(g.range(quotient).hi <= 1.0);
    }
}
