//! Conditions that hold wherever a point can be: that 1 + g² - 2 g z is not negative is no test of a direction,
//! and the unknown behind its height is no test where the heights of samples go from pole to pole.
//!
//! A test that cannot fail in exact arithmetic fails by rounding: where g is next to one, all digits of that sum
//! are lost, and an own sample has no density.

use crate::derivative::derivative;
use crate::expr::{Fun, Graph, Id, Leaf, Node, OUTS, UNKNOWNS, leaf_bit};
use crate::jacobian::simplify;
use crate::poly::Expander;
use crate::rational::Q;
use crate::solve::Solution;

use super::continuity::{at_ends, continuous};
use super::{Preimage, Problem};

/// Whether an expression is proven not to be negative: by its range, by its factors, or because it is linear
/// in a coordinate between two ends, at which it is not.
pub(super) fn never_negative(g: &mut Graph, id: Id) -> bool {
    proven(g, id, 3)
}

/// The conditions of each solution by which it excludes another one, where those of the other ask for the opposite
/// sign: as plain as a sign can be told.
pub(super) fn opposed(g: &mut Graph, solutions: &[Solution]) -> Vec<Vec<Id>> {
    let conditions: Vec<Vec<Id>> =
        solutions.iter().map(|s| s.conditions.iter().map(|c| sign(g, c.0)).collect()).collect();
    let mut kept = conditions.clone();
    for (i, own) in kept.iter_mut().enumerate() {
        own.retain(|&c| {
            let opposite = g.neg(c);
            conditions.iter().enumerate().any(|(j, others)| j != i && others.contains(&opposite))
        });
    }
    kept
}

/// The signs that coordinates have under a piece of a map of which more than ends of unknowns decides: what is next to a border
/// may lead back from its other side, to within rounding.
pub(super) fn sides(problem: &mut Problem, targets: &[Id]) -> Vec<Id> {
    if problem.guards.is_empty() {
        return Vec::new();
    }
    let g = &mut problem.graph;
    let signed = |(&output, &x): (&Id, &Id)| match g.range(output) {
        range if range.nonnegative() => Some(x),
        range if range.hi <= 0.0 => Some(g.neg(x)),
        _ => None,
    };
    problem.outputs.iter().zip(targets).filter_map(signed).collect()
}

/// Adds to the conditions of a sampler's preimage that unknowns have values where these, whatever they are, need no test: as
/// 1/2 + √(1 - y²) / 2 does for |y| up to one alone.
pub(super) fn ask_for_values(problem: &mut Problem, preimage: &mut Preimage) {
    if problem.argument.is_some() || !problem.guards.is_empty() {
        return;
    }
    let g = &mut problem.graph;
    let untested = preimage.tested.iter().copied().filter(|&u| g.range(u).within_one());
    let untested: Vec<Id> = untested.collect();
    // Where nothing at all is tested, it is where the map stays.
    if untested.len() == preimage.tested.len() && preimage.conditions.is_empty() {
        return;
    }
    for unknown in untested {
        for part in g.within(&[unknown]) {
            for asked in not_negative(g, part) {
                let known = preimage.conditions.contains(&asked) || never_negative(g, asked);
                if g.has(asked, OUTS) && !known {
                    preimage.conditions.push(asked);
                    preimage.open.push(asked);
                }
            }
        }
    }
}

/// What must not be negative for a function of it to have a value.
fn not_negative(g: &mut Graph, id: Id) -> Vec<Id> {
    match g.node(id).clone() {
        Node::Product(factors) => {
            let is_root = |e: Id| g.as_number(e).is_none_or(|e| e.den() % 2 == 0);
            factors.into_iter().filter(|(_, e)| is_root(*e)).map(|(base, _)| base).collect()
        }
        Node::Call(Fun::Asin | Fun::Acos, args) => {
            let square = g.powi(args[0], 2);
            vec![g.sum(Q::ONE, &[(Q::int(-1), square)])]
        }
        _ => vec![],
    }
}

/// An expression without what does not change its sign: ±b for ±a b³ / c², where a is positive.
fn sign(g: &mut Graph, id: Id) -> Id {
    let (q, body) = g.split(id);
    let mut factors = g.factors(body);
    factors.retain(|&(base, e)| {
        let even = g.as_number(e).is_some_and(Q::is_even);
        !even && !g.range(base).nonnegative()
    });
    let one = g.int(1);
    for (_, e) in &mut factors {
        if g.as_number(*e).is_some_and(Q::is_int) {
            *e = one;
        }
    }
    let plain = g.product(&factors);
    if q.is_negative() { g.neg(plain) } else { plain }
}

fn proven(g: &mut Graph, id: Id, depth: u8) -> bool {
    if g.range(id).nonnegative() {
        return true;
    }
    let (q, body) = g.split(id);
    if matches!(g.node(body), Node::Product(_)) {
        let mut negative = q.is_negative();
        for (base, e) in g.factors(body) {
            let whole = g.as_number(e).filter(|e| e.is_int());
            // Other powers of what is negative are no numbers.
            if whole.is_some_and(|e| e.num() % 2 != 0) && !proven(g, base, depth) {
                let opposite = g.neg(base);
                if !proven(g, opposite, depth) {
                    return false;
                }
                negative = !negative;
            }
        }
        return !negative;
    }
    depth > 0 && (0..3).any(|k| between_ends(g, id, Leaf::Out(k), depth - 1))
}

/// Whether an expression is linear in an input, and not negative at both ends of it.
fn between_ends(g: &mut Graph, id: Id, leaf: Leaf, depth: u8) -> bool {
    let range = g.leaf_range(leaf);
    if !g.has(id, leaf_bit(leaf)) || range.lo != -1.0 || range.hi != 1.0 {
        return false;
    }
    let slope = derivative(g, id, leaf);
    let slope = simplify(g, slope, None);
    let x = g.get_leaf(leaf);
    !g.has(slope, leaf_bit(leaf))
        && [-1, 1].into_iter().all(|end| {
            let end = g.int(end);
            let there = g.substitute(id, &[(x, end)].into());
            proven(g, there, depth) || is_square(g, there)
        })
}

/// Whether an expression is the square of a quotient of polynomials.
fn is_square(g: &mut Graph, id: Id) -> bool {
    let Some(f) = Expander::new(g).expand(id) else { return false };
    f.num.sqrt().is_some() && f.den.iter().all(|(_, e)| e % 2 == 0)
}

/// Whether one of three coordinates of a direction, which are `written` so and equal to `forms`, depends on this
/// unknown alone, continuously, and goes from one pole to the other: then it takes all values between, and the
/// unknown behind any height lies in [0, 1].
pub(super) fn from_pole_to_pole(
    g: &mut Graph,
    written: &[Id],
    forms: &[Id],
    unknown: Leaf,
) -> bool {
    let alone = |x: &Id| g.deps(*x) & UNKNOWNS == leaf_bit(unknown);
    let Some(k) = written.iter().position(alone) else { return false };
    let ends = at_ends(g, written[k], unknown).map(|there| g.as_number(there));
    let poles = [Q::ONE, Q::int(-1)];
    let at_poles = ends.iter().all(|end| end.is_some_and(|z| poles.contains(&z)));
    at_poles
        && ends[0] != ends[1]
        && [written[k], forms[k]].iter().any(|&x| continuous(g, x, unknown))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::interval::Interval;
    use crate::solve::Condition;

    #[test]
    fn a_squared_distance_between_points_of_two_spheres() {
        let mut g = Graph::new();
        let p = g.leaf(Leaf::Param(0), "g", Interval::ALL);
        let z = g.leaf(Leaf::Out(2), "z", Interval::new(-1.0, 1.0));
        let square = g.powi(p, 2);
        let product = g.mul(p, z);
        let sum =
            |g: &mut Graph, twice| g.sum(Q::ONE, &[(Q::ONE, square), (Q::int(twice), product)]);
        let held = sum(&mut g, -2);
        assert!(never_negative(&mut g, held));
        let over = g.powi(held, -3);
        assert!(never_negative(&mut g, over));
        let failing = sum(&mut g, -3);
        assert!(!never_negative(&mut g, failing));
        let negated = g.neg(held);
        assert!(!never_negative(&mut g, negated));
    }

    #[test]
    fn opposite_preimages_exclude_each_other_by_a_plain_sign() {
        let mut g = Graph::new();
        let z = g.leaf(Leaf::Out(2), "z", Interval::ALL);
        let r = g.leaf(Leaf::Out(0), "r", Interval::POSITIVE);
        // r / z³ and its negative, and what both ask for.
        let cube = g.powi(z, -3);
        let ratio = g.mul(r, cube);
        let opposite = g.neg(ratio);
        let common = g.sum(Q::ONE, &[(Q::int(-1), z)]);
        let of = |conditions: &[Id]| Solution {
            conditions: conditions.iter().map(|c| Condition(*c)).collect(),
            ..Solution::default()
        };
        let kept = opposed(&mut g, &[of(&[ratio, common]), of(&[opposite, common])]);
        let minus = g.neg(z);
        assert_eq!(kept, [vec![z], vec![minus]]);
        assert_eq!(opposed(&mut g, &[of(&[ratio])]), [vec![]]);
    }

    #[test]
    fn heights_that_take_all_values() {
        let mut g = Graph::new();
        let u = g.leaf(Leaf::Unknown(0), "u", Interval::new(0.0, 1.0));
        let v = g.leaf(Leaf::Unknown(1), "v", Interval::new(0.0, 1.0));
        let part = g.leaf(Leaf::Param(0), "p", Interval::new(0.1, 0.9));
        let around = g.mul(u, v);
        let holds = |g: &mut Graph, height: Id, leaf: u8| {
            let point = [around, around, height];
            from_pole_to_pole(g, &point, &point, Leaf::Unknown(leaf))
        };
        let uniform = g.sum(Q::ONE, &[(Q::int(-2), u)]);
        assert!(holds(&mut g, uniform, 0));
        assert!(!holds(&mut g, uniform, 1));
        // A cap ends before the other pole.
        let cap = g.mul(u, part);
        let cap = g.sum(Q::ONE, &[(Q::int(-1), cap)]);
        assert!(!holds(&mut g, cap, 0));
        // One over 1 - 2 u goes from pole to pole through infinity.
        let jump = g.powi(uniform, -1);
        assert!(!holds(&mut g, jump, 0));
        // With a divisor that is positive between its ends: (p - (1 + p) u) / (p + (1 - p) u).
        let (more, less) = (g.add(part, u), g.mul(part, u));
        let top = g.sum(Q::ZERO, &[(Q::ONE, part), (Q::int(-1), less), (Q::int(-1), u)]);
        let bottom = g.sub(more, less);
        let ratio = g.div(top, bottom);
        assert!(holds(&mut g, ratio, 0));
    }
}
