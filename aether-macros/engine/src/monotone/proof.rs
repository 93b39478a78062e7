//! Proofs by interval arithmetic on parts of a box that a slope is not negative.

use super::leaves::centre;
use super::{Unproven, unproven};
use crate::derivative::derivative;
use crate::enclosure::{Enclosure, Over};
use crate::expr::{Graph, Id, Leaf};
use crate::interval::Interval;
use crate::jacobian::simplify;

/// Parts of the box that are looked at before a proof is given up.
const MAX_PARTS: usize = 3000;

/// Derivatives of the slope that are tried.
const ORDERS: usize = 3;

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

    pub(super) fn run(&self, g: &Graph) -> Result<(), Unproven> {
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
