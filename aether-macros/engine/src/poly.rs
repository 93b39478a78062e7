//! Polynomials and rational functions over atoms: multiplying out, cancelling, factoring.
//!
//! An atom is anything that is not a sum or a product: an input, a function call, a root. Squares
//! of square roots and of cosines are reduced, and a caller may add relations of his own (the
//! coordinates of a direction have squares that add up to one).

mod ratfun;

use std::collections::BTreeMap;

use crate::expr::{Graph, Id};
use crate::rational::Q;

pub use ratfun::{Expander, RatFun};

/// A monomial: (atom, exponent) pairs, largest atom first; exponents positive.
type Mono = Vec<(Id, u32)>;

/// A polynomial with rational coefficients, by monomial in lexicographic order.
#[derive(Clone, PartialEq, Debug, Default)]
pub struct Poly(BTreeMap<Mono, Q>);

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

/// Takes steps from the budget; `None` when it is used up.
fn spend(steps: usize) -> Option<()> {
    let left = BUDGET.get().checked_sub(steps as u64);
    BUDGET.set(left.unwrap_or(0));
    left.map(drop)
}

impl Poly {
    /// A constant.
    pub fn constant(q: Q) -> Poly {
        let mut p = Poly::default();
        if !q.is_zero() {
            p.0.insert(Vec::new(), q);
        }
        p
    }
    /// A single atom.
    pub fn atom(a: Id) -> Poly {
        Poly(BTreeMap::from([(vec![(a, 1)], Q::ONE)]))
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
            1 => self.0.get(&Vec::new()).copied(),
            _ => None,
        }
    }
    /// Sum.
    pub fn add(&self, o: &Poly) -> Option<Poly> {
        spend(self.len() + o.len())?;
        let mut r = self.clone();
        for (m, q) in &o.0 {
            let e = r.0.entry(m.clone()).or_insert(Q::ZERO);
            *e = e.add(*q)?;
        }
        r.0.retain(|_, q| !q.is_zero());
        (r.len() <= MAX_TERMS).then_some(r)
    }
    /// Multiple.
    pub fn scale(&self, k: Q) -> Option<Poly> {
        let mut r = Poly::default();
        for (m, q) in &self.0 {
            r.0.insert(m.clone(), q.mul(k)?);
        }
        r.0.retain(|_, q| !q.is_zero());
        Some(r)
    }
    /// Difference.
    pub fn sub(&self, o: &Poly) -> Option<Poly> {
        self.add(&o.scale(Q::int(-1))?)
    }
    /// Product, before any relation is applied.
    pub fn mul(&self, o: &Poly) -> Option<Poly> {
        spend(self.len() * o.len())?;
        let mut r = Poly::default();
        for (m, q) in &self.0 {
            for (n, p) in &o.0 {
                let e = r.0.entry(times(m, n)).or_insert(Q::ZERO);
                *e = e.add(q.mul(*p)?)?;
            }
            if r.len() > 4 * MAX_TERMS {
                return None;
            }
        }
        r.0.retain(|_, q| !q.is_zero());
        (r.len() <= MAX_TERMS).then_some(r)
    }
    /// Power.
    pub fn powi(&self, n: u32) -> Option<Poly> {
        (0..n).try_fold(Poly::constant(Q::ONE), |p, _| p.mul(self))
    }
    /// The quotient, if the division leaves no remainder.
    pub fn exact_div(&self, d: &Poly) -> Option<Poly> {
        let (lead, k) = d.0.iter().next_back()?;
        let mut rest = self.clone();
        let mut quotient = Poly::default();
        for _ in 0..4 * MAX_TERMS {
            let Some((m, q)) = rest.0.iter().next_back() else { return Some(quotient) };
            let t = Poly(BTreeMap::from([(over(m, lead)?, q.mul(k.recip()?)?)]));
            rest = rest.sub(&t.mul(d)?)?;
            quotient = quotient.add(&t)?;
        }
        None
    }
    /// The polynomial whose square this is, with a positive leading coefficient.
    pub fn sqrt(&self) -> Option<Poly> {
        let (lead, k) = self.0.iter().next_back()?;
        let half: Option<Mono> =
            lead.iter().map(|(a, e)| (e % 2 == 0).then_some((*a, e / 2))).collect();
        let mut root = Poly(BTreeMap::from([(half?, k.sqrt()?)]));
        let twice = root.scale(Q::int(2))?;
        let (m2, k2) = twice.0.iter().next_back().map(|(m, q)| (m.clone(), *q))?;
        for _ in 0..MAX_TERMS {
            let rest = self.sub(&root.mul(&root)?)?;
            let Some((m, q)) = rest.0.iter().next_back() else { return Some(root) };
            let t = Poly(BTreeMap::from([(over(m, &m2)?, q.mul(k2.recip()?)?)]));
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
            out[degree] = out[degree].add(&Poly(BTreeMap::from([(rest, *q)])))?;
        }
        Some(out)
    }
    /// The atoms that occur.
    pub fn atoms(&self) -> Vec<Id> {
        let mut a: Vec<Id> = self.0.keys().flatten().map(|(a, _)| *a).collect();
        a.sort();
        a.dedup();
        a
    }
    /// Splits off the largest monomial and rational content that divide every term.
    fn content(&self) -> (Q, Mono, Poly) {
        let Some((first, k)) = self.0.iter().next_back() else {
            return (Q::ONE, Vec::new(), self.clone());
        };
        let mut common = first.clone();
        for m in self.0.keys() {
            common = common
                .iter()
                .filter_map(|(a, e)| {
                    let other = m.iter().find(|(b, _)| b == a).map_or(0, |(_, e)| *e);
                    (other > 0).then_some((*a, (*e).min(other)))
                })
                .collect();
        }
        let k = if self.0.values().all(|q| q.abs() == k.abs()) || self.0.len() == 1 {
            *k
        } else {
            Q::ONE
        };
        let rest = self
            .0
            .iter()
            .filter_map(|(m, q)| Some((over(m, &common)?, q.mul(k.recip()?)?)))
            .collect();
        (k, common, Poly(rest))
    }
    /// The terms as (coefficient, product of atoms) pairs.
    pub fn terms(&self, g: &mut Graph) -> Vec<(Q, Id)> {
        let mut out = Vec::new();
        for (m, q) in &self.0 {
            let f: Vec<_> = m.iter().map(|(a, e)| (*a, g.int(i64::from(*e)))).collect();
            out.push((*q, g.product(&f)));
        }
        out
    }
    /// The expression, with common factors taken out.
    pub fn to_expr(&self, g: &mut Graph) -> Id {
        let factors = self.factors(g, 1);
        g.product(&factors)
    }

    /// The polynomial to a power, as factors of a product: content, common atoms and the rest, the
    /// rest with a sign that makes it positive where that is known.
    fn factors(&self, g: &mut Graph, power: i64) -> Vec<(Id, Id)> {
        let (mut k, common, rest) = self.content();
        let mut factors = Vec::new();
        for (a, e) in common {
            let e = g.int(i64::from(e) * power);
            factors.push((a, e));
        }
        let mut constant = Q::ZERO;
        let mut terms = Vec::new();
        for (m, q) in &rest.0 {
            if m.is_empty() {
                constant = *q;
                continue;
            }
            let f: Vec<_> = m.iter().map(|(a, e)| (*a, g.int(i64::from(*e)))).collect();
            let t = g.product(&f);
            terms.push((*q, t));
        }
        let mut body = g.sum(constant, &terms);
        if g.range(body).nonpositive() && !g.range(body).nonnegative() {
            body = g.neg(body);
            k = k.neg();
        }
        let e = g.int(power);
        factors.push((body, e));
        let k = g.number(k);
        factors.push((k, e));
        factors
    }
}

fn times(a: &Mono, b: &Mono) -> Mono {
    let mut r: BTreeMap<Id, u32> = a.iter().copied().collect();
    for (x, e) in b {
        *r.entry(*x).or_insert(0) += e;
    }
    r.into_iter().rev().collect()
}

fn over(a: &Mono, b: &Mono) -> Option<Mono> {
    let mut r: BTreeMap<Id, u32> = a.iter().copied().collect();
    for (x, e) in b {
        let have = r.get_mut(x)?;
        *have = have.checked_sub(*e)?;
    }
    Some(r.into_iter().rev().filter(|(_, e)| *e > 0).collect())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::expr::Leaf;
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
