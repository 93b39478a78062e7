//! Proofs that a function of one variable increases over its whole range, whatever the other inputs
//! in their domains.
//!
//! The box of all inputs is halved until, on every part, interval arithmetic shows that the slope is
//! not negative: directly, or because it is not negative where the variable begins and the slope's own
//! slope is not negative (and so on; or the same from the other end), which settles the neighbourhood of
//! a point where the slope vanishes. That the slope is not zero throughout is seen from its values.

use crate::derivative::derivative;
use crate::enclosure::{Enclosure, Over};
use crate::eval::evaluate;
use crate::expr::{Graph, Id, Leaf, Node, children};
use crate::interval::Interval;
use crate::jacobian::simplify;
use crate::number::{Dd, Number};
use crate::sorted;

/// Parts of the box that are looked at before a proof is given up.
const MAX_PARTS: usize = 3000;
/// Derivatives of the slope that are tried.
const ORDERS: usize = 3;
/// Points at which the sign of a slope is looked at before a proof is tried.
const POINTS: u32 = 32;

/// Why monotonicity could not be shown.
#[derive(Clone, Debug)]
pub struct Unproven {
    /// A part of the domain where the sign of the slope is not known, as text.
    pub place: String,
    /// A parameter of unbounded domain that the slope depends on, if there is one.
    pub unbounded: Option<String>,
}

/// Shows that `body` increases (1) or decreases (-1) strictly with `variable`, over the ranges that all
/// inputs are declared with.
pub fn direction(g: &mut Graph, body: Id, variable: Leaf) -> Result<i64, Unproven> {
    let slope = derivative(g, body, variable);
    shown(g, slope, variable, false)
}

/// Shows that an expression is positive (1) or negative (-1) everywhere.
pub fn sign_of(g: &mut Graph, id: Id, variable: Leaf) -> Result<i64, Unproven> {
    shown(g, id, variable, true)
}

/// The sign that an expression has at all points of its inputs' ranges that are tried; `None` if it has both, or none.
pub(crate) fn seen_sign(g: &Graph, id: Id) -> Option<i64> {
    sign_inside(g, id, &inputs_of(g, id)?, true, POINTS).ok()
}

/// The same at so many points and at corners of the ranges, where unit vectors have their length, and at which none of some
/// other expressions is negative.
pub(crate) fn sign_at(g: &Graph, id: Id, points: u32, known: &[Id]) -> Option<i64> {
    let Some(mut leaves) = inputs_of(g, id) else {
        let value = value_at::<f64>(g, id, &[], &[]);
        return [1, -1].into_iter().find(|sign| value * (*sign as f64) > 0.0);
    };
    // What has nothing to do with it tells nothing of it.
    let shared = |of: &Vec<Leaf>| of.iter().any(|leaf| leaves.contains(leaf));
    let (known, more): (Vec<Id>, Vec<Vec<Leaf>>) =
        known.iter().filter_map(|id| Some((*id, inputs_of(g, *id).filter(shared)?))).unzip();
    for leaf in more.into_iter().flatten() {
        if !leaves.contains(&leaf) {
            leaves.push(leaf);
        }
    }
    // The length of a vector is that of all its coordinates.
    for coordinates in g.units() {
        let of_unit = coordinates.map(|id| any_input(g, id));
        if of_unit.iter().flatten().any(|leaf| leaves.contains(leaf)) {
            let others = of_unit.into_iter().flatten().filter(|leaf| !leaves.contains(leaf));
            leaves.extend(others.collect::<Vec<Leaf>>());
        }
    }
    let corners = 1 << leaves.len().min(MOST_CORNERS);
    // What relations say of an input is known of the expression that it is.
    let nodes = g.within(&[&known[..], &[id]].concat());
    let range = |leaf: &Leaf| {
        let node = nodes.iter().find(|id| g.is_leaf(**id, *leaf));
        node.map_or(g.leaf_range(*leaf), |id| g.range(*id))
    };
    let ranges: Vec<Interval> = leaves.iter().map(range).collect();
    let corner = |n: u32| n.checked_sub(points).filter(|n| *n < corners);
    let place = |n: u32| {
        let mut at = inputs(&ranges, n, corner(n));
        unit_lengths(g, &leaves, &mut at);
        let holds = |id: &Id| value_at::<f64>(g, *id, &leaves, &at) >= 0.0;
        known.iter().all(holds).then_some(at)
    };
    // Where much is known, more points are needed.
    let tried = points * (1 + known.len().min(MOST_KNOWN) as u32) + corners;
    let found = (0..tried).filter_map(&place).take(LEAST_FOUND).count();
    if found < LEAST_FOUND {
        return if known.is_empty() { None } else { sign_at(g, id, points, &[]) };
    }
    let place = |n: u32| place(n).unwrap_or_else(|| vec![f64::NAN; leaves.len()]);
    // Next to a bound, rounding is as large as what is left.
    sign_seen(g, id, &leaves, (true, tried), &place, value_at::<Dd>).ok()
}

/// How often more points are tried where other expressions leave few, and how many these may leave at least.
const MOST_KNOWN: usize = 7;
const LEAST_FOUND: usize = 64;
/// How many inputs are taken to both of their ends, at most.
const MOST_CORNERS: usize = 10;

/// The nth values of some inputs in their ranges; or of a corner, by a bit for each, as far as there is one.
fn inputs(ranges: &[Interval], n: u32, corner: Option<u32>) -> Vec<f64> {
    // A sequence of its own for each input, which does not repeat.
    let step = |k: usize| (0.5 + f64::from(n) * (k as f64 + 2.0).ln()).fract();
    let input = |(k, &range): (usize, &Interval)| {
        let end = corner.filter(|_| k < MOST_CORNERS);
        let end = end.map(|bits| if bits >> k & 1 == 0 { range.lo } else { range.hi });
        end.filter(|end| end.is_finite()).unwrap_or_else(|| inside(range, step(k)))
    };
    ranges.iter().enumerate().map(input).collect()
}

/// The nth values of inputs in the ranges that they are declared with; the first ones are at corners.
pub(crate) fn values_of(g: &Graph, leaves: &[Leaf], n: u32) -> Vec<f64> {
    let ranges: Vec<Interval> = leaves.iter().map(|leaf| g.leaf_range(*leaf)).collect();
    let corners = 1 << leaves.len().min(MOST_CORNERS);
    let mut at = inputs(&ranges, n, Some(n).filter(|n| *n < corners));
    unit_lengths(g, leaves, &mut at);
    at
}

/// Scales the inputs that are coordinates of unit vectors.
fn unit_lengths(g: &Graph, leaves: &[Leaf], at: &mut [f64]) {
    for unit in g.units() {
        let place = |id: &Id| match g.node(*id) {
            Node::Leaf(leaf) => leaves.iter().position(|l| l == leaf),
            _ => None,
        };
        if let [Some(x), Some(y), Some(z)] = [0, 1, 2].map(|i| place(&unit[i])) {
            let length = libm::hypot(libm::hypot(at[x], at[y]), at[z]);
            if length > 0.0 {
                [x, y, z].into_iter().for_each(|i| at[i] /= length);
            }
        }
    }
}

/// An input that an expression depends on.
pub(crate) fn any_input(g: &Graph, id: Id) -> Option<Leaf> {
    match g.node(id) {
        Node::Leaf(leaf) => Some(*leaf),
        node => children(node).into_iter().find_map(|part| any_input(g, part)),
    }
}

/// The sign of a slope that may vanish here and there, or nowhere where `strict`.
fn shown(g: &mut Graph, slope: Id, variable: Leaf, strict: bool) -> Result<i64, Unproven> {
    let leaves = leaves_of(g, slope, variable);
    let sign = match sign_inside(g, slope, &leaves, strict, POINTS) {
        Ok(sign) => sign,
        Err(seen) => {
            let whole: Vec<Interval> = leaves.iter().map(|l| g.leaf_range(*l)).collect();
            let mut why = unproven(g, &leaves, &whole);
            why.place += &seen;
            return Err(why);
        }
    };
    let upward = if sign < 0 { g.neg(slope) } else { slope };
    Proof::new(g, upward, variable, leaves, strict).run(g).map(|()| sign)
}

/// The inputs of an expression, if there are any.
pub(crate) fn inputs_of(g: &Graph, id: Id) -> Option<Vec<Leaf>> {
    Some(leaves_of(g, id, any_input(g, id)?))
}

/// The inputs of an expression, the variable first.
pub(crate) fn leaves_of(g: &Graph, id: Id, variable: Leaf) -> Vec<Leaf> {
    let mut seen = std::collections::HashSet::new();
    let mut open = vec![id];
    let mut leaves = vec![variable];
    while let Some(id) = open.pop() {
        if !seen.insert(id) {
            continue;
        }
        match g.node(id) {
            Node::Leaf(l) if !leaves.contains(l) => leaves.push(*l),
            // What it depends on is enclosed by its ends.
            node => open.extend(children(node)),
        }
    }
    sorted::sort(&mut leaves[1..]);
    leaves
}

/// A number in the middle of an interval, which may be infinite.
pub(crate) fn centre(i: Interval) -> f64 {
    match (i.lo.is_finite(), i.hi.is_finite()) {
        (true, true) => i.lo + 0.5 * (i.hi - i.lo),
        (true, false) => (2.0 * i.lo).max(i.lo + 1.0),
        (false, true) => (2.0 * i.hi).min(i.hi - 1.0),
        (false, false) => 0.0,
    }
}

/// The number that lies at a fraction t of an interval, which may be infinite.
pub(crate) fn inside(i: Interval, t: f64) -> f64 {
    let far = t / (1.0 - t);
    match (i.lo.is_finite(), i.hi.is_finite()) {
        (true, true) => i.lo + t * i.width(),
        (true, false) => i.lo + far,
        (false, true) => i.hi - 1.0 / far,
        (false, false) => far - 1.0 / far,
    }
}

/// The sign of the slope at points inside; if it has both, of which there is no proof to be tried, or neither, what
/// is seen.
fn sign_inside(
    g: &Graph,
    slope: Id,
    leaves: &[Leaf],
    strict: bool,
    points: u32,
) -> Result<i64, String> {
    let ranges: Vec<Interval> = leaves.iter().map(|leaf| g.leaf_range(*leaf)).collect();
    let place = |n| inputs(&ranges, n, None);
    sign_seen(g, slope, leaves, (strict, points), &place, value_at::<f64>)
}

/// The value of an expression, computed in `T`, for these values of its inputs.
fn value_at<T: Number>(g: &Graph, id: Id, leaves: &[Leaf], at: &[f64]) -> f64 {
    let number = |l: Leaf| leaves.iter().position(|k| *k == l).map_or(f64::NAN, |k| at[k]);
    evaluate::<T>(g, id, &|l| T::from_f64(number(l))).to_f64()
}

/// The same at some points, where `place` has the values of the inputs of each.
fn sign_seen(
    g: &Graph,
    slope: Id,
    leaves: &[Leaf],
    (strict, points): (bool, u32),
    place: &dyn Fn(u32) -> Vec<f64>,
    value_at: fn(&Graph, Id, &[Leaf], &[f64]) -> f64,
) -> Result<i64, String> {
    let value = |n: u32| value_at(g, slope, leaves, &place(n));
    let (mut least, mut most) = ((0.0_f64, 0), (0.0_f64, 0));
    for (v, n) in (0..points).map(|n| (value(n), n)).filter(|v| v.0.is_finite()) {
        least = if v < least.0 { (v, n) } else { least };
        most = if v > most.0 { (v, n) } else { most };
    }
    // What is smaller by so much may be rounding.
    let negligible = 1e-6 * most.0.max(-least.0);
    let point = |n: u32| {
        let inputs = leaves.iter().zip(place(n));
        let shown = inputs.map(|(l, x)| format!("{} = {x:.4}", g.name(*l)));
        shown.collect::<Vec<_>>().join(", ")
    };
    match (most.0 > negligible, -least.0 > negligible) {
        (true, false) => Ok(1),
        (false, true) => Ok(-1),
        (true, true) => {
            let (up, down) =
                if strict { ("is positive", "is negative") } else { ("increases", "decreases") };
            Err(format!(", as it {up} at {} and {down} at {}", point(most.1), point(least.1)))
        }
        (false, false) => Err(String::new()),
    }
}

/// That there is no proof for a part of the box.
pub(crate) fn unproven(g: &Graph, leaves: &[Leaf], part: &[Interval]) -> Unproven {
    let place: Vec<String> = leaves
        .iter()
        .zip(part)
        .map(|(l, i)| {
            let end =
                |x: f64| if x.is_infinite() { "∞".to_owned() } else { format!("{:.6}", x.abs()) };
            let sign = |x: f64| if x < 0.0 { "-" } else { "" };
            format!("{} in [{}{}, {}{}]", g.name(*l), sign(i.lo), end(i.lo), sign(i.hi), end(i.hi))
        })
        .collect();
    let unbounded = leaves
        .iter()
        .find(|l| matches!(l, Leaf::Param(_)) && !g.leaf_range(**l).width().is_finite());
    Unproven { place: place.join(", "), unbounded: unbounded.map(|l| g.name(*l).to_owned()) }
}

/// What shows on a part of the box that a slope is not negative there.
pub(crate) struct Proof {
    /// The slope and its derivatives, each in the forms that are tried.
    orders: Vec<Vec<Id>>,
    leaves: Vec<Leaf>,
    enclosure: Enclosure,
    /// Whether the slope must not be zero anywhere.
    strict: bool,
}

impl Proof {
    /// For a slope by the first of its inputs, `variable`.
    pub(crate) fn new(
        g: &mut Graph,
        slope: Id,
        variable: Leaf,
        leaves: Vec<Leaf>,
        strict: bool,
    ) -> Proof {
        let mut orders = Vec::new();
        let mut current = slope;
        for _ in 0..=if strict { 0 } else { ORDERS } {
            let tidy = simplify(g, current, None);
            let factored = crate::jacobian::factor_out(g, tidy);
            let mut forms = vec![current, tidy, factored];
            forms.dedup();
            orders.push(forms);
            current = derivative(g, tidy, variable);
        }
        let all: Vec<Id> = orders.iter().flatten().copied().collect();
        let enclosure = Enclosure::new(g, &all, &leaves);
        Proof { orders, leaves, enclosure, strict }
    }

    fn run(&self, g: &Graph) -> Result<(), Unproven> {
        let whole: Vec<Interval> = self.leaves.iter().map(|l| g.leaf_range(*l)).collect();
        // Breadth first, so that what is given up on is as large as can be.
        let mut open = std::collections::VecDeque::from([whole]);
        let mut parts = 0;
        while let Some(part) = open.pop_front() {
            parts += 1;
            if self.shown(&part) {
                if !self.positive_somewhere(g, &part) {
                    return Err(unproven(g, &self.leaves, &part));
                }
                continue;
            }
            let negative = self.pick(&mut self.enclosure.over(&part), 0).hi < 0.0;
            let Some((left, right)) =
                halves(&part, parts).filter(|_| parts < MAX_PARTS && !negative)
            else {
                return Err(unproven(g, &self.leaves, &part));
            };
            open.extend([left, right]);
        }
        Ok(())
    }

    /// What all forms of a derivative say together.
    fn pick(&self, values: &mut Over, order: usize) -> Interval {
        self.orders[order].iter().fold(Interval::ALL, |i, form| {
            let j = values.get(*form);
            Interval { lo: i.lo.max(j.lo), hi: i.hi.min(j.hi) }
        })
    }

    /// How many intervals it takes to look at a part.
    pub(crate) fn len(&self) -> usize {
        self.enclosure.len()
    }

    /// The interval of the slope itself over a part.
    pub(crate) fn values(&self, part: &[Interval]) -> Interval {
        self.pick(&mut self.enclosure.over(part), 0)
    }

    /// Whether the slope is nowhere negative on a part.
    pub(crate) fn shown(&self, part: &[Interval]) -> bool {
        let mut over = self.enclosure.over(part);
        let values = self.pick(&mut over, 0);
        if self.strict {
            return values.lo > 0.0;
        }
        let mut settled_from = |x: f64, side: f64| {
            let mut face = part.to_vec();
            face[0] = Interval::point(x);
            x.is_finite() && self.settled_from(&mut over, &mut self.enclosure.over(&face), side)
        };
        values.nonnegative() || settled_from(part[0].lo, 1.0) || settled_from(part[0].hi, -1.0)
    }

    /// Not negative at one end, and not falling from there: the derivatives at the end up to some order
    /// and the next one over the whole part have the sign that makes it so. `side` is 1 for the lower
    /// end, and -1 for the upper one, from where odd derivatives count with the other sign.
    fn settled_from(&self, over: &mut Over, end: &mut Over, side: f64) -> bool {
        let mut sign = 1.0;
        for order in 0..=ORDERS {
            if order > 0 && self.pick(over, order).scale(sign).nonnegative() {
                return true;
            }
            if !self.pick(end, order).scale(sign).nonnegative() {
                return false;
            }
            sign *= side;
        }
        false
    }

    /// Whether the slope, which is not negative, is positive at the centre of a part.
    pub(crate) fn positive_somewhere(&self, g: &Graph, part: &[Interval]) -> bool {
        let at = |l: Leaf| {
            let found = self.leaves.iter().position(|k| *k == l);
            found.map_or(f64::NAN, |k| centre(part[k]))
        };
        // Zero may also be the outcome of underflow, far out.
        let far = part.iter().any(|i| !i.width().is_finite());
        let v = crate::eval::evaluate::<f64>(g, self.orders[0][0], &at);
        far || v > 0.0 || v.is_nan()
    }
}

/// Two halves of a box along its widest side, each side taken in turn if they are alike.
pub(crate) fn halves(part: &[Interval], turn: usize) -> Option<(Vec<Interval>, Vec<Interval>)> {
    let size = |i: Interval| {
        let relative = i.width() / (1.0 + i.lo.abs().min(i.hi.abs()));
        if relative.is_nan() { f64::INFINITY } else { relative }
    };
    let n = part.len();
    let widest =
        (0..n).map(|k| (k + turn) % n).max_by(|a, b| size(part[*a]).total_cmp(&size(part[*b])))?;
    let i = part[widest];
    let c = centre(i);
    if c <= i.lo || c >= i.hi || i.width() < 1e-13 * (1.0 + c.abs()) {
        return None;
    }
    let (mut left, mut right) = (part.to_vec(), part.to_vec());
    left[widest].hi = c;
    right[widest].lo = c;
    Some((left, right))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::expr::Fun;
    use crate::rational::Q;

    fn unit(g: &mut Graph) -> (Leaf, Id) {
        let leaf = Leaf::Unknown(0);
        (leaf, g.leaf(leaf, "u", Interval::new(0.0, 1.0)))
    }

    #[test]
    fn sums_of_increasing_functions() {
        let mut g = Graph::new();
        let (leaf, u) = unit(&mut g);
        let k = g.leaf(Leaf::Param(0), "k", Interval::new(0.0, 10.0));
        let u5 = g.powi(u, 5);
        let second = g.mul(k, u5);
        let log = g.call(Fun::Ln1p, &[u]);
        let f = g.sum(Q::ZERO, &[(Q::ONE, u), (Q::ONE, second), (Q::ONE, log)]);
        assert_eq!(direction(&mut g, f, leaf).unwrap(), 1);
        let down = g.neg(f);
        assert_eq!(direction(&mut g, down, leaf).unwrap(), -1);
    }

    #[test]
    fn a_slope_that_vanishes_at_an_end() {
        let mut g = Graph::new();
        let (leaf, t) = unit(&mut g);
        let (t3, t4) = (g.powi(t, 3), g.powi(t, 4));
        let f = g.sum(Q::ZERO, &[(Q::int(2), t3), (Q::int(-1), t4)]);
        assert_eq!(direction(&mut g, f, leaf).unwrap(), 1);
        // Kepler's equation with all eccentricities up to one.
        let e = g.leaf(Leaf::Param(0), "e", Interval::new(0.0, 1.0));
        let leaf = Leaf::Unknown(1);
        let a = g.leaf(leaf, "a", Interval::new(0.0, std::f64::consts::TAU));
        let s = g.call(Fun::Sin, &[a]);
        let es = g.mul(e, s);
        let f = g.sub(a, es);
        assert_eq!(direction(&mut g, f, leaf).unwrap(), 1);
    }

    #[test]
    fn what_does_not_increase_is_refused() {
        let mut g = Graph::new();
        let (leaf, u) = unit(&mut g);
        let (u2, u3) = (g.powi(u, 2), g.powi(u, 3));
        let c = |n, d| Q::new(n, d).unwrap();
        // u³ - 3/2 u² + 9/16 u turns twice inside.
        let f = g.sum(Q::ZERO, &[(Q::ONE, u3), (c(-3, 2), u2), (c(9, 16), u)]);
        let reason = direction(&mut g, f, leaf).unwrap_err();
        assert!(reason.place.starts_with("u in [0."), "{}", reason.place);
        // The parameter may be negative.
        let k = g.leaf(Leaf::Param(0), "k", Interval::ALL);
        let second = g.mul(k, u3);
        let f = g.add(u, second);
        let reason = direction(&mut g, f, leaf).unwrap_err();
        assert_eq!(reason.unbounded.as_deref(), Some("k"));
        // A constant does not increase.
        let f = g.if_positive(u2, u2, u3);
        let flat = g.sub(f, f);
        assert!(direction(&mut g, flat, leaf).is_err());
    }
}
