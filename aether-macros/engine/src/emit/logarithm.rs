//! The logarithm of a density as a sum over its factors, for densities that leave the range of numbers.

use std::collections::HashSet;

use proc_macro2::TokenStream;
use quote::quote;

use super::code::{Code, number, rational};
use crate::eval::evaluate;
use crate::expr::{Fun, Graph, Id, Node, OUTS, children};
use crate::number::{Dd, Number};
use crate::rational::Q;

/// Whether the expression has exponentials, powers with a variable exponent, or quotients by what grows with a
/// coordinate without end, which is where densities become too small or too large.
pub(super) fn leaves_the_range(g: &Graph, id: Id) -> bool {
    let (mut open, mut seen) = (vec![id], HashSet::new());
    while let Some(id) = open.pop() {
        if g.deps(id) == 0 || !seen.insert(id) {
            continue;
        }
        let node = g.node(id);
        let grows = match node {
            Node::Call(f, _) => {
                matches!(f, Fun::Exp | Fun::ExpM1 | Fun::Pow1p | Fun::Cosh | Fun::Sinh)
            }
            Node::Product(factors) => factors.iter().any(|&(b, e)| match g.as_number(e) {
                Some(q) => q.is_negative() && is_unbounded(g, b),
                None => true,
            }),
            _ => false,
        };
        if grows {
            return true;
        }
        open.extend(children(node));
    }
    false
}

/// Whether a number grows with a coordinate without end.
fn is_unbounded(g: &Graph, id: Id) -> bool {
    let range = g.range(id);
    g.has(id, OUTS) && (range.hi == f64::INFINITY || range.lo == f64::NEG_INFINITY)
}

/// ln |e|.
pub(super) fn logarithm(code: &mut Code, id: Id) -> TokenStream {
    let g = code.graph();
    if g.deps(id) == 0 {
        let value = evaluate::<Dd>(g, id, &|_| Dd::from_f64(f64::NAN));
        return number(value.abs().ln().to_f64());
    }
    let value = match g.node(id) {
        Node::Product(factors) => {
            let logs: Vec<TokenStream> = factors.iter().map(|&(b, e)| power(code, b, e)).collect();
            quote!(#(#logs)+*)
        }
        Node::Sum(c, terms) => match (&terms[..], c.is_zero()) {
            ([(q, t)], true) => scaled(code, *q, *t),
            _ if all_positive(g, *c, terms) && (is_unbounded(g, id) || leaves_the_range(g, id)) => {
                let logs: Vec<TokenStream> =
                    terms.iter().map(|&(q, t)| scaled(code, q, t)).collect();
                let constant = if c.is_zero() { quote!(-R::INFINITY) } else { log_of(*c) };
                logs.iter()
                    .fold(constant, |sum, l| quote!(::aether_core::support::add_logs(#sum, #l)))
            }
            _ => plain(code, id),
        },
        Node::Call(Fun::Exp, a) => return code.value(a[0]),
        Node::Call(Fun::Pow1p, a) => {
            let (base, e) = (code.value(a[0]), code.value(a[1]));
            quote!(#e * #base.ln_1p())
        }
        Node::Call(Fun::Cosh, a) => {
            let a = code.value(a[0]);
            quote!(#a.abs() + (-(#a.abs() + #a.abs())).exp().ln_1p() - R::of(core::f64::consts::LN_2))
        }
        Node::If(test, yes, no) => {
            let test = code.value(*test);
            let [yes, no] = [yes, no].map(|side| {
                let mut inner = code.inner();
                let value = logarithm(&mut inner, *side);
                let lets = inner.statements();
                quote!({ #lets #value })
            });
            quote!(::aether_core::support::either(#test.gt(R::ZERO), || #yes, || #no))
        }
        _ => plain(code, id),
    };
    code.named(&value)
}

fn plain(code: &mut Code, id: Id) -> TokenStream {
    let value = code.value(id);
    quote!(#value.abs().ln())
}

/// ln |bᵉ|.
fn power(code: &mut Code, b: Id, e: Id) -> TokenStream {
    let log = logarithm(code, b);
    match code.graph().as_number(e) {
        Some(Q::ONE) => log,
        Some(q) => {
            let q = rational(q);
            quote!(#q * #log)
        }
        None => {
            let e = code.value(e);
            quote!(#e * #log)
        }
    }
}

/// ln |q t|.
fn scaled(code: &mut Code, q: Q, t: Id) -> TokenStream {
    let log = logarithm(code, t);
    if q.abs() == Q::ONE {
        return log;
    }
    let q = log_of(q);
    quote!(#q + #log)
}

/// ln |q|.
fn log_of(q: Q) -> TokenStream {
    number(<Dd as Number>::from_ratio(q.num(), q.den()).abs().ln().to_f64())
}

/// Whether no term is negative, so that the logarithm of the sum follows from theirs.
fn all_positive(g: &Graph, c: Q, terms: &[(Q, Id)]) -> bool {
    !c.is_negative() && terms.iter().all(|(q, t)| !q.is_negative() && g.range(*t).nonnegative())
}
