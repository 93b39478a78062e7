//! Rational functions, and expressions as rational functions of their atoms.

use super::factor::two_factors;
use super::{Known, Poly, metered, spend};
use crate::expr::{Deps, Fun, Graph, Id, Node};
use crate::functions::leads_negative;
use crate::jacobian::cost;
use crate::rational::Q;

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
    /// What is known with these relations; without any the graph keeps it.
    known: Known,
}

/// Denominators with more terms than this are not multiplied by their conjugates.
const CONJUGATED: usize = 5;

/// How many squares of atoms in terms of a polynomial are replaced at most: what needs more is long, and better left.
const MOST_REPLACED: usize = 40;

impl<'a> Expander<'a> {
    /// An expander without relations.
    pub fn new(graph: &'a mut Graph) -> Self {
        Expander { graph, squares: Vec::new(), open: Deps::MAX, known: Known::default() }
    }

    /// Adds the relation x² + y² + z² = 1 between three atoms.
    pub fn unit(self, [x, y, z]: [Id; 3]) -> Self {
        self.unit_with(z, &[x, y])
    }

    /// The same of an atom and any number of others.
    pub fn unit_with(mut self, atom: Id, others: &[Id]) -> Self {
        let square = |a: &Id| Poly::term([(*a, 2)].into(), Q::int(-1));
        let one = Poly::constant(Q::ONE);
        if let Some(p) = others.iter().try_fold(one, |sum, a| sum.add(&square(a))) {
            self.squares.push((atom, p));
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
        let key = (id, self.open);
        if let Some(&(known, steps)) = self.known().normal.get(&key) {
            spend(steps)?;
            return known;
        }
        let (normal, steps) = metered(|| {
            let r = self.expand(id)?;
            let r = self.cancel(r)?;
            Some(self.to_expr(&r))
        });
        if let Some(steps) = steps {
            self.known().normal.insert(key, (normal, steps));
        }
        normal
    }

    fn known(&mut self) -> &mut Known {
        if self.squares.is_empty() { &mut self.graph.expanded } else { &mut self.known }
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
        let composed = matches!(self.graph.node(id), Node::Sum(..) | Node::Product(_));
        if !composed {
            return self.expand_node(id);
        }
        let key = (id, self.open);
        if let Some((known, steps)) = self.known().functions.get(&key) {
            spend(*steps)?;
            return known.clone();
        }
        let (function, steps) = metered(|| self.expand_node(id));
        if let Some(steps) = steps {
            self.known().functions.insert(key, (function.clone(), steps));
        }
        function
    }

    /// A sum as a number and a sum, the latter without a sign that all of its terms have: a + b for -a - b.
    fn positive(&mut self, id: Id) -> (Q, Id) {
        let several = matches!(self.graph.node(id), Node::Sum(_, terms) if terms.len() > 1);
        if several && leads_negative(self.graph, id) {
            (Q::int(-1), self.graph.neg(id))
        } else {
            self.graph.split(id)
        }
    }

    fn expand_node(&mut self, id: Id) -> Option<RatFun> {
        if self.open != Deps::MAX
            && !self.graph.has(id, self.open)
            && matches!(self.graph.node(id), Node::Sum(..))
        {
            let (q, t) = self.positive(id);
            return Some(RatFun::from(Poly::atom(t).scale(q)?));
        }
        match self.graph.node(id).clone() {
            Node::Number(q) => Some(RatFun::from(Poly::constant(q))),
            Node::Sum(c, terms) => {
                // What is known stays together also where it is only a part of the sum.
                let (open, known): (Vec<_>, Vec<_>) = terms
                    .into_iter()
                    .partition(|(_, t)| self.open == Deps::MAX || self.graph.has(*t, self.open));
                let mut s = match known[..] {
                    [] => RatFun::from(Poly::constant(c)),
                    _ => {
                        let known = self.graph.sum(c, &known);
                        self.expand(known)?
                    }
                };
                for (q, t) in open {
                    let mut t = self.expand(t)?;
                    t.num = t.num.scale(q)?;
                    s = self.add(&s, &t)?;
                }
                Some(s)
            }
            Node::Product(factors) => {
                let mut p = RatFun::one();
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
                    Node::Call(..) => Some(RatFun::from(Poly::atom(call))),
                    _ => self.expand(call),
                }
            }
            // Both sides of a choice may differ in their poles: it stays whole.
            _ => Some(RatFun::from(Poly::atom(id))),
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
        let one = RatFun::one();
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
                Some(RatFun::from(Poly::atom(whole)))
            }
        }
    }

    fn power(&mut self, b: Id, e: Id) -> Option<RatFun> {
        let Some(q) = self.graph.as_number(e) else {
            let (times, part) = self.graph.split(e);
            if let Some(n) = times.to_i32().filter(|n| (2..9).contains(&n.unsigned_abs())) {
                // b^(2 t) is the square of b^t.
                let root = self.power(b, part)?;
                return self.powi(&root, n);
            }
            let (b, e) = (self.cheaper(b), self.cheaper(e));
            let whole = self.graph.pow(b, e);
            return Some(RatFun::from(Poly::atom(whole)));
        };
        // q = whole + fraction with 0 <= fraction < 1.
        let whole = q.num().div_euclid(q.den());
        let fraction = q.add(Q::new(-whole, 1)?)?;
        let whole = i32::try_from(whole).ok()?;
        if whole.unsigned_abs() > 8 {
            let p = self.graph.pow(b, e);
            return Some(RatFun::from(Poly::atom(p)));
        }
        let mut r = if whole == 0 {
            RatFun::one()
        } else {
            let base = self.expand(b)?;
            self.powi(&base, whole)?
        };
        if !fraction.is_zero() {
            let f = self.graph.number(fraction);
            let atom = self.graph.pow(b, f);
            r = self.mul(&r, &RatFun::from(Poly::atom(atom)))?;
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
        RatFun { num, den: monic_factors(&r.num, k)? }.normalised(&r.num, k)
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
            return Some(RatFun::from(Poly::default()));
        }
        for (d, e) in &mut r.den {
            while *e > 0 {
                match r.num.exact_div(d).or_else(|| self.over_conjugate(&r.num, d)) {
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

    /// num / (a + b √c) as num (a - b √c) / (a² - b² c), if that division leaves no remainder: where the
    /// numerator has the root as well, or the divisor becomes a constant.
    fn over_conjugate(&mut self, num: &Poly, den: &Poly) -> Option<Poly> {
        if den.len() > CONJUGATED || num.len() > 10 * CONJUGATED {
            return None;
        }
        let mut roots = den.atoms();
        roots.retain(|a| self.is_root(*a));
        let shared = roots.iter().find(|a| num.contains(**a)).or(roots.first());
        let root = *shared?;
        let powers = den.by_powers_of(root)?;
        let [a, b] = &powers[..] else { return None };
        let conjugate = a.sub(&b.mul(&Poly::atom(root))?)?;
        let norm = self.reduce(den.mul(&conjugate)?)?;
        if norm.is_zero() || !num.contains(root) && norm.as_constant().is_none() {
            return None;
        }
        self.reduce(num.mul(&conjugate)?)?.exact_div(&norm)
    }

    fn is_root(&self, atom: Id) -> bool {
        let half = |e| self.graph.as_number(e) == Some(Q::HALF);
        matches!(self.graph.node(atom), Node::Product(f) if f.len() == 1 && half(f[0].1))
    }

    /// Applies √x·√x = x, cos² = 1 - sin², and the caller's relations.
    fn reduce(&mut self, mut p: Poly) -> Option<Poly> {
        let mut left = MOST_REPLACED;
        loop {
            let Some((k, i, square)) = p.0.iter().enumerate().find_map(|(k, (m, _))| {
                m.iter().enumerate().find_map(|(i, (a, e))| {
                    (*e >= 2).then(|| self.square_of(*a)).flatten().map(|s| (k, i, s))
                })
            }) else {
                return Some(p);
            };
            // Roots of numbers make no terms.
            if square.as_constant().is_none() {
                left = left.checked_sub(1)?;
            }
            let (whole, q) = p.0.remove(k);
            let mut rest = whole.to_vec();
            rest[i].1 -= 2;
            rest.retain(|(_, e)| *e > 0);
            p = p.add(&square.mul(&Poly::term(rest.into(), q))?)?;
        }
    }

    fn square_of(&mut self, atom: Id) -> Option<Poly> {
        if let Some((_, p)) = self.squares.iter().find(|(a, _)| *a == atom) {
            return Some(p.clone());
        }
        match self.graph.node(atom) {
            Node::Product(f) if f.len() == 1 && self.graph.as_number(f[0].1) == Some(Q::HALF) => {
                let r = self.expand(f[0].0)?;
                r.den.is_empty().then_some(r.num)
            }
            Node::Call(Fun::Cos, args) => {
                let args = args.clone();
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
        for f in two_factors(&rest).unwrap_or_else(|| vec![rest.clone()]) {
            let lead = f.0.last().map(|(_, q)| *q)?;
            out.push((f.scale(lead.recip()?)?, k));
        }
    }
    Some(out)
}

impl From<Poly> for RatFun {
    fn from(num: Poly) -> RatFun {
        RatFun { num, den: vec![] }
    }
}

impl RatFun {
    /// The number one.
    pub fn one() -> RatFun {
        RatFun::from(Poly::constant(Q::ONE))
    }

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
