//! Polynomials and rational functions over atoms: multiplying out, cancelling, factoring.
//!
//! An atom is anything that is not a sum or a product: an input, a function call, a root. Squares
//! of square roots and of cosines are reduced, and a caller may add relations of his own (the
//! coordinates of a direction have squares that add up to one).

use std::collections::BTreeMap;

use crate::expr::{Deps, Fun, Graph, Id, Node};
use crate::jacobian::cost;
use crate::rational::Q;

/// A monomial: (atom, exponent) pairs, largest atom first; exponents positive.
type Mono = Vec<(Id, u32)>;

/// A polynomial with rational coefficients, by monomial in lexicographic order.
#[derive(Clone, PartialEq, Debug, Default)]
pub struct Poly(BTreeMap<Mono, Q>);

/// Work limit: polynomials with more terms than this are given up.
const MAX_TERMS: usize = 120;

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

/// A quotient of polynomials, the denominator kept in factors.
#[derive(Clone, Debug)]
pub struct RatFun {
    /// Numerator.
    pub num: Poly,
    /// Denominator: factors with their exponents.
    pub den: Vec<(Poly, u32)>,
}

/// Turns expressions into rational functions.
pub struct Expander<'a> {
    graph: &'a mut Graph,
    /// Relations: the square of an atom, as a polynomial.
    squares: Vec<(Id, Poly)>,
    /// Sums that depend on none of these inputs are atoms.
    open: Deps,
}

impl<'a> Expander<'a> {
    /// An expander without relations.
    pub fn new(graph: &'a mut Graph) -> Self {
        Expander { graph, squares: Vec::new(), open: Deps::MAX }
    }

    /// Adds the relation x² + y² + z² = 1 between three atoms.
    pub fn unit(mut self, [x, y, z]: [Id; 3]) -> Self {
        let square = |a: Id| Poly(BTreeMap::from([(vec![(a, 2)], Q::int(-1))]));
        let one = Poly::constant(Q::ONE);
        if let Some(p) = one.add(&square(x)).and_then(|p| p.add(&square(y))) {
            self.squares.push((z, p));
        }
        self
    }

    /// Keeps sums that depend on none of `open` together (parameters, say).
    pub fn only(mut self, open: Deps) -> Self {
        self.open = open;
        self
    }

    /// The normal form of an expression, if it stays small.
    pub fn normal_form(&mut self, id: Id) -> Option<Id> {
        let r = self.expand(id)?;
        let r = self.cancel(r)?;
        Some(self.to_expr(&r))
    }

    /// The expression of a rational function.
    pub fn to_expr(&mut self, r: &RatFun) -> Id {
        let mut factors = r.num.factors(self.graph, 1);
        for (d, e) in &r.den {
            factors.extend(d.factors(self.graph, -i64::from(*e)));
        }
        self.graph.product(&factors)
    }

    /// Numerator and factored denominator.
    pub fn expand(&mut self, id: Id) -> Option<RatFun> {
        if self.open != Deps::MAX
            && !self.graph.has(id, self.open)
            && matches!(self.graph.node(id), Node::Sum(..))
        {
            let (q, t) = self.graph.split(id);
            return Some(RatFun { num: Poly::atom(t).scale(q)?, den: vec![] });
        }
        match self.graph.node(id).clone() {
            Node::Number(q) => Some(RatFun { num: Poly::constant(q), den: vec![] }),
            Node::Sum(c, terms) => {
                let mut s = RatFun { num: Poly::constant(c), den: vec![] };
                for (q, t) in terms {
                    let mut t = self.expand(t)?;
                    t.num = t.num.scale(q)?;
                    s = self.add(&s, &t)?;
                }
                Some(s)
            }
            Node::Product(factors) => {
                let mut p = RatFun { num: Poly::constant(Q::ONE), den: vec![] };
                for (b, e) in factors {
                    let f = self.power(b, e)?;
                    p = self.mul(&p, &f)?;
                }
                Some(p)
            }
            Node::Call(Fun::ExpM1, args) => {
                let e = self.graph.call(Fun::Exp, &args);
                let one = self.graph.int(1);
                let d = self.graph.sub(e, one);
                self.expand(d)
            }
            Node::Call(Fun::Exp, args) => self.exponential(args[0]),
            Node::Call(f, args) => {
                // Arguments in normal form, so that equal calls are one atom.
                let tidy: Vec<Id> = args.iter().map(|&a| self.cheaper(a)).collect();
                let call = self.graph.call(f, &tidy);
                match self.graph.node(call) {
                    Node::Call(..) => Some(RatFun { num: Poly::atom(call), den: vec![] }),
                    _ => self.expand(call),
                }
            }
            _ => Some(RatFun { num: Poly::atom(id), den: vec![] }),
        }
    }

    /// The normal form of a part, if that is simpler.
    fn cheaper(&mut self, id: Id) -> Id {
        match self.normal_form(id) {
            Some(n) if cost(self.graph, n) < cost(self.graph, id) => n,
            _ => id,
        }
    }

    /// exp(n·t) as the n-th power of the atom exp(t), for integer n.
    fn exponential(&mut self, a: Id) -> Option<RatFun> {
        let (q, t) = self.graph.split(a);
        let atom = self.graph.call(Fun::Exp, &[t]);
        let one = RatFun { num: Poly::constant(Q::ONE), den: vec![] };
        match q.to_i32() {
            Some(n) if n.unsigned_abs() < 9 => {
                let p = Poly::atom(atom).powi(n.unsigned_abs())?;
                Some(if n > 0 {
                    RatFun { num: p, ..one }
                } else {
                    RatFun { den: vec![(Poly::atom(atom), n.unsigned_abs())], ..one }
                })
            }
            _ => {
                let whole = self.graph.call(Fun::Exp, &[a]);
                Some(RatFun { num: Poly::atom(whole), den: vec![] })
            }
        }
    }

    fn power(&mut self, b: Id, e: Id) -> Option<RatFun> {
        let Some(q) = self.graph.as_number(e) else {
            let (b, e) = (self.cheaper(b), self.cheaper(e));
            let whole = self.graph.pow(b, e);
            return Some(RatFun { num: Poly::atom(whole), den: vec![] });
        };
        // q = whole + fraction with 0 <= fraction < 1.
        let whole = q.num().div_euclid(q.den());
        let fraction = q.add(Q::new(-whole, 1)?)?;
        let whole = i32::try_from(whole).ok()?;
        if whole.unsigned_abs() > 8 {
            let p = self.graph.pow(b, e);
            return Some(RatFun { num: Poly::atom(p), den: vec![] });
        }
        let mut r = if whole == 0 {
            RatFun { num: Poly::constant(Q::ONE), den: vec![] }
        } else {
            let base = self.expand(b)?;
            self.powi(&base, whole)?
        };
        if !fraction.is_zero() {
            let f = self.graph.number(fraction);
            let atom = self.graph.pow(b, f);
            r = self.mul(&r, &RatFun { num: Poly::atom(atom), den: vec![] })?;
        }
        Some(r)
    }

    fn powi(&mut self, r: &RatFun, n: i32) -> Option<RatFun> {
        let k = n.unsigned_abs();
        if n > 0 {
            let num = self.reduce(r.num.powi(k)?)?;
            return Some(RatFun {
                num,
                den: r.den.iter().map(|(d, e)| (d.clone(), e * k)).collect(),
            });
        }
        if r.num.is_zero() {
            return None;
        }
        let mut num = Poly::constant(Q::ONE);
        for (d, e) in &r.den {
            num = self.reduce(num.mul(&d.powi(e * k)?)?)?;
        }
        Some(RatFun { num, den: monic_factors(&r.num, k)? }.normalised(&r.num, k)?)
    }

    /// Reciprocal.
    pub fn recip(&mut self, r: &RatFun) -> Option<RatFun> {
        self.powi(r, -1)
    }

    /// Product.
    pub fn mul(&mut self, a: &RatFun, b: &RatFun) -> Option<RatFun> {
        let num = self.reduce(a.num.mul(&b.num)?)?;
        let mut den = a.den.clone();
        for (d, e) in &b.den {
            match den.iter_mut().find(|(p, _)| p == d) {
                Some((_, have)) => *have += e,
                None => den.push((d.clone(), *e)),
            }
        }
        self.cancel(RatFun { num, den })
    }

    /// Sum.
    pub fn add(&mut self, a: &RatFun, b: &RatFun) -> Option<RatFun> {
        let mut den = a.den.clone();
        for (d, e) in &b.den {
            match den.iter_mut().find(|(p, _)| p == d) {
                Some((_, have)) => *have = (*have).max(*e),
                None => den.push((d.clone(), *e)),
            }
        }
        let mut lift = |r: &RatFun| -> Option<Poly> {
            let mut n = r.num.clone();
            for (d, e) in &den {
                let have = r.den.iter().find(|(p, _)| p == d).map_or(0, |(_, e)| *e);
                n = self.reduce(n.mul(&d.powi(e - have)?)?)?;
            }
            Some(n)
        };
        let num = lift(a)?.add(&lift(b)?)?;
        self.cancel(RatFun { num, den })
    }

    /// Divides numerator and denominator by common factors.
    pub fn cancel(&mut self, mut r: RatFun) -> Option<RatFun> {
        if r.num.is_zero() {
            return Some(RatFun { num: Poly::default(), den: vec![] });
        }
        for (d, e) in &mut r.den {
            while *e > 0 {
                match r.num.exact_div(d) {
                    Some(q) => {
                        r.num = q;
                        *e -= 1;
                    }
                    None => break,
                }
            }
        }
        r.den.retain(|(_, e)| *e > 0);
        Some(r)
    }

    /// Applies √x·√x = x, cos² = 1 - sin², and the caller's relations.
    fn reduce(&mut self, p: Poly) -> Option<Poly> {
        let mut p = p;
        for _ in 0..40 {
            let Some((m, q, square, i)) = p.0.iter().find_map(|(m, q)| {
                m.iter().enumerate().find_map(|(i, (a, e))| {
                    (*e >= 2).then(|| self.square_of(*a)).flatten().map(|s| (m.clone(), *q, s, i))
                })
            }) else {
                return Some(p);
            };
            p.0.remove(&m);
            let mut rest = m.clone();
            rest[i].1 -= 2;
            rest.retain(|(_, e)| *e > 0);
            p = p.add(&square.mul(&Poly(BTreeMap::from([(rest, q)])))?)?;
        }
        None
    }

    fn square_of(&mut self, atom: Id) -> Option<Poly> {
        if let Some((_, p)) = self.squares.iter().find(|(a, _)| *a == atom) {
            return Some(p.clone());
        }
        match self.graph.node(atom).clone() {
            Node::Product(f) if f.len() == 1 && self.graph.as_number(f[0].1) == Some(Q::HALF) => {
                let r = self.expand(f[0].0)?;
                r.den.is_empty().then_some(r.num)
            }
            Node::Call(Fun::Cos, args) => {
                let s = self.graph.call(Fun::Sin, &args);
                let s2 = Poly::atom(s).mul(&Poly::atom(s))?;
                Poly::constant(Q::ONE).sub(&s2)
            }
            _ => None,
        }
    }
}

/// The factors of a polynomial that is about to become a denominator: its atoms and what is left.
fn monic_factors(p: &Poly, k: u32) -> Option<Vec<(Poly, u32)>> {
    let (_, common, rest) = p.content();
    let mut out: Vec<(Poly, u32)> = common.iter().map(|(a, e)| (Poly::atom(*a), e * k)).collect();
    if rest.as_constant().is_none() {
        for f in difference_of_squares(&rest) {
            let lead = f.0.iter().next_back().map(|(_, q)| *q)?;
            out.push((f.scale(lead.recip()?)?, k));
        }
    }
    Some(out)
}

/// a² - b² as (a - b)(a + b), where both are squares of monomials.
fn difference_of_squares(p: &Poly) -> Vec<Poly> {
    let terms: Vec<_> = p.0.iter().collect();
    if let [(m, q), (n, r)] = terms[..] {
        let root = |m: &Mono, q: Q| {
            let half: Option<Mono> =
                m.iter().map(|(a, e)| (e % 2 == 0).then_some((*a, e / 2))).collect();
            Some(Poly(BTreeMap::from([(half?, q.sqrt()?)])))
        };
        let (pos, neg) = if r.is_negative() { ((m, q), (n, r)) } else { ((n, r), (m, q)) };
        if pos.1.is_negative() || !neg.1.is_negative() {
            return vec![p.clone()];
        }
        if let (Some(a), Some(b)) = (root(pos.0, *pos.1), root(neg.0, neg.1.neg()))
            && let (Some(s), Some(d)) = (a.add(&b), a.sub(&b))
        {
            return vec![d, s];
        }
    }
    vec![p.clone()]
}

impl RatFun {
    /// Moves the rational constant that [`monic_factors`] dropped into the numerator.
    fn normalised(mut self, original: &Poly, k: u32) -> Option<RatFun> {
        let mut product = Poly::constant(Q::ONE);
        for (d, e) in &self.den {
            product = product.mul(&d.powi(*e)?)?;
        }
        let target = original.powi(k)?;
        let constant = target.exact_div(&product)?.as_constant()?;
        self.num = self.num.scale(constant.recip()?)?;
        Some(self)
    }
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
