//! Counting: which share of a uniform passes some tests, by trying it. What is derived of atoms is compared with this.

use crate::eval::Evaluator;
use crate::expr::{Graph, Id, Leaf};
use crate::number::{Dd, Number};
use crate::points::Point;
use crate::sorted;

/// Borders are looked for between whole multiples of this inverse, and next to both ends between powers of its square.
const CELLS: i32 = 32;
/// The smallest of these powers. What is nearer to an end belongs to the last cell.
const LAST: i32 = 60;
/// Halvings of a cell, after which nothing is left of it in double-double.
const HALVINGS: usize = 100;

/// Tests of one uniform, at given parameters.
pub(super) struct Tried<'a> {
    /// The expressions.
    pub graph: &'a Graph,
    /// What must not be negative.
    pub tests: &'a [Id],
    /// The uniform.
    pub uniform: Leaf,
    /// The parameters.
    pub point: &'a Point,
}

impl Tried<'_> {
    fn passes(&self, tests: &[Id], u: Dd) -> bool {
        let at = |leaf: Leaf| if leaf == self.uniform { u } else { self.point.input(leaf, &[]) };
        let mut e = Evaluator::<Dd>::new(self.graph, &at);
        tests.iter().all(|test| e.value(*test).to_f64() >= 0.0)
    }

    /// Where between two uniforms, of which only one passes a test, this changes.
    fn border(&self, test: Id, mut low: Dd, mut high: Dd) -> Dd {
        let below = self.passes(&[test], low);
        for _ in 0..HALVINGS {
            let middle = (low + high) * Dd::from_f64(0.5);
            if self.passes(&[test], middle) == below {
                low = middle;
            } else {
                high = middle;
            }
        }
        high
    }

    /// The borders of a test, in order.
    pub(super) fn borders(&self, test: Id) -> Vec<Dd> {
        let one = Dd::from_f64(1.0);
        let small =
            (1..=LAST / 10).rev().map(|k| 10 * k).map(|k| Dd::from_f64(libm::exp2(f64::from(-k))));
        let middle = (1..CELLS).map(|k| Dd::from_ratio(i128::from(k), i128::from(CELLS)));
        let large =
            (1..=LAST / 10).map(|k| 10 * k).map(|k| one - Dd::from_f64(libm::exp2(f64::from(-k))));
        let tried: Vec<(Dd, bool)> =
            small.chain(middle).chain(large).map(|u| (u, self.passes(&[test], u))).collect();
        let pairs = tried.windows(2).filter(|pair| pair[0].1 != pair[1].1);
        pairs.map(|pair| self.border(test, pair[0].0, pair[1].0)).collect()
    }

    /// The measure of the uniforms that pass all tests.
    pub(super) fn share(&self) -> f64 {
        let mut ends: Vec<Dd> = self.tests.iter().flat_map(|t| self.borders(*t)).collect();
        ends.extend([0.0, 1.0].map(Dd::from_f64));
        sorted::sort_by(&mut ends, |a, b| (*a - *b).to_f64().total_cmp(&0.0));
        let zero = Dd::from_f64(0.0);
        ends.windows(2)
            .fold(zero, |sum, ends| {
                let middle = (ends[0] + ends[1]) * Dd::from_f64(0.5);
                if self.passes(self.tests, middle) { sum + (ends[1] - ends[0]) } else { sum }
            })
            .to_f64()
    }
}
