//! Sums as text, and how large their terms are together.

use proc_macro2::TokenStream;
use quote::quote;

use super::Code;
use super::literal::{multiple_of, rational, times};
use super::parts::Parts;
use crate::expr::{Id, Node};
use crate::rational::Q;

impl Code<'_> {
    pub(super) fn sum(&self, c: Q, terms: &[(Q, Id)]) -> TokenStream {
        // One factor of many terms is a factor of their sum.
        let size = terms.first().map_or(Q::ONE, |(q, _)| q.abs());
        let alike = c.is_zero() && terms.len() > 1 && terms.iter().all(|(q, _)| q.abs() == size);
        // A sum of negative terms is a negative sum.
        let negative = alike && terms.iter().all(|(q, _)| q.is_negative());
        if alike && (size != Q::ONE || negative) {
            let sign = |q: Q| if q.is_negative() == negative { Q::ONE } else { Q::int(-1) };
            let signs: Vec<(Q, Id)> = terms.iter().map(|&(q, t)| (sign(q), t)).collect();
            let sum = self.sum(c, &signs);
            let sum = if size == Q::ONE { sum } else { times(size, &quote!((#sum))) };
            return if negative { quote!(-(#sum)) } else { sum };
        }
        // In the order in which forms were measured: (1 - u) + u p is not (1 + u p) - u.
        let mut out: Option<TokenStream> = None;
        let mut add = |negative: bool, term: TokenStream| {
            out = Some(match (out.take(), negative) {
                (None, false) => term,
                (None, true) => quote!(-(#term)),
                (Some(o), false) => quote!(#o + #term),
                (Some(o), true) => quote!(#o - #term),
            });
        };
        let written = |(q, t): (Q, Id)| {
            let t = self.reference(t);
            let size = q.abs();
            (q.is_negative(), if size == Q::ONE { t } else { times(size, &t) })
        };
        let first = self.graph.anchored(c, terms);
        let anchored = first.into_iter().flat_map(|(j, k)| [j, k]);
        let anchored: Vec<usize> = anchored.collect();
        for &i in &anchored {
            let (negative, term) = written(terms[i]);
            add(negative, term);
        }
        if !c.is_zero() {
            add(c.is_negative(), rational(c.abs()));
        }
        for (_, term) in terms.iter().enumerate().filter(|(i, _)| !anchored.contains(i)) {
            let (negative, term) = written(*term);
            add(negative, term);
        }
        out.unwrap_or_else(|| quote!(R::ZERO))
    }

    /// How large the terms of a sum are together: what its rounding is relative to; of a product, that of its factors.
    pub(super) fn scale(&self, id: Id) -> TokenStream {
        match self.graph.node(id) {
            Node::Sum(c, terms) => match terms[..] {
                [(q, term)] if c.is_zero() => multiple_of(q.abs(), self.scale(term)),
                _ => {
                    let constant = (!c.is_zero()).then(|| rational(c.abs()));
                    let written = |&(q, t): &(Q, Id)| {
                        let t = self.reference(t);
                        multiple_of(q.abs(), quote!(#t.abs()))
                    };
                    let sizes = constant.into_iter().chain(terms.iter().map(written));
                    quote!((#(#sizes)+*))
                }
            },
            Node::Product(factors) => {
                let mut parts = Parts::default();
                for &(b, e) in factors {
                    match self.graph.as_number(e) {
                        Some(q) if !q.is_negative() => parts.push(&self.scale(b), q),
                        Some(q) => {
                            let b = self.reference(b);
                            parts.push(&quote!(#b.abs()), q);
                        }
                        None => {
                            let power = self.power(b, e);
                            parts.top.extend(power.map(|power| quote!(#power.abs())));
                        }
                    }
                }
                let product = parts.finish();
                quote!((#product))
            }
            _ => {
                let value = self.reference(id);
                quote!(#value.abs())
            }
        }
    }
}
