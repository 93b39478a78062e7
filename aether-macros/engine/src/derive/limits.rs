//! Parameters that may be zero although the formulas then divide zero by zero.
//!
//! Free flight with extinction s up to a distance is uniform for s → 0, but -ln(1 + u (e^-sd - 1)) / s
//! has no value there. Where a formula has none for a parameter of exactly zero and tends to one, the
//! emitted code takes a number for it that is too small to change the result.

use crate::eval::Evaluator;
use crate::expr::{Graph, Id, Leaf, leaf_bit};
use crate::measure::{Inputs, Measure};
use crate::sorted;

/// What stands for zero when the limit is looked for.
const TINY: f64 = 1e-20;

/// Which scalar parameters have to be kept from zero for all `formulas` to have their limits.
pub(super) fn parameters_with_limits(g: &Graph, formulas: &[Id], measure: &Measure) -> Vec<u8> {
    let points = &measure.points()[..measure.doubles()];
    let mut used: Vec<u8> = points.iter().flat_map(|p| p.keys()).filter_map(parameter).collect();
    sorted::sort(&mut used);
    used.dedup();
    used.retain(|&i| formulas.iter().any(|&f| has_limit(g, f, Leaf::Param(i), points)));
    used
}

fn parameter(leaf: &Leaf) -> Option<u8> {
    if let Leaf::Param(i) = leaf { Some(*i) } else { None }
}

/// Whether a formula is 0/0 for a parameter of zero and tends to something there.
fn has_limit(g: &Graph, formula: Id, parameter: Leaf, points: &[Inputs]) -> bool {
    let range = g.leaf_range(parameter);
    if !g.has(formula, leaf_bit(parameter)) || range.lo > 0.0 || range.hi < 0.0 {
        return false;
    }
    let value = |inputs: &Inputs, x: f64| {
        let at = |l: Leaf| match l {
            _ if l == parameter => x,
            _ => inputs.get(&l).copied().unwrap_or(f64::NAN),
        };
        Evaluator::<f64>::new(g, &at).value(formula)
    };
    let (mut tried, mut undetermined, mut settled) = (0, 0, 0);
    // One point of each round of parameters is enough.
    for inputs in points.iter().step_by(7).filter(|p| p.contains_key(&parameter)) {
        tried += 1;
        if value(inputs, 0.0).is_nan() {
            undetermined += 1;
            let [near, nearer] = [1e8 * TINY, TINY].map(|x| value(inputs, x));
            settled += usize::from((near - nearer).abs() <= 1e-9 * nearer.abs());
        }
    }
    // A few points may have no limit of their own (the edge of a support that shrinks); and where only a few have no
    // value, such as a pole, it is theirs that is the exception.
    2 * settled > undetermined && 2 * undetermined > tried
}
