//! Adaptive cubature over boxes.

use std::cmp::Ordering;
use std::collections::BinaryHeap;

use crate::uniform::{Pcg32, UniformSource};

/// The most dimensions of a box.
pub(super) const MOST: usize = 4;

/// A place in a box.
pub(super) type Place = [f64; MOST];

/// A box in up to four dimensions.
pub(super) type Bounds = [(f64, f64); MOST];

/// A box, and the number of the bin that it is a part of.
pub(super) type Part = (usize, Bounds);

/// An integral over each of several bins.
#[derive(Clone, Debug)]
pub(super) struct Integral {
    /// One value a bin.
    pub(super) bins: Vec<f64>,
    /// The variance of each value.
    pub(super) variances: Vec<f64>,
}

impl Integral {
    /// The sum over all bins.
    pub(super) fn total(&self) -> f64 {
        self.bins.iter().sum()
    }

    /// Standard error of the sum.
    pub(super) fn error(&self) -> f64 {
        self.variances.iter().sum::<f64>().sqrt()
    }
}

struct Cell {
    bounds: Bounds,
    owner: usize,
    depth: usize,
    value: f64,
    error: f64,
}

impl Ord for Cell {
    fn cmp(&self, other: &Self) -> Ordering {
        self.error.total_cmp(&other.error)
    }
}
impl PartialOrd for Cell {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}
impl PartialEq for Cell {
    fn eq(&self, other: &Self) -> bool {
        self.cmp(other).is_eq()
    }
}
impl Eq for Cell {}

/// Positive nodes and weights of Gauss-Legendre rules with an even number of points: no node lies
/// at the middle of a cell, where a pole would be likeliest.
const FOUR: &[(f64, f64)] = &[
    (0.339_981_043_584_856_3, 0.652_145_154_862_546_1),
    (0.861_136_311_594_052_6, 0.347_854_845_137_453_9),
];
const TWO: &[(f64, f64)] = &[(0.577_350_269_189_625_8, 1.0)];

/// Cells this deep are at the limit of the numbers' resolution.
const MOST_DEPTH: usize = 48;

/// Integrates `f` over the parts of each bin. A cubature finds out where `f` varies: it splits the
/// cell with the largest error in half along every axis until the error falls below `tolerance` or
/// half of the `evaluations` are spent. Then random points in its cells give the result, since no fixed node
/// sees a jump that clips a corner. They are unbiased, so the standard error can be relied on.
///
/// An infinite value counts as zero; a NaN makes the result NaN.
pub(super) fn integrate(
    parts: &[Part],
    dimension: usize,
    tolerance: f64,
    evaluations: usize,
    mut f: impl FnMut(&Place) -> f64,
) -> Integral {
    let cells = refine(parts, dimension, tolerance, evaluations / 2, &mut f);
    let bins = parts.iter().map(|(owner, _)| owner + 1).max().unwrap_or(0);
    let mut result = Integral { bins: vec![0.0; bins], variances: vec![0.0; bins] };
    let mut source = Pcg32::new(0, 0, 0);
    let mut draw = |cell: &Cell| antithetic(&cell.bounds, dimension, &mut source, &mut f);
    // Cells get points in proportion to their deviation (Neyman), as a first few points tell it.
    let spreads: Vec<f64> = cells.iter().map(|c| (draw(c) - draw(c)).abs()).collect();
    let total: f64 = spreads.iter().sum();
    let pairs = evaluations as f64 / 4.0;
    for (cell, spread) in cells.iter().zip(&spreads) {
        let share = if total > 0.0 { spread / total } else { 0.0 };
        let count = 2.0 + (pairs * share).floor();
        let (mut mean, mut squares) = (0.0, 0.0);
        for k in 1..=count as u32 {
            let value = draw(cell);
            let off = value - mean;
            mean += off / f64::from(k);
            squares += off * (value - mean);
        }
        result.bins[cell.owner] += mean;
        result.variances[cell.owner] += squares / (count * (count - 1.0));
    }
    result
}

/// Splits the parts into cells that follow the integrand; each part once at least.
fn refine(
    parts: &[Part],
    dimension: usize,
    tolerance: f64,
    evaluations: usize,
    f: &mut impl FnMut(&Place) -> f64,
) -> Vec<Cell> {
    let rule = if dimension < 3 { FOUR } else { TWO };
    let cost = (2 * rule.len()).pow(dimension as u32) << dimension;
    let mut whole = |(owner, bounds): &Part| {
        let value = gauss(rule, bounds, dimension, f);
        Cell { bounds: *bounds, owner: *owner, depth: 0, value, error: f64::INFINITY }
    };
    let mut heap: BinaryHeap<Cell> = parts.iter().map(&mut whole).collect();
    let mut done = Vec::new();
    let mut open = f64::INFINITY;
    for step in 0.. {
        // The sum of squares drifts if it is only updated, so it is taken anew now and then.
        if step % 256 == 0 {
            open = heap.iter().map(|c| c.error * c.error).sum::<f64>().sqrt();
        }
        let finished = heap.peek().is_none_or(|c| c.error.is_finite());
        if finished && (open <= tolerance || step * cost > evaluations) {
            break;
        }
        let Some(parent) = heap.pop() else { break };
        let children = split(&parent, rule, dimension, f);
        let go_on = parent.depth + 1 < MOST_DEPTH && !parent.value.is_nan();
        if go_on { heap.extend(children) } else { done.extend(children) }
    }
    done.extend(heap);
    done
}

/// The integral over a cell from a random point and its mirror image about the middle, which cancel
/// linear variation.
fn antithetic(
    bounds: &Bounds,
    dimension: usize,
    source: &mut Pcg32,
    f: &mut impl FnMut(&Place) -> f64,
) -> f64 {
    let (mut x, mut mirrored, mut volume) = ([0.0; MOST], [0.0; MOST], 1.0);
    for axis in 0..dimension {
        let (low, high) = bounds[axis];
        let u: f64 = source.next();
        x[axis] = low + u * (high - low);
        mirrored[axis] = high - u * (high - low);
        volume *= high - low;
    }
    let finite = |value: f64| if value.is_infinite() { 0.0 } else { value };
    volume * 0.5 * (finite(f(&x)) + finite(f(&mirrored)))
}

/// The parts of a cell, with an error that follows from how its value changed by splitting it.
fn split(
    parent: &Cell,
    rule: &[(f64, f64)],
    dimension: usize,
    f: &mut impl FnMut(&Place) -> f64,
) -> Vec<Cell> {
    let (owner, depth) = (parent.owner, parent.depth + 1);
    let mut children: Vec<Cell> = (0..1 << dimension)
        .map(|corner| {
            let bounds = halve(&parent.bounds, dimension, corner);
            let value = gauss(rule, &bounds, dimension, f);
            Cell { bounds, owner, depth, value, error: 0.0 }
        })
        .collect();
    let sum: f64 = children.iter().map(|c| c.value).sum();
    let change = (sum - parent.value).abs() / children.len() as f64;
    // At a jump two bad values may agree by chance: an error does not vanish at once.
    let inherited = if parent.error.is_finite() { parent.error / 16.0 } else { 0.0 };
    children.iter_mut().for_each(|c| c.error = change.max(inherited));
    children
}

/// One of the 2^dimension parts of a box.
fn halve(bounds: &Bounds, dimension: usize, corner: usize) -> Bounds {
    let mut part = *bounds;
    for (axis, (low, high)) in part.iter_mut().enumerate().take(dimension) {
        let middle = 0.5 * (*low + *high);
        *if (corner >> axis) & 1 == 0 { high } else { low } = middle;
    }
    part
}

/// The product rule.
fn gauss(
    rule: &[(f64, f64)],
    bounds: &Bounds,
    dimension: usize,
    f: &mut impl FnMut(&Place) -> f64,
) -> f64 {
    let points = 2 * rule.len();
    let mut sum = 0.0;
    for k in 0..points.pow(dimension as u32) {
        let (mut x, mut weight, mut rest) = ([0.0; MOST], 1.0, k);
        for axis in 0..dimension {
            let (low, high) = bounds[axis];
            let (node, share) = rule[rest % points / 2];
            let half = 0.5 * (high - low);
            x[axis] = 0.5 * (low + high) + if rest % 2 == 0 { half * node } else { -half * node };
            weight *= share * half;
            rest /= points;
        }
        let value = f(&x);
        if !value.is_infinite() {
            sum += weight * value;
        }
    }
    sum
}

#[cfg(test)]
mod tests {
    use super::*;

    const CUBE: Bounds = [(-1.0, 1.0); MOST];

    #[test]
    fn smooth_and_singular_and_discontinuous_integrals() {
        let one = |f: &dyn Fn(f64) -> f64| {
            integrate(&[(0, CUBE)], 1, 1e-10, 100_000, |x| f(x[0])).total()
        };
        assert!((one(&|x| x.exp()) - 2.0 * 1.0_f64.sinh()).abs() < 1e-6);
        assert!((one(&|x| (x + 1.0).powf(-0.5)) - 8.0_f64.sqrt()).abs() < 1e-5);
        assert!((one(&|x| f64::from(u8::from(x > 0.3))) - 0.7).abs() < 1e-9);
        let disk = integrate(&[(0, CUBE)], 2, 1e-8, 400_000, |x| {
            f64::from(u8::from(x[0] * x[0] + x[1] * x[1] < 1.0))
        });
        assert!((disk.total() - core::f64::consts::PI).abs() < 4.0 * disk.error(), "{disk:?}");
        assert!(disk.error() < 5e-4, "{}", disk.error());
        let ball = integrate(&[(0, CUBE)], 3, 1e-8, 1_000_000, |x| {
            f64::from(u8::from(x[..3].iter().map(|x| x * x).sum::<f64>() < 1.0))
        });
        assert!((ball.total() - core::f64::consts::PI * 4.0 / 3.0).abs() < 4.0 * ball.error());
        let four = |x: &Place| x.iter().map(|x| 1.0 + 0.25 * x.powi(4)).product::<f64>();
        let smooth = integrate(&[(0, CUBE)], 4, 1e-8, 100_000, four);
        assert!((smooth.total() - 2.1_f64.powi(4)).abs() < 4.0 * smooth.error(), "{smooth:?}");
        assert!(smooth.error() < 5e-3, "{}", smooth.error());
        assert!(integrate(&[(0, CUBE)], 1, 1e-8, 1000, |_| f64::NAN).total().is_nan());
    }
}
