//! Which of the coordinates of a unit vector tells an unknown best.
//!
//! The equations of a direction are one too many. Near a pole z is known to an ulp of one, and says
//! next to nothing of how far the pole is away; x and y say it to full precision, and conversely at
//! the horizon. So every coordinate of which an unknown is a function may be replaced, where it is
//! large, by what the others say of it; whether it pays is measured. Where it is small, 1 - z² says what x² + y² lacks
//! to one, which a high power of it asks for. The same holds of coordinates of any manifold whose squares add up to one.

use std::collections::BTreeMap;

use super::Problem;
use super::cases::{Case, unknown_of};
use super::near_one::tells_an_angle;
use super::units::by_one;
use crate::expr::{Graph, Id, Leaf, Node, leaf_bit};
use crate::hash::Map;
use crate::interval::Interval;
use crate::measure::{Inputs, Measure};
use crate::poly::{Expander, Poly, RatFun};
use crate::rational::Q;
use crate::stabilise::{GOOD, stabilise_to};

/// Bits of accuracy, on average over the points, below which another form is not worth its length.
const GAIN: f64 = 0.5;
/// The same for the worst error near the pole, as a factor.
const LEAP: f64 = 16.0;
/// By what factor the worst errors of two forms differ by chance: where the unknown itself is ill-conditioned, either is
/// what the rounding of the point makes of it.
const CHANCE: f64 = 1.0625;

/// The depth below a pole, while forms are made.
const DEPTH: Leaf = Leaf::Unknown(22);

/// The value of unknown number `index` in terms of the coordinates that are best conditioned.
pub(super) fn best_coordinates(
    problem: &mut Problem,
    (index, value): (usize, Id),
    units: &[Vec<u8>],
    cases: &[Case],
    measure: &mut Measure,
) -> Id {
    let truth = unknown_of(cases, index);
    best_forms(&mut problem.graph, value, units, &truth, measure)
}

/// Where on a sphere a coordinate is large, and where it is small.
#[derive(Clone, Copy)]
enum Region {
    /// Above a half (side 1) or below minus a half (side -1).
    Pole(Q),
    /// Between.
    Equator,
}

impl Region {
    const ALL: [Region; 3] = [Region::Pole(Q::ONE), Region::Pole(Q::int(-1)), Region::Equator];

    /// Whether coordinate `k` of a point is in it.
    fn has(self, point: &Inputs, k: u8) -> bool {
        point.get(&Leaf::Out(k)).is_some_and(|&x| match self {
            Region::Pole(side) => side.to_f64() * x > 0.5,
            Region::Equator => x.abs() < 0.5,
        })
    }
}

/// The value of an expression of the coordinates of unit vectors, in terms of those that are best conditioned.
pub(super) fn best_forms(
    g: &mut Graph,
    value: Id,
    units: &[Vec<u8>],
    truth: &[f64],
    measure: &mut Measure,
) -> Id {
    let mut best = value;
    for (unit, k) in units.iter().flat_map(|unit| unit.iter().map(move |&k| (unit, k))) {
        for region in Region::ALL {
            let form = match region {
                Region::Pole(side) => near_pole(g, (value, best), (unit, k), side, measure),
                Region::Equator => at_equator(g, (value, best), (unit, k), measure),
            };
            let Some(form) = form else { continue };
            let (old, new) = (measure.errors(g, best, truth), measure.errors(g, form, truth));
            // Where neither has a value, as for an angle right at the pole, they are alike.
            let told: Vec<bool> =
                (0..truth.len()).map(|i| !(old.is_unknown(i) && new.is_unknown(i))).collect();
            let points = measure.points().iter().zip(&told);
            let near: Vec<bool> = points.map(|(p, &told)| told && region.has(p, k)).collect();
            let (wholly, nearby) = (
                (old.loss_where(&told, true), new.loss_where(&told, true)),
                (old.loss_where(&near, true), new.loss_where(&near, true)),
            );
            let gains = |part: usize| {
                let (old, new) = (wholly.0.parts()[part], wholly.1.parts()[part]);
                let better = new.bits + GAIN < old.bits;
                let (old, new) = (nearby.0.parts()[part], nearby.1.parts()[part]);
                let saves =
                    old.worst > GOOD && LEAP * new.worst < old.worst && new.bits <= old.bits;
                // Where not even one digit is right, there is nothing to lose.
                (better || saves) && (new.worst <= old.worst || old.worst > 0.5)
            };
            let loses = |part: usize| {
                let (old, new) = (wholly.0.parts()[part], wholly.1.parts()[part]);
                let worst = CHANCE * old.worst;
                new.bits > old.bits + 0.1 || new.worst > worst.max(16.0 * f64::EPSILON)
            };
            // A gain in single precision must not cost anything in double.
            if gains(0) || gains(1) && !loses(0) {
                best = form;
            }
        }
    }
    best
}

/// The value with coordinate `k` computed from the others where it is above a half (side 1) or
/// below minus a half (side -1): as one minus the depth below the pole, which they tell to full precision.
/// Elsewhere it is `rest`.
fn near_pole(
    g: &mut Graph,
    (value, rest): (Id, Id),
    (unit, k): (&[u8], u8),
    side: Q,
    measure: &Measure,
) -> Option<Id> {
    if !g.has(value, leaf_bit(Leaf::Out(k))) {
        return None;
    }
    let coordinate = g.get_leaf(Leaf::Out(k));
    let signed = g.sum(Q::ZERO, &[(side, coordinate)]);
    let minus_half = g.number(Q::HALF.neg());
    let test = g.add(signed, minus_half);
    let others: Vec<(Q, Id)> = unit
        .iter()
        .filter(|i| **i != k)
        .map(|&i| {
            let c = g.get_leaf(Leaf::Out(i));
            (Q::ONE, g.powi(c, 2))
        })
        .collect();
    let top = g.sum(Q::ZERO, &others);
    let bottom = g.sum(Q::ONE, &[(Q::ONE, signed)]);
    let depth = g.div(top, bottom);
    let mut here = measure.subset(|p| Region::Pole(side).has(p, k));
    if here.points().is_empty() {
        return None;
    }
    let d = g.leaf(DEPTH, "depth", Interval::new(0.0, 0.5));
    let height = g.sum(side, &[(side.neg(), d)]);
    let replaced = in_depth(g, value, coordinate, height, &mut Map::default());
    let replaced = g.substitute(replaced, &BTreeMap::from([(d, depth)]));
    let replaced = stabilise_to(g, replaced, &mut here, 4.0 * f64::EPSILON);
    Some(g.if_positive(test, replaced, rest))
}

/// The value where coordinate `k` is below a half in size, with one minus its square for the sum of those of the others.
/// Elsewhere it is `rest`.
fn at_equator(
    g: &mut Graph,
    (value, rest): (Id, Id),
    (unit, k): (&[u8], u8),
    measure: &Measure,
) -> Option<Id> {
    let replaced = by_one(g, value, unit, k)?;
    let mut here = measure.subset(|p| Region::Equator.has(p, k));
    if here.points().is_empty() {
        return None;
    }
    let replaced = stabilise_to(g, replaced, &mut here, 4.0 * f64::EPSILON);
    let coordinate = g.get_leaf(Leaf::Out(k));
    let square = g.powi(coordinate, 2);
    let quarter = Q::HALF.mul(Q::HALF)?;
    let test = g.sum(quarter, &[(Q::int(-1), square)]);
    Some(g.if_positive(test, replaced, rest))
}

/// An expression of the coordinate in terms of the depth: sums that it occurs in are sorted by powers
/// of the depth, with coefficients in factors, because what cancels is their constant.
fn in_depth(g: &mut Graph, id: Id, coordinate: Id, height: Id, memo: &mut Map<Id, Id>) -> Id {
    if id == coordinate {
        return height;
    }
    if !g.has(id, g.deps(coordinate)) {
        return id;
    }
    if let Some(&known) = memo.get(&id) {
        return known;
    }
    let mut part = |g: &mut Graph, id| in_depth(g, id, coordinate, height, memo);
    let made = match g.node(id).clone() {
        Node::Sum(c, terms) => {
            let single = c.is_zero() && terms.len() == 1;
            let terms: Vec<_> = terms.into_iter().map(|(q, t)| (q, part(g, t))).collect();
            let sum = g.sum(c, &terms);
            if single { sum } else { by_powers(g, sum).unwrap_or(sum) }
        }
        Node::Product(factors) => {
            let factors: Vec<_> =
                factors.into_iter().map(|(b, e)| (part(g, b), part(g, e))).collect();
            g.product(&factors)
        }
        Node::Call(f, args) => {
            let args: Vec<_> = args.into_iter().map(|a| part(g, a)).collect();
            g.call(f, &args)
        }
        Node::If(test, yes, no) if !tells_a_side(g, test) && !tells_an_angle(g, test) => {
            let [test, yes, no] = [test, yes, no].map(|id| part(g, id));
            g.if_positive(test, yes, no)
        }
        // What was decided for another side of the sphere stays, and what is told by a difference of vectors.
        _ => id,
    };
    memo.insert(id, made);
    made
}

/// Whether a test is one of those that [`near_pole`] makes.
fn tells_a_side(g: &Graph, test: Id) -> bool {
    let Node::Sum(c, terms) = g.node(test) else { return false };
    let is_out = |id: Id| matches!(g.node(id), Node::Leaf(Leaf::Out(_)));
    *c == Q::HALF.neg() && matches!(terms[..], [(_, x)] if is_out(x))
}

/// A sum by powers of the depth, if it is a quotient of polynomials in it.
fn by_powers(g: &mut Graph, sum: Id) -> Option<Id> {
    let d = g.get_leaf(DEPTH);
    let whole = Expander::new(g).expand(sum)?;
    let bottom = RatFun { num: Poly::constant(Q::ONE), den: whole.den };
    let mut terms = Vec::new();
    for (power, c) in whole.num.by_powers_of(d)?.into_iter().enumerate() {
        let c = c.to_expr(g);
        let power = g.powi(d, power as i64);
        terms.push((Q::ONE, g.mul(c, power)));
    }
    let top = g.sum(Q::ZERO, &terms);
    let bottom = Expander::new(g).to_expr(&bottom);
    Some(g.mul(top, bottom))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn both_sides_of_a_choice_are_in_terms_of_the_depth() {
        let mut g = Graph::new();
        let signed = Interval::new(-1.0, 1.0);
        let [x, z] = [0, 2].map(|i| g.leaf(Leaf::Out(i), ["x", "y", "z"][i as usize], signed));
        let d = g.leaf(DEPTH, "depth", Interval::new(0.0, 0.5));
        let height = g.sum(Q::ONE, &[(Q::int(-1), d)]);
        let to_depth = |g: &mut Graph, id| in_depth(g, id, z, height, &mut Map::default());
        let below = g.sum(Q::ONE, &[(Q::int(-1), z)]);
        let roots = [g.sqrt(below), g.sqrt(d)];
        let [written, expected] = roots.map(|root| {
            let product = g.mul(x, root);
            g.if_positive(x, product, root)
        });
        assert_eq!(to_depth(&mut g, written), expected);
        // A side that was decided for another coordinate stays.
        let test = g.sum(Q::HALF.neg(), &[(Q::ONE, x)]);
        let decided = g.if_positive(test, below, x);
        assert_eq!(to_depth(&mut g, decided), decided);
    }
}
