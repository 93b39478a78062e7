//! What follows when one number is known to be larger than another.

use crate::expr::{Fun, Graph, Id, Node, UNKNOWNS};
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

/// From two differences that are not negative, a + b and a - b: a is not negative, and b / a within one.
pub(super) fn assume_both(g: &mut Graph, first: Id, second: Id) {
    let [half, minus] = [Q::HALF, Q::HALF.neg()];
    let middle = g.sum(Q::ZERO, &[(half, first), (half, second)]);
    let beside = g.sum(Q::ZERO, &[(half, first), (minus, second)]);
    // Any two differences can be written so; it tells something where parts of them cancel.
    let [whole, a, b] = [first, middle, beside].map(|id| g.deps(id) & UNKNOWNS);
    let parts = a != 0 && b != 0 && a & b == 0 && a | b == whole;
    if parts && g.deps(second) & UNKNOWNS == whole {
        g.assume(middle, Interval::POSITIVE);
        assume_quotients(g, beside, middle, Interval::new(-1.0, 1.0));
    }
}

/// From X >= Y >= 0: X² - Y² is not negative, and Y / X at most one; from |x| >= |y| and x² >= y²: y / x is within one.
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
    if let (Some(x), Some(y)) = (g.square_of(larger), g.square_of(smaller)) {
        assume_quotients(g, y, x, Interval::new(-1.0, 1.0));
    }
    let plain = |g: &Graph, id: Id| match g.node(id) {
        Node::Call(Fun::Abs, args) => (args[0], true),
        _ => (id, false),
    };
    let ((x, signed_x), (y, signed_y)) = (plain(g, larger), plain(g, smaller));
    let lowest = if signed_x || signed_y { -1.0 } else { 0.0 };
    assume_quotients(g, y, x, Interval::new(lowest, 1.0));
}

/// Makes the range of y / x known, and with it those of the negatives, as a sum and its negative are two expressions.
fn assume_quotients(g: &mut Graph, y: Id, x: Id, range: Interval) {
    for (sign_x, sign_y) in [(1, 1), (1, -1), (-1, 1), (-1, -1)] {
        let signed = |g: &mut Graph, sign, id| g.sum(Q::ZERO, &[(Q::int(sign), id)]);
        let (x, y) = (signed(g, sign_x, x), signed(g, sign_y, y));
        g.assume_quotient(y, x, range.scale((sign_x * sign_y) as f64));
    }
}

/// Of so many differences in order more are not added up, and of more that are known nothing is.
const MOST_ADDED: usize = 3;
const MOST_KNOWN: usize = 16;

/// Whether a difference is positive where others are not negative: of a > b and b > c follows a > c. Where it is zero, all that
/// add up to it are.
pub(super) fn follows(g: &Graph, difference: Id, known: &[Id]) -> Option<bool> {
    if !(2..=MOST_KNOWN).contains(&known.len()) || g.deps(difference) & UNKNOWNS == 0 {
        return None;
    }
    // Of what is tried nothing is to be left in the graph, as the order of sums follows that in which parts came.
    let mut g = g.clone();
    let opposite = g.neg(difference);
    let mut is_sum = |wanted| adds_up(&mut g, wanted, known, MOST_ADDED);
    if is_sum(difference) {
        Some(true)
    } else if is_sum(opposite) {
        Some(false)
    } else {
        None
    }
}

/// Whether an expression is a sum of some that are not negative, and of what is not negative by its range.
fn adds_up(g: &mut Graph, wanted: Id, known: &[Id], most: usize) -> bool {
    let terms = |g: &Graph, id: Id| match g.node(id) {
        Node::Sum(_, terms) => terms.len(),
        _ => 1,
    };
    g.range(wanted).nonnegative()
        || most > 0
            && known.iter().any(|&part| {
                let rest = g.sub(wanted, part);
                // What it does not have in common with the sum would have to be in others.
                terms(g, rest) <= terms(g, wanted) && adds_up(g, rest, known, most - 1)
            })
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

    #[test]
    fn what_follows_from_two_comparisons() {
        let mut g = Graph::new();
        let [a, b, c] = [0, 1, 2].map(|i| g.leaf(Leaf::Unknown(i), "u", Interval::new(-1.0, 1.0)));
        let (first, second, third) = (g.sub(a, b), g.sub(b, c), g.sub(a, c));
        let back = g.sub(c, a);
        assert_eq!(follows(&g, third, &[first, second]), Some(true));
        assert_eq!(follows(&g, back, &[first, second]), Some(false));
        assert_eq!(follows(&g, second, &[first, third]), None);
    }

    #[test]
    fn squares_in_order_and_two_differences_tell_of_quotients() {
        let mut g = Graph::new();
        let made = [0, 1, 2, 3].map(|i| g.leaf(Leaf::Unknown(i), "u", Interval::new(-1.0, 1.0)));
        let [a, b, c, d] = made;
        let (within, either) = (Interval::new(-1.0, 1.0), Interval::ALL);
        let quotients = [g.div(b, a), g.div(d, c), g.div(a, b)];
        let (a2, b2) = (g.powi(a, 2), g.powi(b, 2));
        let squares = g.sub(a2, b2);
        assume_nonnegative(&mut g, squares);
        let [first, second, back] = quotients;
        assert_eq!([first, second, back].map(|id| g.range(id)), [within, either, either]);
        let (sum, difference) = (g.add(c, d), g.sub(c, d));
        assume_both(&mut g, sum, difference);
        assert!(g.range(c).nonnegative() && !g.range(d).nonnegative());
        assert_eq!(g.range(second), within);
    }
}
