//! The measure of the uniforms that lead to an atom, to the continuous part, or nowhere.

use std::collections::BTreeMap;

/// Where uniforms lead.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum End {
    /// There is no sample.
    Nothing,
    /// To a point that has a density.
    Continuous,
    /// To the atom with this number.
    Atom(usize),
}

/// Uniforms, and where they lead.
pub(super) type Led = (Vec<f64>, End);

/// Borders across one axis, at most: more are no borders of boxes, but follow something oblique.
const MOST_BORDERS: usize = 40;
/// Cells between the borders, at most.
const MOST_CELLS: usize = 1 << 14;
/// How many lines along each axis are searched, at most.
const MOST_LINES: usize = 64;
/// Steps of a line's search, but for those at its ends.
const STEPS: i32 = 256;

/// The measure of each end, where borders between ends are perpendicular to the axes of the uniforms, as those are that
/// come from tests of one uniform each; `None` where they are not.
///
/// Borders are found to the last digit by bisection along lines through `known` uniforms, which then have to lie in a cell
/// of their end: a line through one that does not finds more borders.
pub(super) fn measures(
    end: &dyn Fn(&[f64]) -> End,
    known: &[Led],
    epsilon: f64,
) -> Option<BTreeMap<End, f64>> {
    let axes = known.first()?.0.len();
    let mut borders = vec![Vec::new(); axes];
    let mut next = 0;
    for _ in 0..MOST_LINES {
        for (axis, borders) in borders.iter_mut().enumerate() {
            along(end, &known[next].0, axis, borders);
            borders.sort_by(f64::total_cmp);
            borders.dedup_by(|b, a| *b - *a <= 4.0 * epsilon);
            if borders.len() > MOST_BORDERS {
                return None;
            }
        }
        let cells = Cells::new(&borders, end)?;
        match known.iter().position(|led| cells.contradict(led, epsilon)) {
            Some(led) => next = led,
            None => return Some(cells.measures()),
        }
    }
    None
}

/// Appends the borders along one axis through `u`.
fn along(end: &dyn Fn(&[f64]) -> End, u: &[f64], axis: usize, borders: &mut Vec<f64>) {
    let mut v = u.to_vec();
    let mut at = |t: f64| {
        v[axis] = t;
        end(&v)
    };
    let last = 1.0 - 0.5 * f64::EPSILON;
    let inner = (1..STEPS).map(|k| f64::from(k) / f64::from(STEPS));
    let ends = (9..52).map(|k| 0.5f64.powi(k)).flat_map(|small| [small, 1.0 - small]);
    let mut steps: Vec<f64> = inner.chain(ends).chain([0.0, u[axis], last]).collect();
    steps.sort_by(f64::total_cmp);
    for pair in steps.windows(2) {
        let (mut low, high) = (pair[0], pair[1]);
        let (mut before, after) = (at(low), at(high));
        // There may be others between two numbers that lead to different ends.
        for _ in 0..8 {
            if before == after {
                break;
            }
            low = border(&mut at, (low, high), before);
            borders.push(low);
            before = at(low);
        }
    }
}

/// The least number in an interval, up to rounding, that does not lead to the same end as its lower one.
fn border(at: &mut dyn FnMut(f64) -> End, interval: (f64, f64), before: End) -> f64 {
    let (mut low, mut high) = interval;
    for _ in 0..128 {
        let middle = 0.5 * (low + high);
        if middle <= low || middle >= high {
            break;
        }
        *(if at(middle) == before { &mut low } else { &mut high }) = middle;
    }
    high
}

/// The boxes between borders.
struct Cells<'a> {
    borders: &'a [Vec<f64>],
    ends: Vec<End>,
}

impl<'a> Cells<'a> {
    /// Each with the end that its middle leads to; `None` if there are too many.
    fn new(borders: &'a [Vec<f64>], end: &dyn Fn(&[f64]) -> End) -> Option<Self> {
        let count = borders
            .iter()
            .try_fold(1_usize, |count, b| count.checked_mul(b.len() + 1))
            .filter(|count| *count <= MOST_CELLS)?;
        let mut cells = Cells { borders, ends: Vec::new() };
        let middle = |(low, high): (f64, f64)| 0.5 * (low + high);
        let ends = (0..count).map(|k| {
            let u: Vec<f64> = cells.bounds(k).into_iter().map(middle).collect();
            end(&u)
        });
        cells.ends = ends.collect();
        Some(cells)
    }

    /// Where a cell lies.
    fn bounds(&self, mut number: usize) -> Vec<(f64, f64)> {
        let bound = |b: &Vec<f64>| {
            let k = number % (b.len() + 1);
            number /= b.len() + 1;
            let low = if k == 0 { 0.0 } else { b[k - 1] };
            (low, b.get(k).copied().unwrap_or(1.0))
        };
        self.borders.iter().map(bound).collect()
    }

    /// Whether uniforms lead elsewhere than their cell, and do not lie on a border of it within rounding.
    fn contradict(&self, (u, end): &Led, epsilon: f64) -> bool {
        let number = self.borders.iter().zip(u).rev().fold(0, |number, (b, u)| {
            number * (b.len() + 1) + b.partition_point(|border| border <= u)
        });
        let on_border =
            |(b, u): (&Vec<f64>, &f64)| b.iter().any(|b| (b - u).abs() <= 8.0 * epsilon);
        self.ends[number] != *end && !self.borders.iter().zip(u).any(on_border)
    }

    /// The measure of each end.
    fn measures(&self) -> BTreeMap<End, f64> {
        let mut sums = BTreeMap::new();
        for (number, end) in self.ends.iter().enumerate() {
            let volume: f64 = self.bounds(number).iter().map(|(low, high)| high - low).product();
            *sums.entry(*end).or_insert(0.0) += volume;
        }
        sums
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::uniform::{Pcg32, UniformSource};

    /// Uniforms at random, and where they lead.
    fn led(end: &dyn Fn(&[f64]) -> End, axes: usize) -> Vec<Led> {
        let mut source = Pcg32::new(1, 0, 0);
        let mut u = || (0..axes).map(|_| UniformSource::<f64>::next(&mut source)).collect();
        (0..10_000).map(|_| u()).map(|u: Vec<f64>| (u.clone(), end(&u))).collect()
    }

    #[test]
    fn boxes_are_measured_to_the_last_digits() {
        // A corner, a thin slab that no line meets by chance, and another way to the first.
        let boxes = |u: &[f64]| match u {
            [a, b] if *a < 0.3 && *b < 0.7 => End::Atom(4),
            [a, b] if *a > 0.6 && *b > 0.55 && *b < 0.551 => End::Atom(1),
            [a, _] if *a < 0.3 => End::Nothing,
            [_, b] if *b > 0.9 => End::Atom(4),
            _ => End::Continuous,
        };
        let found = measures(&boxes, &led(&boxes, 2), f64::EPSILON).expect("boxes");
        let expected = [(End::Nothing, 0.09), (End::Atom(4), 0.21 + 0.07), (End::Atom(1), 4e-4)];
        for (end, measure) in expected {
            assert!((found[&end] - measure).abs() < 1e-14, "{end:?}: {}", found[&end]);
        }
        assert!((found.values().sum::<f64>() - 1.0).abs() < 1e-14);
    }

    #[test]
    fn what_is_no_box_is_not_measured() {
        let oblique = |u: &[f64]| if u[0] + u[1] < 1.0 { End::Nothing } else { End::Continuous };
        assert!(measures(&oblique, &led(&oblique, 2), f64::EPSILON).is_none());
    }
}
