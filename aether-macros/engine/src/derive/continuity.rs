//! Whether an expression is continuous in an unknown, and where it goes at the ends of [0, 1].

use crate::derivative::derivative;
use crate::eval::evaluate;
use crate::expr::{Fun, Graph, Id, Leaf, Node, leaf_bit};
use crate::interval::Interval;
use crate::jacobian::simplify;
use crate::number::{Dd, Number};
use crate::rational::Q;

use super::holding::never_negative;

/// Where an expression goes as an unknown goes to an end of [0, 1].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Limit {
    /// To what this is.
    At(Id),
    /// To -∞.
    Below,
    /// To +∞.
    Above,
}

impl Limit {
    /// The limit of the negative.
    fn negated(self) -> Limit {
        match self {
            Limit::Below => Limit::Above,
            Limit::Above => Limit::Below,
            at => at,
        }
    }
}

/// An end of [0, 1] that an unknown goes to.
#[derive(Clone, Copy, Debug)]
pub(super) struct Approach {
    /// The unknown.
    pub(super) unknown: Leaf,
    /// The end.
    pub(super) end: i64,
    /// Whether what the limit is asked of is known to be bounded.
    pub(super) bounded: bool,
}

/// What an expression is where an unknown is 0, and where it is 1.
pub(super) fn at_ends(g: &mut Graph, id: Id, unknown: Leaf) -> [Id; 2] {
    [0, 1].map(|end| at_end(g, id, Approach { unknown, end, bounded: false }))
}

fn at_end(g: &mut Graph, id: Id, at: Approach) -> Id {
    let u = g.get_leaf(at.unknown);
    let end = g.int(at.end);
    let there = g.substitute(id, &[(u, end)].into());
    let there = simplify(g, there, None);
    if g.deps(there) != 0 {
        return there;
    }
    // Of roots of numbers it takes their digits to see that they add up to an integer.
    let value = evaluate::<Dd>(g, there, &|_| Dd::from_f64(f64::NAN));
    let nearest = value.to_f64().round();
    let off = (value - Dd::from_f64(nearest)).to_f64().abs();
    if off < INTEGER && nearest.abs() < 1e3 { g.int(nearest as i64) } else { there }
}

/// A number that is as near to an integer as this, in double-double, is one.
const INTEGER: f64 = 1e-28;

/// The limit of an expression at an end, if that can be told.
pub(super) fn limit(g: &mut Graph, id: Id, at: Approach) -> Option<Limit> {
    if !g.has(id, leaf_bit(at.unknown)) {
        return Some(Limit::At(id));
    }
    match g.node(id).clone() {
        Node::Leaf(_) => Some(Limit::At(at_end(g, id, at))),
        Node::Sum(_, terms) => {
            let mut beyond = None;
            for (q, term) in terms {
                let there = limit(g, term, at)?;
                let there = if q.is_negative() { there.negated() } else { there };
                match (there, beyond) {
                    (Limit::At(_), _) => {}
                    (there, None) => beyond = Some(there),
                    (there, Some(other)) if there == other => {}
                    _ => return None,
                }
            }
            Some(beyond.unwrap_or_else(|| Limit::At(at_end(g, id, at))))
        }
        Node::Product(factors) => product(g, id, &factors, at),
        Node::Call(f, args) => {
            let Limit::At(inner) = limit(g, args[0], at)? else { return None };
            match (f, g.as_number(inner)) {
                (Fun::Ln, Some(Q::ZERO)) => Some(Limit::Below),
                (Fun::Ln1p, Some(q)) if q == Q::int(-1) => Some(Limit::Below),
                _ if args.len() == 1 => Some(Limit::At(at_end(g, id, at))),
                _ => None,
            }
        }
        _ => None,
    }
}

/// The limit of a product: infinite where a divisor vanishes or a factor is infinite, and none vanishes.
fn product(g: &mut Graph, id: Id, factors: &[(Id, Id)], at: Approach) -> Option<Limit> {
    let (mut sign, mut finite, mut vanishes) = (None, Vec::new(), false);
    for &(base, exponent) in factors {
        let e = g.as_number(exponent);
        match limit(g, base, at)? {
            Limit::At(b) if g.as_number(b) == Some(Q::ZERO) => match e.map(Q::is_negative) {
                Some(false) => vanishes = true,
                // It cannot divide what is bounded.
                None if at.bounded => vanishes = true,
                // From above.
                Some(true) if g.range(base).nonnegative() => sign = sign.or(Some(Limit::Above)),
                _ => return None,
            },
            Limit::At(_) => finite.push((base, exponent)),
            beyond if e == Some(Q::ONE) && sign.is_none() => sign = Some(beyond),
            _ => return None,
        }
    }
    let Some(sign) = sign else {
        return Some(Limit::At(if vanishes { g.int(0) } else { at_end(g, id, at) }));
    };
    let rest = g.product(&finite);
    let rest = at_end(g, rest, at);
    match g.range(rest) {
        _ if vanishes => None,
        range if range.lo > 0.0 => Some(sign),
        range if range.hi < 0.0 => Some(sign.negated()),
        _ => None,
    }
}

/// Whether an expression is continuous in an unknown between 0 and 1, at the ends as a limit that may be infinite.
pub(super) fn continuous(g: &mut Graph, id: Id, u: Leaf) -> bool {
    if !g.has(id, leaf_bit(u)) {
        return true;
    }
    match g.node(id).clone() {
        Node::Leaf(_) | Node::Number(_) | Node::Float(_) | Node::Pi => true,
        Node::Sum(_, terms) => terms.iter().all(|&(_, t)| continuous(g, t, u)),
        Node::Product(factors) => factors.iter().all(|&(base, e)| {
            if g.has(e, leaf_bit(u)) || !g.has(base, leaf_bit(u)) {
                return !g.has(e, leaf_bit(u));
            }
            let (whole, divides) = match g.as_number(e) {
                Some(q) => (q.is_int(), q.is_negative()),
                None => (false, true),
            };
            let exists = !divides || never_zero(g, base, u);
            let real = whole || g.range(base).nonnegative() || never_negative(g, base);
            exists && real && continuous(g, base, u)
        }),
        Node::Call(f, args) => {
            let range = g.range(args[0]);
            let within = match f {
                Fun::Exp | Fun::ExpM1 | Fun::Sin | Fun::Cos | Fun::Tanh | Fun::Atan => true,
                Fun::Abs | Fun::Cbrt | Fun::Asinh | Fun::SinPi | Fun::CosPi => true,
                // To -∞ at the least number that they take.
                Fun::Ln => range.lo >= 0.0,
                Fun::Ln1p => range.lo >= -1.0,
                _ => false,
            };
            within && args.iter().all(|&a| continuous(g, a, u))
        }
        Node::If(..) | Node::Root(_) => false,
    }
}

/// Whether an expression is proven to have one sign and no zero between 0 and 1: by its range, or because it is linear
/// in `u` and so at both ends.
fn never_zero(g: &mut Graph, id: Id, u: Leaf) -> bool {
    let signs = |range: Interval| (range.lo > 0.0, range.hi < 0.0);
    if signs(g.range(id)) != (false, false) || positive(g, id) {
        return true;
    }
    let slope = derivative(g, id, u);
    let slope = simplify(g, slope, None);
    let ends = at_ends(g, id, u).map(|there| signs(g.range(there)));
    !g.has(slope, leaf_bit(u)) && ends[0] == ends[1] && ends[0] != (false, false)
}

/// Whether an expression is positive wherever its inputs lie inside of their intervals, not at an end.
fn positive(g: &mut Graph, id: Id) -> bool {
    if g.range(id).lo > 0.0 {
        return true;
    }
    match g.node(id).clone() {
        Node::Leaf(_) => g.range(id).nonnegative(),
        Node::Sum(c, terms) => {
            // What is linear in one input has an end of its interval at an end of that of the input.
            let line = terms.len() == 1 && matches!(g.node(terms[0].1), Node::Leaf(_));
            let mut parts = terms.iter();
            line && g.range(id).nonnegative()
                || !c.is_negative() && parts.all(|&(q, t)| !q.is_negative() && positive(g, t))
                || terms.iter().any(|&(q, t)| q == Q::ONE && root_exceeds(g, t, id))
        }
        Node::Product(factors) => factors.iter().all(|&(base, _)| positive(g, base)),
        Node::Call(Fun::Cbrt, args) => positive(g, args[0]),
        Node::Call(Fun::Exp, _) => true,
        _ => false,
    }
}

/// Whether a term of a sum is a root that is larger than all others together, as in t + √(1 + t²).
fn root_exceeds(g: &mut Graph, root: Id, sum: Id) -> bool {
    if !matches!(g.node(root), Node::Product(f) if f.len() == 1 && g.as_number(f[0].1) == Some(Q::HALF))
    {
        return false;
    }
    let rest = g.sub(sum, root);
    let (square, rest) = (g.powi(root, 2), g.powi(rest, 2));
    let difference = g.sub(square, rest);
    let difference = simplify(g, difference, None);
    g.range(difference).lo > 0.0
}

#[cfg(test)]
mod tests {
    use super::*;

    fn uniform(g: &mut Graph) -> (Id, Leaf) {
        let leaf = Leaf::Unknown(0);
        (g.leaf(leaf, "u", Interval::new(0.0, 1.0)), leaf)
    }

    #[test]
    fn quantiles_go_to_infinity_where_their_divisors_vanish() {
        let mut g = Graph::new();
        let (u, leaf) = uniform(&mut g);
        let rest = g.sum(Q::ONE, &[(Q::int(-1), u)]);
        let top = g.sum(Q::int(-1), &[(Q::int(2), u)]);
        let approach = |end| Approach { unknown: leaf, end, bounded: false };
        let bottom = g.mul(u, rest);
        let bottom = g.sqrt(bottom);
        let student = g.div(top, bottom);
        assert_eq!(limit(&mut g, student, approach(0)), Some(Limit::Below));
        assert_eq!(limit(&mut g, student, approach(1)), Some(Limit::Above));
        assert!(continuous(&mut g, student, leaf));
        let logit = [(Fun::Ln, u), (Fun::Ln, rest)].map(|(f, x)| g.call(f, &[x]));
        let logit = g.sub(logit[0], logit[1]);
        assert_eq!(limit(&mut g, logit, approach(1)), Some(Limit::Above));
        // 0/0 is not told.
        let open = g.div(rest, bottom);
        let open = g.mul(open, logit);
        assert_eq!(limit(&mut g, open, approach(1)), None);
    }

    #[test]
    fn the_root_of_a_cubic_goes_from_one_pole_to_the_other() {
        let mut g = Graph::new();
        let (u, leaf) = uniform(&mut g);
        let b = g.sum(Q::int(-2), &[(Q::int(4), u)]);
        let square = g.powi(b, 2);
        let square = g.sum(Q::ONE, &[(Q::ONE, square)]);
        let root = g.sqrt(square);
        let sum = g.add(b, root);
        let t = g.call(Fun::Cbrt, &[sum]);
        let over = g.powi(t, -1);
        let z = g.sub(t, over);
        assert!(continuous(&mut g, z, leaf));
        let ends = at_ends(&mut g, z, leaf).map(|end| g.as_number(end));
        assert_eq!(ends, [Some(Q::int(-1)), Some(Q::ONE)]);
    }

    #[test]
    fn a_power_of_a_uniform_that_is_bounded_goes_to_zero() {
        let mut g = Graph::new();
        let (u, unknown) = uniform(&mut g);
        let e = g.leaf(Leaf::Param(0), "e", Interval::ALL);
        let power = g.pow(u, e);
        let zero = g.int(0);
        let at = Approach { unknown, end: 0, bounded: true };
        assert_eq!(limit(&mut g, power, at), Some(Limit::At(zero)));
        assert_eq!(limit(&mut g, power, Approach { bounded: false, ..at }), None);
    }

    #[test]
    fn a_pole_inside_is_no_limit() {
        let mut g = Graph::new();
        let (u, leaf) = uniform(&mut g);
        let p = g.leaf(Leaf::Param(0), "p", Interval::new(0.0, 1.0));
        let (gap, sum) = (g.sub(u, p), g.add(u, p));
        let (pole, tame) = (g.powi(gap, -1), g.powi(sum, -1));
        assert!(!continuous(&mut g, pole, leaf));
        assert!(continuous(&mut g, tame, leaf));
    }
}
