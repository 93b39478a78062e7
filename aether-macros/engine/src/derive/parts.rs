//! Results whose coordinates are parts of a whole: a linear combination of them is one.
//!
//! The last part of a stick is what the others leave, and 1 - x is known no better than x. The sum
//! of the other coordinates is, whatever the size of x. Such a result lies in a plane, so that the
//! Jacobian of all coordinates but one is that of the result, up to a constant.

use crate::derivative::derivative;
use crate::expr::{Fun, Graph, Id, Leaf, Node};
use crate::functions::leads_negative;
use crate::jacobian::{cost, simplify};
use crate::matrix::{determinant, dot};
use crate::poly::{Expander, parts_of_one};
use crate::rational::Q;

use super::{Problem, Target};

/// Coefficients of the coordinates whose sum is one.
pub(super) struct Whole(Vec<Q>);

/// What the parts of the result add up to, if they do.
pub(super) fn whole(problem: &mut Problem) -> Option<Whole> {
    let embedded = matches!(problem.parts[..], [part] if part.target == Target::Embedded);
    if !embedded || problem.outputs.len() != problem.unknowns.len() + 1 {
        return None;
    }
    parts_of_one(&mut problem.graph, &problem.outputs).map(Whole)
}

impl Whole {
    /// The coordinates with their sums in simplest form, and √det(JᵀJ): the determinant for all
    /// coordinates but one, times the length of the coefficients over that one's.
    pub(super) fn volume(&self, problem: &mut Problem) -> (Vec<Id>, Vec<Id>) {
        let g = &mut problem.graph;
        let tidy: Vec<Id> = problem.outputs.iter().map(|&o| tidied(g, o)).collect();
        let usable = (0..tidy.len()).filter(|&i| !self.0[i].is_zero());
        let left_out = usable.max_by_key(|&i| cost(g, tidy[i])).unwrap_or(0);
        let kept: Vec<Id> = (0..tidy.len()).filter(|i| *i != left_out).map(|i| tidy[i]).collect();
        let mut columns = Vec::new();
        for &u in &problem.unknowns {
            let slopes: Vec<Id> = kept.iter().map(|&f| derivative(g, f, u)).collect();
            columns.push(slopes.into_iter().map(|d| simplify(g, d, None)).collect());
        }
        let coefficients: Vec<Id> = self.0.iter().map(|&q| g.number(q)).collect();
        let squared = dot(g, &coefficients, &coefficients);
        let length = g.sqrt(squared);
        let length = g.div(length, coefficients[left_out]);
        let length = g.call(Fun::Abs, &[length]);
        let raw = determinant(g, &columns);
        let short = simplify(g, raw, None);
        let volumes = [short, raw].map(|d| {
            let d = g.call(Fun::Abs, &[d]);
            g.mul(length, d)
        });
        (tidy, volumes.to_vec())
    }

    /// An expression of the point with the whole for the constants of its sums, wherever terms of both
    /// signs become terms of one.
    pub(super) fn put_into(&self, g: &mut Graph, id: Id) -> Id {
        match g.node(id).clone() {
            Node::Sum(c, terms) => {
                let terms: Vec<(Q, Id)> =
                    terms.into_iter().map(|(q, t)| (q, self.put_into(g, t))).collect();
                let plain = g.sum(c, &terms);
                self.without_constant(g, c, terms)
                    .filter(|form| one_sign(g, *form) && !one_sign(g, plain))
                    .unwrap_or(plain)
            }
            Node::Product(factors) => {
                let mut list = Vec::new();
                for (b, e) in factors {
                    let b = self.put_into(g, b);
                    list.extend(positive(g, b, e));
                }
                g.product(&list)
            }
            Node::Call(f, args) => {
                let args: Vec<Id> = args.into_iter().map(|a| self.put_into(g, a)).collect();
                g.call(f, &args)
            }
            _ => id,
        }
    }

    /// The sum with c times the whole in place of c.
    fn without_constant(&self, g: &mut Graph, c: Q, mut terms: Vec<(Q, Id)>) -> Option<Id> {
        if c.is_zero() {
            return None;
        }
        for (i, q) in self.0.iter().enumerate() {
            terms.push((q.mul(c)?, g.get_leaf(Leaf::Out(i as u8))));
        }
        Some(g.sum(Q::ZERO, &terms))
    }
}

/// A power of a sum of negative terms as one of positive terms and one of -1.
fn positive(g: &mut Graph, base: Id, exponent: Id) -> Vec<(Id, Id)> {
    let whole = g.as_number(exponent).is_some_and(Q::is_int);
    match g.node(base) {
        Node::Sum(..) if whole && leads_negative(g, base) => {
            vec![(g.neg(base), exponent), (g.int(-1), exponent)]
        }
        _ => vec![(base, exponent)],
    }
}

/// Whether the terms of a sum have one sign; the parts of a whole are taken for positive.
pub(super) fn one_sign(g: &Graph, id: Id) -> bool {
    let Node::Sum(c, terms) = g.node(id) else { return true };
    let constant = (!c.is_zero()).then_some(*c);
    let mut signs = terms.iter().map(|(q, _)| *q).chain(constant).map(Q::is_negative);
    signs.next().is_none_or(|first| signs.all(|s| s == first))
}

fn is_product(g: &mut Graph, id: Id) -> bool {
    let (_, body) = g.split(id);
    matches!(g.node(body), Node::Product(_))
}

/// An expression with every sum as a product where it is one, and in its simplest form else.
pub(super) fn tidied(g: &mut Graph, id: Id) -> Id {
    match g.node(id).clone() {
        Node::Sum(c, terms) => {
            let terms: Vec<(Q, Id)> = terms.into_iter().map(|(q, t)| (q, tidied(g, t))).collect();
            let sum = g.sum(c, &terms);
            match Expander::new(g).normal_form(sum) {
                Some(n) if is_product(g, n) => n,
                _ => simplify(g, sum, None),
            }
        }
        Node::Product(factors) => {
            let factors: Vec<(Id, Id)> =
                factors.into_iter().map(|(b, e)| (tidied(g, b), e)).collect();
            g.product(&factors)
        }
        Node::Call(f, args) => {
            let args: Vec<Id> = args.into_iter().map(|a| tidied(g, a)).collect();
            g.call(f, &args)
        }
        _ => id,
    }
}
