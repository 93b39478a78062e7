//! Which of the coordinates of a unit vector tells an unknown best.
//!
//! The equations of a direction are one too many. Near a pole z is known to an ulp of one, and says
//! next to nothing of how far the pole is away; x and y say it to full precision, and conversely at
//! the horizon. So every coordinate of which an unknown is a function may be replaced, where it is
//! large, by what the other two say of it; whether it pays is measured.

use std::collections::BTreeMap;

use super::Problem;
use super::cases::Case;
use crate::expr::{Graph, Id, Leaf, leaf_bit};
use crate::measure::Measure;
use crate::number::Number;
use crate::rational::Q;
use crate::stabilise::stabilise_to;

/// Bits of accuracy, on average over the points, below which another form is not worth its length.
const GAIN: f64 = 0.5;

/// The value of unknown number `index` in terms of the coordinates that are best conditioned.
pub(super) fn best_coordinates(
    problem: &mut Problem,
    index: usize,
    value: Id,
    cases: &[Case],
    measure: &mut Measure,
) -> Id {
    let truth: Vec<f64> = cases.iter().map(|c| c.point.unknowns[index].to_f64()).collect();
    let g = &mut problem.graph;
    let mut best = value;
    for k in 0..3u8 {
        if !g.has(value, leaf_bit(Leaf::Out(k))) {
            continue;
        }
        for side in [Q::ONE, Q::int(-1)] {
            let Some(form) = near_pole(g, best, k, side, measure) else { continue };
            let (old, new) = (measure.loss(g, best, &truth), measure.loss(g, form, &truth));
            if new.bits + GAIN < old.bits && new.worst <= old.worst {
                best = form;
            }
        }
    }
    best
}

/// The value with coordinate `k` computed from the other two where it is above a half (side 1) or
/// below minus a half (side -1).
fn near_pole(g: &mut Graph, value: Id, k: u8, side: Q, measure: &Measure) -> Option<Id> {
    let coordinate = g.get_leaf(Leaf::Out(k));
    let minus_half = g.number(Q::HALF.neg());
    let signed = g.sum(Q::ZERO, &[(side, coordinate)]);
    let test = g.add(signed, minus_half);
    let others: Vec<(Q, Id)> = (0..3u8)
        .filter(|i| *i != k)
        .map(|i| {
            let c = g.get_leaf(Leaf::Out(i));
            (Q::int(-1), g.powi(c, 2))
        })
        .collect();
    let squared = g.sum(Q::ONE, &others);
    let root = g.sqrt(squared);
    let root = g.sum(Q::ZERO, &[(side, root)]);
    let replaced = g.substitute(value, &BTreeMap::from([(coordinate, root)]));
    let large = |x: &f64| side.to_f64() * x > 0.5;
    let mut here = measure.subset(|p| p.get(&Leaf::Out(k)).is_some_and(large));
    if here.points().is_empty() {
        return None;
    }
    let replaced = stabilise_to(g, replaced, &mut here, 4.0 * f64::EPSILON);
    Some(g.if_positive(test, replaced, value))
}
