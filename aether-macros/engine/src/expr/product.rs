//! Products in canonical form: powers of powers, exponentials, numbers under roots.

use super::{Fun, Graph, Id, Node};
use crate::rational::Q;
use crate::sorted;

impl Graph {
    /// The (base, exponent) pairs of an expression, a single one if it is not a product.
    pub fn factors(&mut self, id: Id) -> Vec<(Id, Id)> {
        let one = self.int(1);
        match self.node(id) {
            Node::Product(f) => f.clone(),
            Node::Number(q) if *q == Q::ONE => Vec::new(),
            _ => vec![(id, one)],
        }
    }

    /// Π base^exponent, in canonical form.
    pub fn product(&mut self, factors: &[(Id, Id)]) -> Id {
        let mut collect = Collect::default();
        for &(b, e) in factors {
            self.collect_factor(&mut collect, b, e);
        }
        let exponents: Vec<(Q, Id)> = std::mem::take(&mut collect.exponents);
        if !exponents.is_empty() {
            let argument = self.sum(Q::ZERO, &exponents);
            let e = self.call(Fun::Exp, &[argument]);
            let one = self.int(1);
            if matches!(self.node(e), Node::Call(Fun::Exp, _)) {
                collect.push(e, one);
            } else {
                self.collect_factor(&mut collect, e, one);
            }
        }
        self.sizes(&mut collect);
        self.absorb(&mut collect);
        let mut list = Vec::new();
        let mut again = Vec::new();
        for (base, exps) in std::mem::take(&mut collect.factors) {
            let e = self.added(&exps);
            match self.as_number(e) {
                Some(q) if q.is_zero() => {}
                // A merged exponent may allow more (a root of a number that became whole).
                Some(q) if exps.len() > 1 && self.reopens(base, q) => again.push((base, e)),
                _ => list.push((base, e)),
            }
        }
        if !again.is_empty() {
            let coefficient = self.number(collect.coefficient);
            let one = self.int(1);
            again.extend(list);
            again.push((coefficient, one));
            return self.product(&again);
        }
        sorted::sort_by_key(&mut list, |(b, _)| *b);
        let one = self.int(1);
        let body = match list[..] {
            [] => return self.number(collect.coefficient),
            [(b, e)] if e == one => b,
            _ => self.intern(Node::Product(list)),
        };
        if collect.coefficient == Q::ONE {
            body
        } else {
            self.sum(Q::ZERO, &[(collect.coefficient, body)])
        }
    }

    /// |x| √x = x √x: what is under a root is not negative.
    fn sizes(&mut self, collect: &mut Collect) {
        for size in collect.bases(|b| matches!(self.node(b), Node::Call(Fun::Abs, _))) {
            let Node::Call(_, args) = self.node(size) else { continue };
            let inner = args[0];
            let Some(exponents) = collect.of(inner) else { continue };
            let e = self.added(exponents);
            if self.as_number(e).is_some_and(|q| q.den() == 2) {
                for e in collect.remove(size) {
                    collect.push(inner, e);
                }
            }
        }
    }

    /// (x / l)^k · l / x = (x / l)^(k - 1): factors that are an integer power of a grouped base.
    fn absorb(&mut self, collect: &mut Collect) {
        for group in collect.bases(|b| matches!(self.node(b), Node::Product(_))) {
            let Node::Product(members) = self.node(group).clone() else { continue };
            let mut power: Option<Q> = None;
            let fits = members.iter().all(|(b, e)| {
                let have = collect.of(*b).map(|es| self.added(es));
                let ratio = have.and_then(|h| self.as_number(h)?.mul(self.as_number(*e)?.recip()?));
                let same = ratio
                    .is_some_and(|r| r.is_int() && !r.is_zero() && power.is_none_or(|p| p == r));
                power = ratio;
                same
            });
            if let (true, Some(p)) = (fits, power) {
                for (b, _) in &members {
                    collect.remove(*b);
                }
                let p = self.number(p);
                collect.push(group, p);
            }
        }
    }

    /// The sum of exponents.
    fn added(&mut self, exponents: &[Id]) -> Id {
        match exponents {
            [only] if self.as_number(*only).is_some() => *only,
            _ => {
                let terms: Vec<(Q, Id)> = exponents.iter().map(|&e| (Q::ONE, e)).collect();
                self.sum(Q::ZERO, &terms)
            }
        }
    }

    /// Whether base^q would be taken apart by [`Graph::collect_factor`].
    fn reopens(&self, base: Id, q: Q) -> bool {
        match self.node(base) {
            Node::Number(_) => q.abs() >= Q::ONE,
            Node::Call(Fun::Abs, _) => q.is_even(),
            Node::Product(_) => true,
            Node::Sum(c, t) => c.is_zero() && t.len() == 1,
            _ => false,
        }
    }

    fn collect_factor(&mut self, out: &mut Collect, base: Id, exp: Id) {
        let number = self.as_number(exp);
        match self.node(base) {
            Node::Number(q) => self.collect_number(out, *q, exp, number),
            Node::Product(inner) => {
                let inner = inner.clone();
                let mut together = Vec::new();
                for (b, e) in inner {
                    match self.power_of_power(b, e, exp) {
                        Some((b, e)) => self.collect_factor(out, b, e),
                        None => together.push((b, e)),
                    }
                }
                // Factors of unknown sign may only be positive as a whole.
                let one = self.int(1);
                match together[..] {
                    [] => {}
                    [(b, e)] if e == one => out.push(b, exp),
                    // Under a root an odd power is that of something positive, or no number.
                    [(b, e)] if self.is_odd_under_a_root(e, exp) => {
                        let e = self.mul(e, exp);
                        out.push(b, e);
                    }
                    _ => {
                        let whole = self.intern(Node::Product(together));
                        out.push(whole, exp);
                    }
                }
            }
            Node::Sum(c, terms) if c.is_zero() && terms.len() == 1 => {
                let (q, t) = terms[0];
                match number {
                    Some(n) if n.is_int() || !q.is_negative() => {
                        self.collect_number(out, q, exp, number);
                        self.collect_factor(out, t, exp);
                    }
                    _ => out.push(base, exp),
                }
            }
            Node::Call(Fun::Exp, args) => {
                let argument = args[0];
                let scaled = self.mul(argument, exp);
                out.exponents.push((Q::ONE, scaled));
            }
            Node::Call(Fun::Abs, args) if number.is_some_and(Q::is_even) => {
                let inner = args[0];
                self.collect_factor(out, inner, exp);
            }
            _ => out.push(base, exp),
        }
    }

    fn is_odd_under_a_root(&self, e: Id, exp: Id) -> bool {
        let odd = |q: Q| q.is_int() && !q.is_even();
        let [inner, outer] = [e, exp].map(|e| self.as_number(e));
        inner.is_some_and(odd) && outer.is_some_and(|q| q.den() == 2)
    }

    /// (b^e)^exp as a single power, where that is valid.
    fn power_of_power(&mut self, b: Id, e: Id, exp: Id) -> Option<(Id, Id)> {
        let outer_int = self.as_number(exp).is_some_and(Q::is_int);
        let inner = self.as_number(e);
        // A fractional or symbolic inner power means that the base is not negative.
        let base_nonnegative = self.range(b).nonnegative() || !inner.is_some_and(Q::is_int);
        let merged = match (inner, self.as_number(exp)) {
            (Some(Q::ONE), _) => exp,
            (_, Some(Q::ONE)) => e,
            _ => self.mul(e, exp),
        };
        if outer_int || base_nonnegative {
            return Some((b, merged));
        }
        if inner.is_some_and(Q::is_even) {
            let abs = self.call(Fun::Abs, &[b]);
            return Some((abs, merged));
        }
        // An odd power of an unknown sign under a root: the base cannot be negative if it is alone.
        None
    }

    fn collect_number(&mut self, out: &mut Collect, q: Q, exp: Id, number: Option<Q>) {
        let one = Q::ONE;
        let result = match number {
            _ if q == one => Some(one),
            Some(n) if n.is_int() && n.num().abs() <= 64 && !(q.is_zero() && n.is_negative()) => {
                q.powi(n.num() as i64)
            }
            Some(n) if n.den() == 2 && !q.is_negative() && n.num().abs() <= 64 => match q.sqrt() {
                Some(r) if !(r.is_zero() && n.is_negative()) => r.powi(n.num() as i64),
                _ if n.abs() > one && !q.is_zero() => {
                    // q^(3/2) = q · q^(1/2)
                    let whole = (n.num() - n.num().signum()) / 2;
                    if let Some(w) = q.powi(whole as i64).and_then(|w| out.coefficient.mul(w)) {
                        out.coefficient = w;
                        let half = self.number(Q::new(n.num().signum(), 2).unwrap_or(Q::HALF));
                        let base = self.number(q);
                        out.push(base, half);
                        return;
                    }
                    None
                }
                _ => None,
            },
            _ => None,
        };
        match result.and_then(|r| out.coefficient.mul(r)) {
            Some(c) => out.coefficient = c,
            None => {
                let base = self.number(q);
                out.push(base, exp);
            }
        }
    }
}

/// The parts of a product while it is put together.
struct Collect {
    coefficient: Q,
    /// Bases in the order of their ids with their exponents, which are added at the end. They are few, and lists cheap.
    factors: Vec<(Id, Vec<Id>)>,
    exponents: Vec<(Q, Id)>,
}

impl Default for Collect {
    fn default() -> Self {
        Collect { coefficient: Q::ONE, factors: Vec::new(), exponents: Vec::new() }
    }
}

impl Collect {
    /// The place of a base, or where it belongs.
    fn place(&self, base: Id) -> Result<usize, usize> {
        self.factors.binary_search_by_key(&base.0, |(b, _)| b.0)
    }

    fn push(&mut self, base: Id, exp: Id) {
        match self.place(base) {
            Ok(k) => self.factors[k].1.push(exp),
            Err(k) => self.factors.insert(k, (base, vec![exp])),
        }
    }

    /// The exponents of a base.
    fn of(&self, base: Id) -> Option<&[Id]> {
        self.place(base).ok().map(|k| &self.factors[k].1[..])
    }

    fn remove(&mut self, base: Id) -> Vec<Id> {
        self.place(base).map_or(Vec::new(), |k| self.factors.remove(k).1)
    }

    /// The bases of a kind.
    fn bases(&self, kind: impl Fn(Id) -> bool) -> Vec<Id> {
        let mut out = Vec::new();
        for &(base, _) in &self.factors {
            if kind(base) {
                out.push(base);
            }
        }
        out
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::expr::Leaf;
    use crate::interval::Interval;

    #[test]
    fn a_root_of_an_odd_power_is_a_power() {
        let mut g = Graph::new();
        let x = g.leaf(Leaf::Out(0), "x", Interval::ALL);
        let half = |n| Q::new(n, 2).unwrap();
        for n in [-3, -1, 3] {
            let power = g.powi(x, n);
            let root = g.sqrt(power);
            let exponent = g.number(half(n.into()));
            assert_eq!(root, g.pow(x, exponent));
        }
        // The root of a square is a size, and a cube may be that of something negative.
        let square = g.powi(x, 2);
        let (root, size) = (g.sqrt(square), g.call(Fun::Abs, &[x]));
        assert_eq!(root, size);
        let (cube, third) = (g.powi(x, 3), g.number(Q::new(1, 3).unwrap()));
        assert_ne!(g.pow(cube, third), x);
    }
}
