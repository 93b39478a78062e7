//! The expression graph: hash-consed nodes in a canonical form.
//!
//! Sums carry an exact constant and rational coefficients; products carry (base, exponent) pairs
//! whose exponents are expressions themselves. Equal expressions have equal ids, so comparing ids
//! is comparing expressions, and sharing is free. Nothing is ever multiplied out here: the written
//! shape of a sampler is what its author meant to be evaluated ([`crate::poly`] expands on demand).

mod build;
mod declared;
mod index;
mod power;
mod product;
mod range;
mod root;
mod shed;
mod substitute;
mod sum;

use std::cell::RefCell;

use crate::hash::{Map, Set};
use crate::interval::Interval;
use crate::rational::Q;
use crate::sorted;

pub use power::{Together, divided};
pub use root::{BOUNDS, Root};
pub use shed::shed;

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
    /// The real cube root of an argument that changes its sign.
    Cbrt,
    Erf,
    /// 1 - erf.
    Erfc,
    ErfInv,
    ErfcInv,
    /// ln erfc.
    LnErfc,
    /// The inverse of erfc, of the logarithm of its value.
    ErfcInvExp,
    /// The principal branch of Lambert's W.
    LambertW,
    /// ln Γ, of parameters.
    LnGamma,
    /// ln B(a, b), of parameters.
    LnBeta,
    /// The regularised incomplete beta function of x, a, b and 1 - x.
    BetaInc,
    /// Its inverse, of p, a, b and 1 - p.
    BetaIncInv,
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
    /// An angle brought to within half a turn of another one by adding a multiple of 2π.
    TurnTo,
    /// (1 + a)^e, accurate for small a.
    Pow1p,
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
    /// The variable of a [`Root`], bound by it.
    Bound(u8),
}

/// A node of the graph.
#[derive(Clone, PartialEq, Eq, Debug)]
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
    /// A function of one to three arguments.
    Call(Fun, Vec<Id>),
    /// The second where the first is greater than zero, else the third.
    If(Id, Id, Id),
    /// Where a function without a closed inverse has some value.
    Root(Root),
}

/// Which inputs an expression depends on, as a bit set.
pub type Deps = u128;

/// The bit of an input.
pub fn leaf_bit(leaf: Leaf) -> Deps {
    match leaf {
        Leaf::Unknown(i) => 1 << i,
        Leaf::Out(i) => 1 << (24 + i),
        Leaf::Param(i) => 1 << (48 + i.min(75)),
        Leaf::Bound(i) => 1 << (124 + i % 4),
    }
}

/// The bits of all unknowns.
pub const UNKNOWNS: Deps = (1 << 24) - 1;
/// The bits of all coordinates of the query point.
pub const OUTS: Deps = ((1 << 24) - 1) << 24;

/// A vector that a frame turns from its own coordinates to those of the world.
#[derive(Clone, Debug)]
pub struct TurnedVector {
    /// The axes of the frame.
    pub axes: [[Id; 3]; 3],
    /// The vector in the coordinates of the frame.
    pub inside: [Id; 3],
    /// The vector in those of the world.
    pub written: [Id; 3],
}

/// The arena of expressions.
#[derive(Clone, Default)]
pub struct Graph {
    nodes: Vec<Node>,
    ranges: Vec<Interval>,
    deps: Vec<Deps>,
    index: index::Index,
    /// The small whole numbers that were asked for, from the least.
    small: [Option<Id>; 8],
    leaf_ranges: Map<Leaf, Interval>,
    names: Map<Leaf, String>,
    units: Vec<[Id; 3]>,
    vectors: Vec<[Id; 3]>,
    made_frames: Vec<[[Id; 3]; 3]>,
    turned: Vec<TurnedVector>,
    /// Known ranges of quotients: numerator, denominator.
    quotients: Vec<(Id, Id, Interval)>,
    /// What [`crate::poly`] made of expressions, as long as ranges stay what they are.
    pub(crate) expanded: crate::poly::Known,
    /// Work to evaluate expressions, by [`crate::jacobian::cost`].
    pub(crate) costs: RefCell<Map<Id, usize>>,
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
    /// Makes it known that an expression lies in `interval`, for it and all that contains it.
    pub fn assume(&mut self, id: Id, interval: Interval) {
        self.expanded = Default::default();
        let first = id.0 as usize;
        self.ranges[first] = self.ranges[first].intersection(interval);
        for i in first + 1..self.nodes.len() {
            let range = self.range_of(&self.nodes[i]);
            self.ranges[i] = self.ranges[i].intersection(range);
        }
    }
    /// Makes it known that `numerator / denominator` lies in `interval`, also as part of products.
    pub fn assume_quotient(&mut self, numerator: Id, denominator: Id, interval: Interval) {
        let ((p, a), (q, b)) = (self.split(numerator), self.split(denominator));
        let scale = q.to_f64() / p.to_f64();
        self.quotients.push((a, b, interval.scale(scale)));
        let quotient = self.div(a, b);
        self.assume(quotient, interval.scale(scale));
    }
    /// An expression of another graph, whose inputs this one has too.
    pub fn import(&mut self, from: &Graph, id: Id) -> Id {
        match from.node(id) {
            Node::Number(q) => self.number(*q),
            Node::Leaf(l) => self.get_leaf(*l),
            Node::Sum(c, terms) => {
                let terms: Vec<_> = terms.iter().map(|&(q, t)| (q, self.import(from, t))).collect();
                self.sum(*c, &terms)
            }
            Node::Product(factors) => {
                let factors: Vec<_> = factors
                    .iter()
                    .map(|&(b, e)| (self.import(from, b), self.import(from, e)))
                    .collect();
                self.product(&factors)
            }
            Node::Call(f, args) => {
                let args: Vec<_> = args.iter().map(|&a| self.import(from, a)).collect();
                self.call(*f, &args)
            }
            Node::If(test, yes, no) => {
                let [test, yes, no] = [test, yes, no].map(|part| self.import(from, *part));
                self.if_positive(test, yes, no)
            }
            // The ends of segments, which is all that is ever imported, hold no roots.
            Node::Root(_) => self.float(f64::NAN),
            node @ (Node::Float(_) | Node::Pi) => self.intern(node.clone()),
        }
    }
    /// The inputs that the expression depends on.
    pub fn deps(&self, id: Id) -> Deps {
        self.deps[id.0 as usize]
    }
    /// Whether the expression depends on any of `set`.
    pub fn has(&self, id: Id, set: Deps) -> bool {
        self.deps(id) & set != 0
    }

    /// All expressions in some, these included, each once.
    pub fn within(&self, ids: &[Id]) -> Vec<Id> {
        let (mut open, mut seen, mut found) = (ids.to_vec(), Set::default(), Vec::new());
        while let Some(id) = open.pop() {
            if seen.insert(id) {
                found.push(id);
                open.extend(children(self.node(id)));
            }
        }
        found
    }

    /// Of a sum of more than them, two coordinates of a point whose difference is to be taken first: both may be
    /// large, and the rest would be lost in either.
    pub fn anchored(&self, c: Q, terms: &[(Q, Id)]) -> Option<(usize, usize)> {
        if terms.len() < 2 || (c.is_zero() && terms.len() == 2) {
            return None;
        }
        let is_open = |&(_, t): &(Q, Id)| match self.node(t) {
            Node::Leaf(Leaf::Out(_)) => {
                let range = self.range(t);
                range.lo == f64::NEG_INFINITY && range.hi == f64::INFINITY
            }
            _ => false,
        };
        let (j, large) = terms.iter().enumerate().find(|(_, term)| is_open(term))?;
        let rest = terms.iter().enumerate().skip(j + 1);
        let opposite =
            rest.filter(|(_, (q, _))| *q == large.0.neg()).find(|(_, term)| is_open(term));
        opposite.map(|(k, _)| (j, k))
    }

    /// Σ coefficient · term without the rules for sums, for the equation of a unit vector.
    pub fn plain_sum(&mut self, terms: &[(Q, Id)]) -> Id {
        let mut list = terms.to_vec();
        sorted::sort_by_key(&mut list, |(_, t)| *t);
        self.intern(Node::Sum(Q::ZERO, list))
    }

    fn intern(&mut self, node: Node) -> Id {
        let hash = match self.index.find(&self.nodes, &node) {
            Ok(id) => return id,
            Err(hash) => hash,
        };
        let range = self.range_of_new(&node);
        self.ranges.push(range);
        self.deps.push(self.deps_of(&node));
        self.nodes.push(node);
        self.index.enter(hash)
    }

    fn deps_of(&self, node: &Node) -> Deps {
        match node {
            Node::Leaf(l) => leaf_bit(*l),
            Node::Root(r) => self.deps_of_root(r),
            _ => children(node).iter().fold(0, |d, c| d | self.deps(*c)),
        }
    }

    /// The exact rational value, if the expression is one.
    pub fn as_number(&self, id: Id) -> Option<Q> {
        if let Node::Number(q) = self.node(id) { Some(*q) } else { None }
    }
}

/// The direct subexpressions of a node; not those that contain a variable which it binds.
pub fn children(node: &Node) -> Vec<Id> {
    match node {
        Node::Number(_) | Node::Float(_) | Node::Pi | Node::Leaf(_) => Vec::new(),
        Node::Sum(_, terms) => terms.iter().map(|(_, t)| *t).collect(),
        Node::Product(f) => f.iter().flat_map(|(b, e)| [*b, *e]).collect(),
        Node::Call(_, args) => args.clone(),
        Node::If(test, yes, no) => vec![*test, *yes, *no],
        Node::Root(r) => vec![r.target, r.lo, r.hi],
    }
}
