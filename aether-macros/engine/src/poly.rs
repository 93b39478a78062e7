//! Polynomials and rational functions over atoms: multiplying out, cancelling, factoring.
//!
//! An atom is anything that is not a sum or a product: an input, a function call, a root. Squares
//! of square roots and of cosines are reduced, and a caller may add relations of his own (the
//! coordinates of a direction have squares that add up to one).

mod collect;
mod dependence;
mod factor;
mod monomial;
mod pairs;
mod ratfun;
mod written;

use std::rc::Rc;

use crate::expr::{Deps, Id};
use crate::hash::Map;
use crate::rational::Q;
use crate::sorted;
use monomial::{half, merge, over, times};

pub use collect::{coefficients, gathered};
pub use dependence::{parts_of_one, relation};
pub use pairs::paired;
pub use ratfun::{Expander, RatFun};

/// A monomial: (atom, exponent) pairs, largest atom first; exponents positive. Polynomials share it.
type Mono = Rc<[(Id, u32)]>;

/// A polynomial with rational coefficients: its terms by monomial in lexicographic order, each monomial
/// once and no coefficient zero. Multiplying by a monomial keeps the order.
#[derive(Clone, PartialEq, Debug, Default)]
pub struct Poly(Vec<(Mono, Q)>);

/// Work limit: polynomials with more terms than this are given up.
const MAX_TERMS: usize = 120;

thread_local! {
    /// Steps that may still be spent on polynomials for the item at hand.
    static BUDGET: std::cell::Cell<u64> = const { std::cell::Cell::new(u64::MAX) };
}

/// Steps (products of terms) for one item. Counted, not timed, so the outcome is the same everywhere;
/// what is not simplified within the budget is emitted as derived.
const STEPS: u64 = 400_000;

/// Starts the budget of an item.
pub fn start_budget() {
    BUDGET.set(STEPS);
}

/// Leaves at least one of `parts` of the budget to what follows, whatever was spent before.
pub fn refill_budget(parts: u64) {
    BUDGET.set(BUDGET.get().max(STEPS / parts));
}

/// Does some work with one of `parts` of what is left of the budget.
pub(crate) fn within_part_of_budget<T>(parts: u64, work: impl FnOnce() -> T) -> T {
    let left = BUDGET.get();
    BUDGET.set(left / parts);
    let result = work();
    let spent = left / parts - BUDGET.get();
    BUDGET.set(left - spent);
    result
}

/// Leaves nothing of the budget, as a costly item does.
#[cfg(test)]
pub(crate) fn use_up_budget() {
    BUDGET.set(0);
}

/// Takes steps from the budget; `None` when it is used up.
fn spend(steps: u64) -> Option<()> {
    let left = BUDGET.get().checked_sub(steps);
    BUDGET.set(left.unwrap_or(0));
    left.map(drop)
}

/// A result with the steps that it took. Whoever meets it again spends them again, so that the budget
/// bounds the search and not only the arithmetic.
type Taken<T> = (Option<T>, u64);

/// The result of `work` and what it took, or nothing if the budget ended on the way.
fn metered<T>(work: impl FnOnce() -> Option<T>) -> (Option<T>, Option<u64>) {
    let before = BUDGET.get();
    let result = work();
    let left = BUDGET.get();
    (result, (left > 0).then_some(before - left))
}

/// What expressions are as rational functions, without relations of the caller's: by expression and
/// the inputs that sums are multiplied out for.
#[derive(Clone, Default)]
pub struct Known {
    functions: Map<(Id, Deps), Taken<RatFun>>,
    normal: Map<(Id, Deps), Taken<Id>>,
}

impl Poly {
    /// A single term.
    fn term(m: Mono, q: Q) -> Poly {
        if q.is_zero() { Poly::default() } else { Poly(vec![(m, q)]) }
    }
    /// A constant.
    pub fn constant(q: Q) -> Poly {
        Poly::term([].into(), q)
    }
    /// A single atom.
    pub fn atom(a: Id) -> Poly {
        Poly::term([(a, 1)].into(), Q::ONE)
    }
    /// Whether this is the zero polynomial.
    pub fn is_zero(&self) -> bool {
        self.0.is_empty()
    }
    /// Number of terms.
    pub fn len(&self) -> usize {
        self.0.len()
    }
    /// Whether there are no terms.
    pub fn is_empty(&self) -> bool {
        self.0.is_empty()
    }
    /// The value, if it is a constant.
    pub fn as_constant(&self) -> Option<Q> {
        match self.0.len() {
            0 => Some(Q::ZERO),
            1 => self.0[0].0.is_empty().then_some(self.0[0].1),
            _ => None,
        }
    }
    /// Sum.
    pub fn add(&self, o: &Poly) -> Option<Poly> {
        spend((self.len() + o.len()) as u64)?;
        let r = merge(&self.0, &o.0)?;
        (r.len() <= MAX_TERMS).then_some(Poly(r))
    }
    /// Multiple.
    pub fn scale(&self, k: Q) -> Option<Poly> {
        if k == Q::ONE {
            return Some(self.clone());
        }
        self.times_term(&[].into(), k)
    }
    /// Product with one term.
    fn times_term(&self, m: &Mono, k: Q) -> Option<Poly> {
        if k.is_zero() {
            return Some(Poly::default());
        }
        let mut r = Vec::with_capacity(self.len());
        for (n, q) in &self.0 {
            r.push((times(m, n), q.mul(k)?));
        }
        Some(Poly(r))
    }
    /// Difference.
    pub fn sub(&self, o: &Poly) -> Option<Poly> {
        self.add(&o.scale(Q::int(-1))?)
    }
    /// Product, before any relation is applied.
    pub fn mul(&self, o: &Poly) -> Option<Poly> {
        spend((self.len() * o.len()) as u64)?;
        let mut r = Vec::new();
        for (m, q) in &self.0 {
            r = merge(&r, &o.times_term(m, *q)?.0)?;
            if r.len() > 4 * MAX_TERMS {
                return None;
            }
        }
        (r.len() <= MAX_TERMS).then_some(Poly(r))
    }
    /// Power.
    pub fn powi(&self, n: u32) -> Option<Poly> {
        (0..n).try_fold(Poly::constant(Q::ONE), |p, _| p.mul(self))
    }
    /// The quotient, if the division leaves no remainder.
    pub fn exact_div(&self, d: &Poly) -> Option<Poly> {
        let (lead, k) = d.0.last()?;
        let over_k = k.recip()?;
        let mut rest = self.clone();
        let mut quotient = Vec::new();
        for _ in 0..4 * MAX_TERMS {
            let Some((m, q)) = rest.0.last() else {
                quotient.reverse();
                return (quotient.len() <= MAX_TERMS).then_some(Poly(quotient));
            };
            let (m, q) = (over(m, lead)?, q.mul(over_k)?);
            spend((rest.len() + 2 * d.len() + quotient.len() + 1) as u64)?;
            let taken = d.times_term(&m, q.neg())?;
            rest = Poly(merge(&rest.0, &taken.0)?);
            if rest.len() > MAX_TERMS {
                return None;
            }
            // Leading terms only get smaller.
            quotient.push((m, q));
        }
        None
    }
    /// The polynomial whose square this is, with a positive leading coefficient.
    pub fn sqrt(&self) -> Option<Poly> {
        let (lead, k) = self.0.last()?;
        let mut root = Poly::term(half(lead)?, k.sqrt()?);
        let twice = root.scale(Q::int(2))?;
        let (m2, k2) = twice.0.last()?;
        for _ in 0..MAX_TERMS {
            let rest = self.sub(&root.mul(&root)?)?;
            let Some((m, q)) = rest.0.last() else { return Some(root) };
            let t = Poly::term(over(m, m2)?, q.mul(k2.recip()?)?);
            root = root.add(&t)?;
        }
        None
    }
    /// The coefficients as a polynomial in one atom, lowest degree first.
    pub fn by_powers_of(&self, x: Id) -> Option<Vec<Poly>> {
        let mut out: Vec<Poly> = Vec::new();
        for (m, q) in &self.0 {
            let degree = m.iter().find(|(a, _)| *a == x).map_or(0, |(_, e)| *e as usize);
            let rest: Mono = m.iter().copied().filter(|(a, _)| *a != x).collect();
            if out.len() <= degree {
                out.resize(degree + 1, Poly::default());
            }
            out[degree] = out[degree].add(&Poly::term(rest, *q))?;
        }
        Some(out)
    }
    /// Whether an atom occurs.
    fn contains(&self, x: Id) -> bool {
        self.0.iter().any(|(m, _)| m.iter().any(|(a, _)| *a == x))
    }
    /// The atoms that occur.
    pub fn atoms(&self) -> Vec<Id> {
        let mut a: Vec<Id> = self.0.iter().flat_map(|(m, _)| m.iter()).map(|(a, _)| *a).collect();
        sorted::sort(&mut a);
        a.dedup();
        a
    }
    /// Splits off the largest monomial and rational content that divide every term.
    fn content(&self) -> (Q, Mono, Poly) {
        let Some((first, k)) = self.0.last() else {
            return (Q::ONE, [].into(), self.clone());
        };
        let mut common = first.to_vec();
        for (m, _) in &self.0 {
            if common.is_empty() {
                break;
            }
            common.retain_mut(|(a, e)| match m.iter().find(|(b, _)| b == a) {
                Some((_, other)) => {
                    *e = (*e).min(*other);
                    true
                }
                None => false,
            });
        }
        // The divisor of all coefficients, with a sign that leaves the leading one positive; if there is
        // a constant term, that one.
        let size = self.integral().map_or(Q::ONE, |(size, _)| size);
        let sign = self.0.iter().find(|(m, _)| m.is_empty()).map_or(*k, |(_, q)| *q);
        let k = if sign.is_negative() { size.neg() } else { size };
        let rest = self
            .0
            .iter()
            .filter_map(|(m, q)| Some((over(m, &common)?, q.mul(k.recip()?)?)))
            .collect();
        (k, common.into(), Poly(rest))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::expr::{Graph, Leaf};
    use crate::interval::Interval;

    fn three() -> (Graph, Id, Id, Id) {
        let mut g = Graph::new();
        let a = g.leaf(Leaf::Param(0), "a", Interval::ALL);
        let b = g.leaf(Leaf::Param(1), "b", Interval::ALL);
        let x = g.leaf(Leaf::Out(0), "x", Interval::ALL);
        (g, a, b, x)
    }

    #[test]
    fn the_linear_density_inverse_cancels() {
        // ((a + x(b-a))² - a²) / (b² - a²) = x (2a + x(b-a)) / (a+b)
        let (mut g, a, b, x) = three();
        let d = g.sub(b, a);
        let xd = g.mul(x, d);
        let t = g.add(a, xd);
        let t2 = g.powi(t, 2);
        let a2 = g.powi(a, 2);
        let b2 = g.powi(b, 2);
        let top = g.sub(t2, a2);
        let bottom = g.sub(b2, a2);
        let q = g.div(top, bottom);
        let r = Expander::new(&mut g).expand(q).unwrap();
        assert_eq!(r.den.len(), 1, "only a + b is left below: {r:?}");
    }

    #[test]
    fn a_square_is_recognised() {
        let (mut g, a, b, x) = three();
        let xb = g.mul(x, b);
        let s = g.add(a, xb);
        let s2 = g.powi(s, 2);
        let p = Expander::new(&mut g).expand(s2).unwrap().num;
        let root = p.sqrt().unwrap();
        assert_eq!(root.mul(&root), Some(p));
    }

    #[test]
    fn direction_coordinates_reduce() {
        let (mut g, a, b, x) = three();
        let terms: Vec<(Q, Id)> = [a, b, x].map(|c| (Q::ONE, g.powi(c, 2))).to_vec();
        let s = g.sum(Q::ZERO, &terms);
        let id = Expander::new(&mut g).unit([a, b, x]).normal_form(s).unwrap();
        // Relations apply to products; a bare square is a product of two atoms.
        assert_eq!(g.as_number(id), Some(Q::ONE));
    }
}
