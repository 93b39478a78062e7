//! Signs that expressions are seen to have, at points of their inputs' ranges.

use super::leaves::{any_input, inputs_of, inside};
use crate::eval::evaluate;
use crate::expr::{Graph, Id, Leaf, Node};
use crate::interval::Interval;
use crate::number::{Dd, Number};

/// Points at which the sign of a slope is looked at before a proof is tried.
pub(super) const POINTS: u32 = 32;

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

/// The sign of the slope at points inside; if it has both, of which there is no proof to be tried, or neither, what
/// is seen.
pub(super) fn sign_inside(
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
pub(super) fn value_at<T: Number>(g: &Graph, id: Id, leaves: &[Leaf], at: &[f64]) -> f64 {
    let number = |l: Leaf| leaves.iter().position(|k| *k == l).map_or(f64::NAN, |k| at[k]);
    evaluate::<T>(g, id, &|l| T::from_f64(number(l))).to_f64()
}

/// The same at some points, where `place` has the values of the inputs of each.
pub(super) fn sign_seen(
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
