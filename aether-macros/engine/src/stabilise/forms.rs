//! The forms that are tried for an expression.

use super::conjugates::{conjugate, over_sum, squares};
use super::ends::{
    between_ends, both_sides_of_one, by_halves, flipped, one_minus, other_tail, over_ends,
};
use super::turned::of_turn;
use super::{angles, collect, exponential, hyperbolic};
use crate::expr::{Fun, Graph, Id, Node};
use crate::jacobian::factor_out;
use crate::multiples::of_multiple;
use crate::poly::Expander;
use crate::rational::Q;

/// Other forms of a node that are equal in exact arithmetic.
pub(super) fn other_forms(g: &mut Graph, id: Id, turns: bool) -> Vec<Id> {
    let mut out = Vec::new();
    match g.node(id).clone() {
        Node::Sum(c, terms) => {
            out.extend(one_minus(g, c, &terms));
            out.extend(other_tail(g, c, &terms));
            let between = between_ends(g, id);
            out.extend(between);
            out.extend(between.and_then(|form| over_ends(g, form)));
            out.extend(exponential::weighted_mean(g, c, &terms));
            out.extend(exponential::other_end(g, c, &terms));
            out.extend(half_angle(g, c, &terms));
            out.extend(squares(g, c, &terms));
            out.extend(conjugate(g, c, &terms));
            out.extend(over_sum(g, c, &terms));
            out.extend(angles::difference(g, c, &terms));
            out.extend(angles::as_product(g, c, &terms));
            out.extend(collect::by_coordinate(g, c, &terms));
            let f = factor_out(g, id);
            out.push(f);
            for open in [crate::expr::UNKNOWNS | crate::expr::OUTS, crate::expr::Deps::MAX] {
                out.extend(Expander::new(g).only(open).normal_form(id));
            }
        }
        Node::Call(Fun::Ln, args) => {
            if let Node::Sum(c, terms) = g.node(args[0]).clone()
                && c == Q::ONE
            {
                let rest = g.sum(Q::ZERO, &terms);
                out.push(g.call(Fun::Ln1p, &[rest]));
            }
        }
        Node::Call(f @ (Fun::Asin | Fun::Acos), args) => out.push(by_halves(g, f, args[0])),
        Node::Call(Fun::Ln1p, args) => out.extend(exponential::by_size(g, id, args[0])),
        Node::Call(Fun::BetaInc | Fun::BetaIncInv, _) => {
            out.extend(flipped(g, id).map(|f| g.sum(Q::ONE, &[(Q::int(-1), f)])));
        }
        Node::Product(factors) => {
            out.extend(both_sides_of_one(g, &factors));
            out.extend(exponential::over_largest(g, &factors));
            for (k, &(b, e)) in factors.iter().enumerate() {
                let Node::Sum(c, terms) = g.node(b).clone() else { continue };
                if c == Q::ONE && g.as_number(e).is_none_or(|e| !e.is_int() && e.den() > 3) {
                    let rest = g.sum(Q::ZERO, &terms);
                    let mut factors = factors.clone();
                    factors[k] = (g.call(Fun::Pow1p, &[rest, e]), g.int(1));
                    out.push(g.product(&factors));
                }
            }
        }
        Node::Call(Fun::Acosh, args) => out.extend(hyperbolic::beside_one(g, args[0])),
        Node::Call(f @ (Fun::Sinh | Fun::Cosh | Fun::Tanh), args) => {
            out.extend(of_multiple(g, f, args[0]));
        }
        Node::Call(f @ (Fun::Sin | Fun::Cos | Fun::Tan), args) => {
            out.extend(of_multiple(g, f, args[0]));
            out.extend(angles::of_sum(g, f, args[0]));
            if turns {
                out.extend(of_turn(g, id));
            }
        }
        _ => {}
    }
    out.retain(|f| *f != id);
    out
}

/// c + k cos a as (c + k) - 2 k sin²(a/2), for a sum of two terms, where k may contain parameters.
fn half_angle(g: &mut Graph, c: Q, terms: &[(Q, Id)]) -> Option<Id> {
    let [(q, t)] = *terms else { return None };
    let one = g.int(1);
    let factors = g.factors(t);
    let (cosine, a) = factors.iter().find_map(|&(b, e)| match g.node(b) {
        Node::Call(Fun::Cos, a) if e == one => Some((b, a[0])),
        _ => None,
    })?;
    let k = g.div(t, cosine);
    let half = g.sum(Q::ZERO, &[(Q::HALF, a)]);
    let s = g.call(Fun::Sin, &[half]);
    let s2 = g.powi(s, 2);
    let second = g.mul(k, s2);
    let first = g.sum(c, &[(q, k)]);
    Some(g.sum(Q::ZERO, &[(Q::ONE, first), (q.mul(Q::int(-2))?, second)]))
}
