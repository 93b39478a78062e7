//! Where a function of one variable turns back, whatever the other inputs in their domains.
//!
//! The range of the variable is cut at fixed places into cells. In the simplest cell the slope has one sign. In a cell
//! of order one the slope has at most one zero, and crosses it in a known direction: that is so if its own slope has a
//! known sign wherever the slope vanishes. In a cell of order two that holds of the slope's slope, so that the slope has
//! at most two zeros, on both sides of that of the slope's slope; and so on. Where a zero lies may depend on the other
//! inputs, and whether there is one: then that end of the cell counts that is nearest to one.
//!
//! Each of this is proven as in [`monotone`](crate::monotone): the box of all inputs is halved until interval arithmetic
//! shows it on every part. All is bounded by counts.

use crate::derivative::derivative;
use crate::enclosure::Enclosure;
use crate::enclosure::unbroken::is_plain;
use crate::eval::evaluate;
use crate::expr::{Graph, Id, Leaf};
use crate::interval::Interval;
use crate::jacobian::{cost, simplify};
use crate::monotone::{Proof, Unproven, centre, halves, inside, leaves_of, unproven};

/// The highest order of a cell that is tried if cells of order one are not enough.
const MOST: usize = 3;
/// How often the range is halved.
const DEPTH: usize = 7;
/// Parts of the box that are looked at for one statement on one cell.
const PARTS: usize = 1000;
/// Intervals that may be computed for all of them together.
const INTERVALS: usize = 400_000;
/// Values of the other inputs for which the sign of a slope is looked at before a proof is tried.
const DRAWS: u32 = 12;
/// Places of the variable for each of them.
const PLACES: u32 = 16;

/// A part of the variable's range in which little is left open.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct Cell {
    /// The part.
    pub range: Interval,
    /// Zero: the slope has one sign. Else: the derivative of the slope of one order less has at most one zero.
    pub order: usize,
    /// The sign of the slope, or the direction in which that derivative crosses zero.
    pub sign: i64,
}

/// The slope of a function and its derivatives, as many as cells may be of.
pub fn tower(g: &mut Graph, body: Id, variable: Leaf) -> Vec<Id> {
    let mut all = Vec::new();
    let mut current = body;
    for _ in 0..=MOST {
        let slope = derivative(g, current, variable);
        let tidy = simplify(g, slope, None);
        current = if cost(g, tidy) <= cost(g, slope) { tidy } else { slope };
        all.push(current);
    }
    all
}

/// The cells of the whole range of a variable, from below, neighbours being unlike; or what could not be shown.
pub fn cells(g: &mut Graph, body: Id, variable: Leaf) -> Result<Vec<Cell>, Unproven> {
    let mut search = Search::new(g, body, variable);
    if !is_plain(g, body, variable) {
        return Err(unproven(g, &search.leaves, &search.box_of(g, g.leaf_range(variable))));
    }
    let found = search.cells(g, 1).or_else(|_| search.cells(g, MOST))?;
    Ok(merged(found))
}

struct Search {
    body: Id,
    variable: Leaf,
    /// The slope and its derivatives.
    tower: Vec<Id>,
    /// The inputs, the variable first.
    leaves: Vec<Leaf>,
    /// For each of the tower, that it is not negative, and that it is not positive; made when they are asked for.
    proofs: Vec<[Option<Proof>; 2]>,
    /// Intervals that may still be computed.
    left: usize,
}

impl Search {
    fn new(g: &mut Graph, body: Id, variable: Leaf) -> Search {
        let tower = tower(g, body, variable);
        let proofs = tower.iter().map(|_| [None, None]).collect();
        let leaves = leaves_of(g, body, variable);
        Search { body, variable, tower, leaves, proofs, left: INTERVALS }
    }

    /// A box with this range of the variable.
    fn box_of(&self, g: &Graph, cell: Interval) -> Vec<Interval> {
        let others = self.leaves[1..].iter().map(|l| g.leaf_range(*l));
        std::iter::once(cell).chain(others).collect()
    }

    /// Cells of up to this order, each as large as halving allows.
    fn cells(&mut self, g: &mut Graph, most: usize) -> Result<Vec<Cell>, Unproven> {
        let mut open = vec![(g.leaf_range(self.variable), 0)];
        let mut found = Vec::new();
        while let Some((range, depth)) = open.pop() {
            if let Some((order, sign)) = (0..=most).find_map(|k| Some((k, self.sign(g, range, k)?)))
            {
                found.push(Cell { range, order, sign });
                continue;
            }
            let c = centre(range);
            if depth == DEPTH || self.left == 0 || c <= range.lo || c >= range.hi {
                return Err(unproven(g, &self.leaves, &self.box_of(g, range)));
            }
            open.push((Interval::new(c, range.hi), depth + 1));
            open.push((Interval::new(range.lo, c), depth + 1));
        }
        Ok(found)
    }

    /// The sign with which a range is a cell of this order, if it is shown to be one.
    fn sign(&mut self, g: &mut Graph, range: Interval, order: usize) -> Option<i64> {
        let sign = self.seen(g, range, order)?;
        self.is_cell(g, range, order, sign).then_some(sign)
    }

    /// The sign with which a range may be a cell of this order, by values at some points; `None` if they speak against it.
    fn seen(&self, g: &Graph, range: Interval, order: usize) -> Option<i64> {
        let (mut signs, mut smallest) = ([false; 2], (f64::INFINITY, 0.0));
        let watched = self.tower[order.saturating_sub(1)];
        for n in 0..DRAWS {
            // The first two are next to the corners of the domain; then sequences that do not repeat.
            let share = |k: usize| match n {
                0 | 1 => (f64::from(n) - 1e-3).abs(),
                _ => (0.5 + f64::from(n) * (k as f64 + 2.0).ln()).fract(),
            };
            let mut last = 0.0;
            for i in 0..PLACES {
                let t = inside(range, (f64::from(i) + 0.5) / f64::from(PLACES));
                let at = |l: Leaf| match self.leaves.iter().position(|k| *k == l) {
                    Some(0) => t,
                    Some(k) => inside(g.leaf_range(l), share(k)),
                    None => f64::NAN,
                };
                let value = evaluate::<f64>(g, watched, &at);
                if value.is_nan() || value == 0.0 {
                    continue;
                }
                if order == 0 {
                    signs[usize::from(value < 0.0)] = true;
                } else if value.signum() == -last {
                    // Across a zero downwards the derivative of what is watched is negative.
                    signs[usize::from(value < 0.0)] = true;
                }
                if order > 0 && value.abs() < smallest.0 {
                    smallest = (value.abs(), evaluate::<f64>(g, self.tower[order], &at));
                }
                last = value.signum();
            }
        }
        match signs {
            [true, false] => Some(1),
            [false, true] => Some(-1),
            [false, false] if smallest.1 != 0.0 && !smallest.1.is_nan() => {
                Some(smallest.1.signum() as i64)
            }
            _ => None,
        }
    }

    /// Whether it is proven that a derivative of the slope has this sign wherever the one before, if there is one, is
    /// zero; and that all is continuous.
    fn is_cell(&mut self, g: &mut Graph, range: Interval, order: usize, sign: i64) -> bool {
        self.prepare(g, order, sign);
        let below = order.checked_sub(1);
        let of = |k: usize, sign: i64| self.proofs[k][usize::from(sign < 0)].as_ref();
        let Some(proof) = of(order, sign) else { return false };
        let watched = below.and_then(|k| of(k, 1));
        let continuous: Vec<Id> =
            std::iter::once(self.body).chain(self.tower[..order].iter().copied()).collect();
        let continuous = Enclosure::new(g, &continuous, &self.leaves);
        let work = continuous.len() + proof.len();
        let shown = |part: &[Interval]| {
            let signed = |w: &Proof| {
                let values = w.values(part);
                values.lo > 0.0 || values.hi < 0.0
            };
            (watched.is_some_and(signed) || proof.shown(part)) && continuous.over(part).unbroken()
        };
        // Breadth first, so that what cannot be shown is given up soon.
        let mut open = std::collections::VecDeque::from([self.box_of(g, range)]);
        let mut parts = 0;
        while let Some(part) = open.pop_front() {
            parts += 1;
            self.left = self.left.saturating_sub(work);
            if shown(&part) {
                if order == 0 && !proof.positive_somewhere(g, &part) {
                    return false;
                }
                continue;
            }
            let allowed = parts < PARTS && self.left > 0;
            let Some((left, right)) = halves(&part, parts).filter(|_| allowed) else {
                return false;
            };
            open.extend([left, right]);
        }
        true
    }

    /// Makes the proofs that a cell of this order and sign needs.
    fn prepare(&mut self, g: &mut Graph, order: usize, sign: i64) {
        let watched = order.checked_sub(1).map(|k| (k, 1));
        for (k, sign) in watched.into_iter().chain([(order, sign)]) {
            let place = usize::from(sign < 0);
            if self.proofs[k][place].is_none() {
                let upward = if sign < 0 { g.neg(self.tower[k]) } else { self.tower[k] };
                let proof = Proof::new(g, upward, self.variable, self.leaves.clone(), false);
                self.proofs[k][place] = Some(proof);
            }
        }
    }
}

/// Cells with those that are alike taken together, and of order zero where their neighbours tell.
fn merged(mut cells: Vec<Cell>) -> Vec<Cell> {
    loop {
        let before = cells.len();
        cells.dedup_by(|next, cell| {
            let alike = (next.order, next.sign) == (cell.order, cell.sign);
            if alike {
                cell.range.hi = next.range.hi;
            }
            alike
        });
        let mut changed = cells.len() != before;
        for i in 0..cells.len() {
            let Cell { order, sign, .. } = cells[i];
            let plain = |cell: Option<&Cell>, sign: i64| {
                cell.is_some_and(|c| (c.order, c.sign) == (0, sign))
            };
            // Beyond its zero the slope has the sign with which it crosses it, and before it the other one.
            let told = if order != 1 {
                None
            } else if i > 0 && plain(cells.get(i - 1), sign) {
                Some(sign)
            } else if plain(cells.get(i + 1), -sign) {
                Some(-sign)
            } else {
                None
            };
            if let Some(sign) = told {
                cells[i] = Cell { order: 0, sign, ..cells[i] };
                changed = true;
            }
        }
        if !changed {
            return cells;
        }
    }
}

#[cfg(test)]
mod tests;
