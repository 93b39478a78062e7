//! The change of measure by way of a direction of which the result is made, such as a half vector about which
//! another direction is reflected: that of the direction, times that of the result as a map of directions.

use super::Problem;
use crate::expr::{Deps, Graph, Id, Leaf, Node, leaf_bit};
use crate::hash::Map;
use crate::interval::Interval;
use crate::jacobian::{self, Source, moved, sphere};
use crate::matrix::dot;
use crate::rational::Q;
use crate::sorted;

/// How many equal forms are kept.
const FORMS: usize = 4;

/// The volume of a sampler whose result is a function of a direction in its body, and not that direction itself.
/// `None` if there is no such direction.
pub(super) fn volume(problem: &mut Problem) -> Option<Vec<Id>> {
    if problem.argument.is_some() || problem.parts.len() != 1 || problem.unknowns.len() != 2 {
        return None;
    }
    let unit = problem.is_direction();
    let (outputs, unknowns) = (problem.outputs.clone(), problem.unknowns.clone());
    let (g, lengths) = (&mut problem.graph, &mut problem.lengths);
    g.vectors().to_vec().into_iter().find_map(|h| {
        let is_drawn = unknowns.iter().all(|&u| h.iter().any(|&c| g.has(c, leaf_bit(u))));
        if h[..] == outputs[..] || !is_drawn || !sphere::is_unit(g, &h) {
            return None;
        }
        let own = unknowns.iter().fold(0, |bits, &u| bits | leaf_bit(u));
        let mut named = Named::new(g, h, unknowns.len() as u8, own);
        let (inner, leaves) = (named.leaves, named.inputs());
        let map: Vec<Id> = outputs.iter().map(|&x| named.of(g, x)).collect::<Option<_>>()?;
        let outer =
            jacobian::volume(g, &map, &leaves, (Source::Direction(inner), unit), &[]).ok()?;
        let first = match sphere::area(g, &h, &unknowns) {
            Some(forms) => forms,
            None => jacobian::volume(g, &h, &unknowns, (Source::Free, true), &[]).ok()?,
        };
        let back = sorted::map(inner.into_iter().zip(h));
        if let Some((a, b)) = moved::taken_apart(g, &map, inner) {
            // Where a is small, h is hardly known, but the length of what is left of x is.
            lengths.push((g.substitute(a, &back), left_of_point(g, b)));
        }
        let outer: Vec<Id> = outer.iter().map(|&v| g.substitute(v, &back)).collect();
        let pairs = first.iter().flat_map(|&a| outer.iter().map(move |&b| (a, b)));
        Some(pairs.take(FORMS).map(|(a, b)| g.mul(a, b)).collect())
    })
}

/// The length of the point without `b`.
fn left_of_point(g: &mut Graph, b: [Id; 3]) -> Id {
    let left: Vec<Id> = (0..3u8)
        .map(|i| {
            let x = g.get_leaf(Leaf::Out(i));
            g.sub(x, b[usize::from(i)])
        })
        .collect();
    let squared = dot(g, &left, &left);
    g.sqrt(squared)
}

/// Expressions in which the coordinates of a vector have names.
pub(super) struct Named {
    h: [Id; 3],
    /// The names.
    pub(super) leaves: [Id; 3],
    first: u8,
    /// The inputs that must not be left.
    own: Deps,
    known: Map<Id, Option<Id>>,
}

impl Named {
    /// Names for the coordinates of `h`, the unknowns from number `first` on, in place of the inputs `own`.
    pub(super) fn new(g: &mut Graph, h: [Id; 3], first: u8, own: Deps) -> Named {
        let names = ["h.x", "h.y", "h.z"];
        let range = Interval::new(-1.0, 1.0);
        let leaves =
            std::array::from_fn(|i| g.leaf(Leaf::Unknown(first + i as u8), names[i], range));
        Named { h, leaves, first, own, known: Map::default() }
    }

    /// The names as inputs.
    pub(super) fn inputs(&self) -> [Leaf; 3] {
        [0, 1, 2].map(|i| Leaf::Unknown(self.first + i))
    }

    /// An expression in terms of the vector; `None` if it depends on the inputs otherwise.
    pub(super) fn of(&mut self, g: &mut Graph, id: Id) -> Option<Id> {
        if !g.has(id, self.own) {
            return Some(id);
        }
        if let Some(i) = self.h.iter().position(|&c| c == id) {
            return Some(self.leaves[i]);
        }
        if let Some(known) = self.known.get(&id) {
            return *known;
        }
        let found = self.of_node(g, id);
        self.known.insert(id, found);
        found
    }

    fn of_node(&mut self, g: &mut Graph, id: Id) -> Option<Id> {
        match g.node(id).clone() {
            Node::Sum(c, terms) => {
                let terms: Option<Vec<(Q, Id)>> =
                    terms.iter().map(|&(q, t)| Some((q, self.of(g, t)?))).collect();
                Some(g.sum(c, &terms?))
            }
            Node::Product(_) => {
                let (mut product, mut rest) = (g.int(1), id);
                while let Some((name, body)) = self.contained(g, rest) {
                    product = g.mul(product, name);
                    rest = g.div(rest, body);
                }
                let (q, body) = g.split(rest);
                for (base, exponent) in g.factors(body) {
                    let (base, exponent) = (self.of(g, base)?, self.of(g, exponent)?);
                    let power = g.pow(base, exponent);
                    product = g.mul(product, power);
                }
                Some(g.sum(Q::ZERO, &[(q, product)]))
            }
            Node::Call(f, args) => {
                let args: Option<Vec<Id>> = args.iter().map(|&a| self.of(g, a)).collect();
                Some(g.call(f, &args?))
            }
            _ => None,
        }
    }

    /// A coordinate, one over a coordinate or a ratio of two that a product contains, as what takes the place of some of its
    /// factors: that with the most of them, as the others may be parts of it.
    fn contained(&self, g: &mut Graph, id: Id) -> Option<(Id, Id)> {
        let (_, body) = g.split(id);
        let all = g.factors(body);
        let mut best: Option<(usize, (Id, Id))> = None;
        for (name, coordinate) in self.monomials(g) {
            let (q, body) = g.split(coordinate);
            let own: Vec<(Id, Id)> = g
                .factors(body)
                .into_iter()
                .filter(|&(b, e)| g.has(b, self.own) || g.has(e, self.own))
                .collect();
            let is_part = |&(base, exponent): &(Id, Id)| {
                all.iter().any(|&(b, e)| b == base && is_part_of(g, exponent, e))
            };
            let most = best.is_none_or(|(count, _)| own.len() > count);
            if most && !own.is_empty() && own.iter().all(is_part) {
                best = Some((own.len(), (g.sum(Q::ZERO, &[(q.recip()?, name)]), body)));
            }
        }
        best.map(|(_, found)| found)
    }

    /// The coordinates, one over each, and the ratios of two: by names, and what they are.
    fn monomials(&self, g: &mut Graph) -> Vec<(Id, Id)> {
        let pairs: Vec<(Id, Id)> = self.leaves.into_iter().zip(self.h).collect();
        let zero = g.int(0);
        let divisors: Vec<(Id, Id)> = pairs.iter().copied().filter(|p| p.1 != zero).collect();
        let mut all = pairs.clone();
        all.extend(divisors.iter().map(|&(name, c)| (g.powi(name, -1), g.powi(c, -1))));
        for &(over, below) in &divisors {
            for &(name, c) in pairs.iter().filter(|p| p.0 != over) {
                all.push((g.div(name, over), g.div(c, below)));
            }
        }
        all
    }
}

/// Whether a power has another one, with this exponent, in it.
fn is_part_of(g: &Graph, exponent: Id, of: Id) -> bool {
    let sizes = g.as_number(exponent).zip(g.as_number(of));
    exponent == of
        || sizes.is_some_and(|(e, of)| {
            let (e, of) = (e.to_f64(), of.to_f64());
            e * of > 0.0 && of.abs() >= e.abs()
        })
}
