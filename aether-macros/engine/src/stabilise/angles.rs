//! Angles that are told by their tangent, and others that are added to them: next to a quarter turn, and where two
//! nearly equal ones are subtracted, an angle has fewer digits than its tangent.

use crate::expr::{Fun, Graph, Id, Node};
use crate::rational::Q;

/// The sine and cosine of an arc tangent, up to a positive factor; its cosine is positive where `forwards` is asked for.
fn sides(g: &mut Graph, arc: Id, forwards: bool) -> Option<(Id, Id)> {
    match *g.node(arc) {
        Node::Call(Fun::Atan, ref args) => {
            let y = args[0];
            Some((y, g.int(1)))
        }
        Node::Call(Fun::Atan2, ref args) => {
            let (y, x) = (args[0], args[1]);
            (!forwards || g.range(x).lo > 0.0).then_some((y, x))
        }
        _ => None,
    }
}

/// The sine, cosine or tangent of a sum, one term of which is an arc tangent, by what that one is made of.
pub(super) fn of_sum(g: &mut Graph, f: Fun, sum: Id) -> Option<Id> {
    let Node::Sum(c, terms) = g.node(sum).clone() else { return None };
    let is_arc = |g: &mut Graph, q: Q, t: Id| q.abs() == Q::ONE && sides(g, t, false).is_some();
    let Some(place) = (0..terms.len()).find(|&i| is_arc(g, terms[i].0, terms[i].1)) else {
        let started = mean(g, c, &terms)?;
        return of_sum(g, f, started);
    };
    let (sign, arc) = terms[place];
    let (y, x) = sides(g, arc, false)?;
    let y = g.sum(Q::ZERO, &[(sign, y)]);
    let mut others = terms;
    others.remove(place);
    let rest = g.sum(c, &others);
    if g.as_number(rest).is_some() {
        return None;
    }
    let turned = |g: &mut Graph, (p, q): (Id, Id), (r, s): (Id, Id), minus: bool| {
        let (a, b) = (g.mul(p, q), g.mul(r, s));
        if minus { g.sub(a, b) } else { g.add(a, b) }
    };
    if f == Fun::Tan {
        let (one, t) = (g.int(1), g.call(Fun::Tan, &[rest]));
        let top = turned(g, (y, one), (x, t), false);
        let bottom = turned(g, (x, one), (y, t), true);
        return Some(g.div(top, bottom));
    }
    let (sine, cosine) = (g.call(Fun::Sin, &[rest]), g.call(Fun::Cos, &[rest]));
    let top = match f {
        Fun::Sin => turned(g, (y, cosine), (x, sine), false),
        Fun::Cos => turned(g, (x, cosine), (y, sine), true),
        _ => return None,
    };
    let squares = turned(g, (x, x), (y, y), false);
    let length = g.sqrt(squares);
    Some(g.div(top, length))
}

/// A mean (1 - w) α + w β of two arc tangents, as α and a part of what is between them.
fn mean(g: &mut Graph, c: Q, terms: &[(Q, Id)]) -> Option<Id> {
    let [first, second] = *terms else { return None };
    let weighted = |g: &mut Graph, (q, term): (Q, Id)| {
        let is_arc = |g: &mut Graph, (b, e): (Id, Id)| {
            g.as_number(e) == Some(Q::ONE) && sides(g, b, true).is_some()
        };
        let arc = g.factors(term).into_iter().find(|&factor| is_arc(g, factor))?.0;
        let weight = g.div(term, arc);
        Some((arc, g.sum(Q::ZERO, &[(q, weight)])))
    };
    let ((a, v), (b, w)) = (weighted(g, first)?, weighted(g, second)?);
    let whole = g.add(v, w);
    if !c.is_zero() || g.as_number(whole) != Some(Q::ONE) {
        return None;
    }
    let between = difference(g, Q::ZERO, &[(Q::ONE, b), (Q::int(-1), a)])?;
    let part = g.mul(w, between);
    Some(g.add(a, part))
}

/// The difference of two arc tangents within a quarter turn of zero as one.
pub(super) fn difference(g: &mut Graph, c: Q, terms: &[(Q, Id)]) -> Option<Id> {
    let [(p, a), (q, b)] = *terms else { return None };
    if !c.is_zero() || p != q.neg() {
        return None;
    }
    let (y, x) = sides(g, a, true)?;
    let (v, w) = sides(g, b, true)?;
    let (yw, xv) = (g.mul(y, w), g.mul(x, v));
    let (xw, yv) = (g.mul(x, w), g.mul(y, v));
    let (sine, cosine) = (g.sub(yw, xv), g.add(xw, yv));
    let arc = g.call(Fun::Atan2, &[sine, cosine]);
    Some(g.sum(Q::ZERO, &[(p, arc)]))
}

/// The sum or difference of two cosines, or of two sines, times the same as a product: cos a - cos b is
/// 2 sin((a + b) / 2) sin((b - a) / 2).
pub(super) fn as_product(g: &mut Graph, c: Q, terms: &[(Q, Id)]) -> Option<Id> {
    let [(p, first), (q, second)] = *terms else { return None };
    if !c.is_zero() || p.abs() != q.abs() {
        return None;
    }
    let one = g.int(1);
    let mut split = |term: Id| {
        let factors = g.factors(term);
        let (call, f, angle) = factors.iter().find_map(|&(b, e)| match g.node(b) {
            Node::Call(f @ (Fun::Sin | Fun::Cos), args) if e == one => Some((b, *f, args[0])),
            _ => None,
        })?;
        Some((f, angle, g.div(term, call)))
    };
    let ((f, a, rest), (h, b, other)) = (split(first)?, split(second)?);
    if f != h || rest != other {
        return None;
    }
    let [half, minus] = [Q::HALF, Q::HALF.neg()];
    let mean = g.sum(Q::ZERO, &[(half, a), (half, b)]);
    let apart = g.sum(Q::ZERO, &[(half, a), (minus, b)]);
    let (of_mean, of_apart, sign) = match (f, p == q) {
        (Fun::Cos, true) => (Fun::Cos, Fun::Cos, Q::int(2)),
        (Fun::Cos, false) => (Fun::Sin, Fun::Sin, Q::int(-2)),
        (_, true) => (Fun::Sin, Fun::Cos, Q::int(2)),
        (_, false) => (Fun::Cos, Fun::Sin, Q::int(2)),
    };
    let (x, y) = (g.call(of_mean, &[mean]), g.call(of_apart, &[apart]));
    let product = g.mul(x, y);
    let whole = g.mul(product, rest);
    Some(g.sum(Q::ZERO, &[(sign.mul(p)?, whole)]))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::expr::Leaf;
    use crate::interval::Interval;

    #[test]
    fn sums_of_two_sines_or_cosines_are_products() {
        let mut g = Graph::new();
        let [a, b, k] = [0, 1, 2].map(|i| g.leaf(Leaf::Param(i), "a", Interval::ALL));
        let at = |leaf: Leaf| match leaf {
            Leaf::Param(0) => 0.7,
            Leaf::Param(1) => -1.9,
            _ => 3.0,
        };
        for f in [Fun::Sin, Fun::Cos] {
            let [x, y] = [a, b].map(|angle| g.call(f, &[angle]));
            let [x, y] = [x, y].map(|call| g.mul(call, k));
            for sign in [1, -1] {
                let terms = [(Q::int(2), x), (Q::int(2 * sign), y)];
                let sum = g.sum(Q::ZERO, &terms);
                let product = as_product(&mut g, Q::ZERO, &terms).unwrap();
                let [sum, product] = [sum, product].map(|id| crate::eval::evaluate(&g, id, &at));
                assert!((sum - product).abs() < 1e-14_f64, "{f:?} {sign}: {sum} {product}");
            }
            let other = g.mul(y, k);
            assert_eq!(as_product(&mut g, Q::ZERO, &[(Q::ONE, x), (Q::ONE, other)]), None);
        }
    }

    #[test]
    fn the_tangent_of_a_mean_of_two_angles_starts_from_one_of_them() {
        let mut g = Graph::new();
        let positive = Interval::new(1e-9, f64::INFINITY);
        let d = g.leaf(Leaf::Param(0), "d", positive);
        let [a, b] = [1, 2].map(|k| g.leaf(Leaf::Param(k), "a", Interval::ALL));
        let u = g.leaf(Leaf::Unknown(0), "u", Interval::new(0.0, 1.0));
        let rest = g.sum(Q::ONE, &[(Q::int(-1), u)]);
        let [first, second] = [a, b].map(|x| g.call(Fun::Atan2, &[x, d]));
        let (one, other) = (g.mul(first, rest), g.mul(second, u));
        let mean = g.add(one, other);
        let between = difference(&mut g, Q::ZERO, &[(Q::ONE, second), (Q::int(-1), first)]);
        let part = g.mul(u, between.unwrap());
        let written = g.add(first, part);
        let expected = of_sum(&mut g, Fun::Tan, written);
        assert!(expected.is_some());
        assert_eq!(of_sum(&mut g, Fun::Tan, mean), expected);
        // Weights that do not add up to one make no mean.
        let twice = g.add(other, mean);
        assert_eq!(of_sum(&mut g, Fun::Tan, twice), None);
    }
}
