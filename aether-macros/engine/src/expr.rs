//! The expression graph: hash-consed nodes in a canonical form.
//!
//! Sums carry an exact constant and rational coefficients; products carry (base, exponent) pairs
//! whose exponents are expressions themselves. Equal expressions have equal ids, so comparing ids
//! is comparing expressions, and sharing is free. Nothing is ever multiplied out here: the written
//! shape of a sampler is what its author meant to be evaluated ([`crate::poly`] expands on demand).

use std::collections::{BTreeMap, HashMap};

use crate::interval::Interval;
use crate::rational::Q;

/// An expression: an index into its [`Graph`].
#[derive(Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord, Debug)]
pub struct Id(pub u32);

/// Functions that are neither sums nor powers.
#[derive(Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord, Debug)]
#[allow(missing_docs)]
pub enum Fun {
    Exp,
    ExpM1,
    Ln,
    Ln1p,
    Sin,
    Cos,
    Tan,
    Asin,
    Acos,
    Atan,
    Sinh,
    Cosh,
    Tanh,
    Asinh,
    Acosh,
    Atanh,
    Abs,
    /// One with the sign of the argument.
    Sign,
    /// atan2(y, x), in [-π, π].
    Atan2,
    /// Sine of a multiple of π: sin(π x), accurate near its zeros.
    SinPi,
    /// Cosine of a multiple of π: cos(π x), accurate near its zeros.
    CosPi,
    /// An angle brought into [0, 2π) by adding a multiple of 2π.
    Turn,
}

/// An input of an expression.
#[derive(Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord, Debug)]
pub enum Leaf {
    /// A uniform of a sampler, or a coordinate of the point that a map is applied to: the unknowns.
    Unknown(u8),
    /// A coordinate of the point whose density is asked.
    Out(u8),
    /// A scalar parameter (or one coordinate of a vector parameter).
    Param(u8),
}

/// A node of the graph.
#[derive(Clone, PartialEq, Eq, Hash, Debug)]
pub enum Node {
    /// An exact number.
    Number(Q),
    /// A number that is not a small rational, by its bits.
    Float(u64),
    /// The circle constant.
    Pi,
    /// An input.
    Leaf(Leaf),
    /// constant + Σ coefficient · term; no term is a sum or a number.
    Sum(Q, Vec<(Q, Id)>),
    /// Π base^exponent; no base is a product, no rational factor outside a root.
    Product(Vec<(Id, Id)>),
    /// A function of one or two arguments.
    Call(Fun, Vec<Id>),
}

/// Which inputs an expression depends on, as a bit set.
pub type Deps = u128;

/// The bit of an input.
pub fn leaf_bit(leaf: Leaf) -> Deps {
    match leaf {
        Leaf::Unknown(i) => 1 << i,
        Leaf::Out(i) => 1 << (24 + i),
        Leaf::Param(i) => 1 << (48 + i.min(78)),
    }
}

/// The bits of all unknowns.
pub const UNKNOWNS: Deps = (1 << 24) - 1;
/// The bits of all coordinates of the query point.
pub const OUTS: Deps = ((1 << 24) - 1) << 24;

/// The arena of expressions.
#[derive(Default)]
pub struct Graph {
    nodes: Vec<Node>,
    ranges: Vec<Interval>,
    deps: Vec<Deps>,
    index: HashMap<Node, Id>,
    leaf_ranges: HashMap<Leaf, Interval>,
    names: HashMap<Leaf, String>,
    units: Vec<[Id; 3]>,
}

impl Graph {
    /// An empty graph.
    pub fn new() -> Graph {
        Graph::default()
    }

    /// How many nodes there are; work is bounded by it.
    pub fn len(&self) -> usize {
        self.nodes.len()
    }
    /// Whether there is no node yet.
    pub fn is_empty(&self) -> bool {
        self.nodes.is_empty()
    }
    /// The node of an id.
    pub fn node(&self, id: Id) -> &Node {
        &self.nodes[id.0 as usize]
    }
    /// An interval that contains every value of the expression.
    pub fn range(&self, id: Id) -> Interval {
        self.ranges[id.0 as usize]
    }
    /// The inputs that the expression depends on.
    pub fn deps(&self, id: Id) -> Deps {
        self.deps[id.0 as usize]
    }
    /// Whether the expression depends on any of `set`.
    pub fn has(&self, id: Id, set: Deps) -> bool {
        self.deps(id) & set != 0
    }

    /// Declares an input with its printed name and the interval of its values.
    pub fn leaf(&mut self, leaf: Leaf, name: &str, range: Interval) -> Id {
        self.leaf_ranges.insert(leaf, range);
        self.names.insert(leaf, name.to_owned());
        self.intern(Node::Leaf(leaf))
    }
    /// The expression of a declared input.
    pub fn get_leaf(&mut self, leaf: Leaf) -> Id {
        self.intern(Node::Leaf(leaf))
    }
    /// The printed name of an input.
    pub fn name(&self, leaf: Leaf) -> &str {
        self.names.get(&leaf).map_or("?", String::as_str)
    }

    /// Declares that the squares of three expressions add up to one.
    pub fn declare_unit(&mut self, coordinates: [Id; 3]) {
        self.units.push(coordinates);
    }
    /// Σ coefficient · term without the rules for sums, for the equation of a unit vector.
    pub fn plain_sum(&mut self, terms: &[(Q, Id)]) -> Id {
        let mut list = terms.to_vec();
        list.sort_by_key(|(_, t)| *t);
        self.intern(Node::Sum(Q::ZERO, list))
    }

    fn intern(&mut self, node: Node) -> Id {
        if let Some(&id) = self.index.get(&node) {
            return id;
        }
        let id = Id(u32::try_from(self.nodes.len()).unwrap_or(u32::MAX));
        let range = self.part_of_unit(&node).unwrap_or_else(|| self.range_of(&node));
        self.ranges.push(range);
        self.deps.push(self.deps_of(&node));
        self.nodes.push(node.clone());
        self.index.insert(node, id);
        id
    }

    /// The squares of some coordinates of a unit vector add up to at most one.
    fn part_of_unit(&self, node: &Node) -> Option<Interval> {
        let Node::Sum(c, terms) = node else { return None };
        if !c.is_zero() || terms.len() != 2 || terms.iter().any(|(q, _)| *q != Q::ONE) {
            return None;
        }
        let base = |id: Id| match self.node(id) {
            Node::Product(f) if f.len() == 1 && self.as_number(f[0].1) == Some(Q::int(2)) => {
                Some(f[0].0)
            }
            _ => None,
        };
        let (a, b) = (base(terms[0].1)?, base(terms[1].1)?);
        self.units
            .iter()
            .any(|u| u.contains(&a) && u.contains(&b))
            .then_some(Interval::new(0.0, 1.0))
    }

    fn deps_of(&self, node: &Node) -> Deps {
        match node {
            Node::Leaf(l) => leaf_bit(*l),
            _ => children(node).iter().fold(0, |d, c| d | self.deps(*c)),
        }
    }

    fn range_of(&self, node: &Node) -> Interval {
        match node {
            Node::Number(q) => Interval::point(q.to_f64()),
            Node::Float(bits) => Interval::point(f64::from_bits(*bits)),
            Node::Pi => Interval::point(std::f64::consts::PI),
            Node::Leaf(l) => self.leaf_ranges.get(l).copied().unwrap_or(Interval::ALL),
            Node::Sum(c, terms) => terms.iter().fold(Interval::point(c.to_f64()), |s, (q, t)| {
                s.add(self.range(*t).scale(q.to_f64()))
            }),
            Node::Product(factors) => factors.iter().fold(Interval::point(1.0), |p, (b, e)| {
                p.mul(match self.as_number(*e) {
                    Some(q) => self.range(*b).pow(q.to_f64()),
                    None => Interval::POSITIVE,
                })
            }),
            Node::Call(f, args) => match args[..] {
                [a] => self.range(a).call(*f),
                [y, x] if self.range(y).nonnegative() => {
                    let top = if self.range(x).nonnegative() { 0.5 } else { 1.0 };
                    Interval::new(0.0, std::f64::consts::PI * top)
                }
                _ => Interval::new(-std::f64::consts::PI, std::f64::consts::PI),
            },
        }
    }

    /// The exact rational value, if the expression is one.
    pub fn as_number(&self, id: Id) -> Option<Q> {
        if let Node::Number(q) = self.node(id) { Some(*q) } else { None }
    }

    /// The exact number `q`.
    pub fn number(&mut self, q: Q) -> Id {
        self.intern(Node::Number(q))
    }
    /// The integer `n`.
    pub fn int(&mut self, n: i64) -> Id {
        self.number(Q::int(n))
    }
    /// The circle constant.
    pub fn pi(&mut self) -> Id {
        self.intern(Node::Pi)
    }
    /// A double, kept exactly.
    pub fn float(&mut self, x: f64) -> Id {
        self.intern(Node::Float(x.to_bits()))
    }

    /// Splits an expression into a rational coefficient and the rest.
    pub fn split(&mut self, id: Id) -> (Q, Id) {
        match self.node(id) {
            Node::Number(q) => {
                let q = *q;
                (q, self.int(1))
            }
            Node::Sum(c, terms) if c.is_zero() && terms.len() == 1 => terms[0],
            _ => (Q::ONE, id),
        }
    }

    /// constant + Σ coefficient · term, in canonical form.
    pub fn sum(&mut self, constant: Q, terms: &[(Q, Id)]) -> Id {
        let mut total = constant;
        let mut collected: BTreeMap<Id, Q> = BTreeMap::new();
        let mut overflow = false;
        let mut add = |map: &mut BTreeMap<Id, Q>, q: Q, t: Id| {
            let entry = map.entry(t).or_insert(Q::ZERO);
            match entry.add(q) {
                Some(s) => *entry = s,
                None => overflow = true,
            }
        };
        for &(q, t) in terms {
            match self.node(t).clone() {
                Node::Number(n) => match q.mul(n).and_then(|p| total.add(p)) {
                    Some(s) => total = s,
                    None => add(&mut collected, q, t),
                },
                Node::Sum(c, inner) => {
                    let scaled: Option<Vec<(Q, Id)>> =
                        inner.iter().map(|&(p, x)| Some((q.mul(p)?, x))).collect();
                    match (scaled, q.mul(c).and_then(|p| total.add(p))) {
                        (Some(scaled), Some(s)) => {
                            total = s;
                            for (p, x) in scaled {
                                add(&mut collected, p, x);
                            }
                        }
                        _ => add(&mut collected, q, t),
                    }
                }
                _ => add(&mut collected, q, t),
            }
        }
        if overflow {
            // Too large for exact coefficients: keep the sum as it was written.
            let kept = terms.iter().copied().filter(|(q, _)| !q.is_zero()).collect();
            return self.intern(Node::Sum(constant, kept));
        }
        collected.retain(|_, q| !q.is_zero());
        self.sum_rules(total, collected)
    }

    /// Identities between terms of a sum: sin² + cos² = 1, 1 + expm1(x) = exp(x).
    fn sum_rules(&mut self, mut total: Q, mut terms: BTreeMap<Id, Q>) -> Id {
        let one = self.int(1);
        let ids: Vec<Id> = terms.keys().copied().collect();
        for t in ids {
            let Some(&q) = terms.get(&t) else { continue };
            for (other, merged, sign) in self.partners(t) {
                let found = if other == one {
                    total
                } else {
                    terms.get(&other).copied().unwrap_or(Q::ZERO)
                };
                if found.is_zero() || found != if sign { q } else { q.neg() } {
                    continue;
                }
                terms.remove(&t);
                if other == one {
                    total = Q::ZERO;
                } else {
                    terms.remove(&other);
                }
                let mut rest: Vec<(Q, Id)> = terms.iter().map(|(&t, &q)| (q, t)).collect();
                rest.push((found, merged));
                return self.sum(total, &rest);
            }
        }
        let mut list: Vec<(Q, Id)> = terms.into_iter().map(|(t, q)| (q, t)).collect();
        match (list.len(), total.is_zero()) {
            (0, _) => self.number(total),
            (1, true) if list[0].0 == Q::ONE => list[0].1,
            _ => {
                list.sort_by_key(|(_, t)| *t);
                self.intern(Node::Sum(total, list))
            }
        }
    }

    /// For a term t: triples (s, m, same) such that q·t + q·s = q·m (same) or s·q' + t·q = m·q' with q' = -q.
    fn partners(&mut self, t: Id) -> Vec<(Id, Id, bool)> {
        let mut found = Vec::new();
        let factors = self.factors(t);
        let two = self.int(2);
        let one = self.int(1);
        for (i, &(base, exp)) in factors.iter().enumerate() {
            let rest: Vec<(Id, Id)> =
                factors.iter().enumerate().filter(|(j, _)| *j != i).map(|(_, f)| *f).collect();
            match self.node(base).clone() {
                Node::Call(Fun::Sin | Fun::Cos, args) if exp == two => {
                    let is_sin = matches!(self.node(base), Node::Call(Fun::Sin, _));
                    let other = self.call(if is_sin { Fun::Cos } else { Fun::Sin }, &args);
                    let merged = self.product(&rest);
                    let mut swapped = rest.clone();
                    swapped.push((other, two));
                    let swapped = self.product(&swapped);
                    found.push((swapped, merged, true));
                    // P - P·sin² = P·cos²
                    found.push((merged, swapped, false));
                }
                Node::Call(Fun::ExpM1, args) if exp == one => {
                    let without = self.product(&rest);
                    let e = self.call(Fun::Exp, &args);
                    let mut with = rest.clone();
                    with.push((e, one));
                    let with = self.product(&with);
                    found.push((without, with, true));
                }
                Node::Call(Fun::Exp, args) if exp == one && rest.is_empty() => {
                    // exp(x) - 1 = expm1(x), seen from the term: merged term carries the other sign.
                    let _ = args;
                }
                _ => {}
            }
        }
        found
    }

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
                collect.factors.entry(e).or_default().push((Q::ONE, one));
            } else {
                self.collect_factor(&mut collect, e, one);
            }
        }
        self.absorb(&mut collect);
        let mut list = Vec::new();
        let mut again = Vec::new();
        for (base, exps) in std::mem::take(&mut collect.factors) {
            let e = self.sum(Q::ZERO, &exps);
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
        list.sort_by_key(|(b, _)| *b);
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

    /// (x / l)^k · l / x = (x / l)^(k - 1): factors that are an integer power of a grouped base.
    fn absorb(&mut self, collect: &mut Collect) {
        let groups: Vec<Id> = collect
            .factors
            .keys()
            .copied()
            .filter(|b| matches!(self.node(*b), Node::Product(_)))
            .collect();
        for group in groups {
            let Node::Product(members) = self.node(group).clone() else { continue };
            let mut power: Option<Q> = None;
            let fits = members.iter().all(|(b, e)| {
                let have = collect.factors.get(b).map(|es| self.sum(Q::ZERO, es));
                let ratio = have.and_then(|h| self.as_number(h)?.mul(self.as_number(*e)?.recip()?));
                let same = ratio
                    .is_some_and(|r| r.is_int() && !r.is_zero() && power.is_none_or(|p| p == r));
                power = ratio;
                same
            });
            if let (true, Some(p)) = (fits, power) {
                for (b, _) in &members {
                    collect.factors.remove(b);
                }
                let p = self.number(p);
                collect.push(group, p);
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
        match self.node(base).clone() {
            Node::Number(q) => self.collect_number(out, q, exp, number),
            Node::Product(inner) => {
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
                let scaled = self.mul(args[0], exp);
                out.exponents.push((Q::ONE, scaled));
            }
            Node::Call(Fun::Abs, args) if number.is_some_and(Q::is_even) => {
                self.collect_factor(out, args[0], exp);
            }
            _ => out.push(base, exp),
        }
    }

    /// (b^e)^exp as a single power, where that is valid.
    fn power_of_power(&mut self, b: Id, e: Id, exp: Id) -> Option<(Id, Id)> {
        let outer_int = self.as_number(exp).is_some_and(Q::is_int);
        let inner = self.as_number(e);
        // A fractional or symbolic inner power means that the base is not negative.
        let base_nonnegative = self.range(b).nonnegative() || !inner.is_some_and(Q::is_int);
        let merged = self.mul(e, exp);
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

    /// a + b.
    pub fn add(&mut self, a: Id, b: Id) -> Id {
        self.sum(Q::ZERO, &[(Q::ONE, a), (Q::ONE, b)])
    }
    /// a - b.
    pub fn sub(&mut self, a: Id, b: Id) -> Id {
        self.sum(Q::ZERO, &[(Q::ONE, a), (Q::int(-1), b)])
    }
    /// -a.
    pub fn neg(&mut self, a: Id) -> Id {
        self.sum(Q::ZERO, &[(Q::int(-1), a)])
    }
    /// a · b.
    pub fn mul(&mut self, a: Id, b: Id) -> Id {
        let one = self.int(1);
        self.product(&[(a, one), (b, one)])
    }
    /// a / b.
    pub fn div(&mut self, a: Id, b: Id) -> Id {
        let one = self.int(1);
        let minus = self.int(-1);
        self.product(&[(a, one), (b, minus)])
    }
    /// a^e.
    pub fn pow(&mut self, a: Id, e: Id) -> Id {
        self.product(&[(a, e)])
    }
    /// a^n.
    pub fn powi(&mut self, a: Id, n: i64) -> Id {
        let e = self.int(n);
        self.pow(a, e)
    }
    /// √a.
    pub fn sqrt(&mut self, a: Id) -> Id {
        let half = self.number(Q::HALF);
        self.pow(a, half)
    }
    /// A function of its arguments, in canonical form.
    pub fn call(&mut self, f: Fun, args: &[Id]) -> Id {
        crate::functions::simplify_call(self, f, args)
            .unwrap_or_else(|| self.intern(Node::Call(f, args.to_vec())))
    }

    /// Rebuilds an expression with some subexpressions replaced (the largest match wins).
    pub fn substitute(&mut self, id: Id, map: &HashMap<Id, Id>) -> Id {
        let mut memo = HashMap::new();
        self.substitute_memo(id, map, &mut memo)
    }

    fn substitute_memo(&mut self, id: Id, map: &HashMap<Id, Id>, memo: &mut HashMap<Id, Id>) -> Id {
        if let Some(&r) = map.get(&id) {
            return r;
        }
        if let Some(&r) = memo.get(&id) {
            return r;
        }
        let r = match self.node(id).clone() {
            Node::Sum(c, terms) => {
                let t: Vec<_> =
                    terms.iter().map(|&(q, t)| (q, self.substitute_memo(t, map, memo))).collect();
                self.sum(c, &t)
            }
            Node::Product(factors) => {
                let f: Vec<_> = factors
                    .iter()
                    .map(|&(b, e)| {
                        let whole = self.intern(Node::Product(vec![(b, e)]));
                        let one = self.int(1);
                        match map.get(&whole) {
                            Some(&r) => (r, one),
                            None => match self.inverse_power(b, e, map) {
                                Some(r) => r,
                                None => (
                                    self.substitute_memo(b, map, memo),
                                    self.substitute_memo(e, map, memo),
                                ),
                            },
                        }
                    })
                    .collect();
                self.product(&f)
            }
            Node::Call(f, args) => {
                let a: Vec<_> = args.iter().map(|&a| self.substitute_memo(a, map, memo)).collect();
                self.call(f, &a)
            }
            _ => id,
        };
        memo.insert(id, r);
        r
    }

    /// b^e where the map knows b^f for some other rational f: (b^f)^(e/f).
    fn inverse_power(&mut self, b: Id, e: Id, map: &HashMap<Id, Id>) -> Option<(Id, Id)> {
        let e = self.as_number(e)?;
        for f in [Q::HALF, Q::HALF.neg()] {
            let half = self.number(f);
            let known = self.intern(Node::Product(vec![(b, half)]));
            if let Some(&r) = map.get(&known) {
                let ratio = e.mul(f.recip()?)?;
                if ratio.is_int() {
                    return Some((r, self.number(ratio)));
                }
            }
        }
        None
    }
}

/// The parts of a product while it is put together.
struct Collect {
    coefficient: Q,
    factors: BTreeMap<Id, Vec<(Q, Id)>>,
    exponents: Vec<(Q, Id)>,
}

impl Default for Collect {
    fn default() -> Self {
        Collect { coefficient: Q::ONE, factors: BTreeMap::new(), exponents: Vec::new() }
    }
}

impl Collect {
    fn push(&mut self, base: Id, exp: Id) {
        self.factors.entry(base).or_default().push((Q::ONE, exp));
    }
}

/// The direct subexpressions of a node.
pub fn children(node: &Node) -> Vec<Id> {
    match node {
        Node::Number(_) | Node::Float(_) | Node::Pi | Node::Leaf(_) => Vec::new(),
        Node::Sum(_, terms) => terms.iter().map(|(_, t)| *t).collect(),
        Node::Product(f) => f.iter().flat_map(|(b, e)| [*b, *e]).collect(),
        Node::Call(_, args) => args.clone(),
    }
}
