//! Roots, above all of sums whose terms leave the range of numbers where the root does not.

use proc_macro2::TokenStream;
use quote::quote;

use super::Code;
use super::literal::{joined, rational};
use super::parts::Parts;
use crate::expr::{Deps, Fun, Graph, Id, Node, OUTS, UNKNOWNS};
use crate::overflow::SAFE;
use crate::rational::Q;

/// What is larger has its part in a product's being too large.
const LARGE: f64 = 1e6;

impl Code<'_> {
    /// Writes the root of a sum of squares, which has to be looked after, once for all that it divides.
    pub(super) fn write_rescued(&mut self, b: Id) {
        if self.scaled_squares(b).is_none() {
            if let Some(scaled) = self.large_squares(b) {
                let base = self.reference(b);
                let root = quote!(::aether_core::support::large_root(#base, move |up: R| #scaled));
                let name = self.named(&root);
                self.rescued.insert(b, name);
            }
            return;
        }
        // What is seldom asked for takes numbers, not places in memory where they had to be for it.
        for leaf in bases(self.graph, b) {
            if let Some(value) = self.atom(leaf).filter(|_| !self.names.contains_key(&leaf)) {
                self.write(leaf, &value);
            }
        }
        let base = self.reference(b);
        if let Some(scaled) = self.scaled_squares(b) {
            let root = quote!(::aether_core::support::root(#base, move |up: R| #scaled));
            let name = self.named(&root);
            self.rescued.insert(b, name);
        }
    }

    /// √base; a sum of squares small enough to underflow is computed again on another scale.
    pub(super) fn root(&self, b: Id, base: &TokenStream) -> TokenStream {
        self.rescued.get(&b).cloned().unwrap_or_else(|| quote!(#base.sqrt()))
    }

    /// A number and squares, some of which overflow where exponentials of parameters do not, each square times `up`.
    fn large_squares(&self, b: Id) -> Option<TokenStream> {
        let Node::Sum(c, terms) = self.graph.node(b) else { return None };
        if c.is_zero() || c.is_negative() || !terms.iter().any(|(_, t)| self.may_overflow(*t)) {
            return None;
        }
        let scaled = terms.iter().map(|(q, t)| {
            let Node::Product(factors) = self.graph.node(*t) else { return None };
            let is_square = |(_, e): &(Id, Id)| self.graph.as_number(*e) == Some(Q::int(2));
            if q.is_negative() || !factors.iter().all(is_square) {
                return None;
            }
            let bases: Vec<_> =
                factors.iter().map(|(b, _)| self.known(*b)).collect::<Option<_>>()?;
            let (base, k) = (joined(&bases), rational(*q));
            Some(quote!({ let q = #base * up; q * q * #k }))
        });
        let scaled: Vec<TokenStream> = scaled.collect::<Option<_>>()?;
        let c = rational(*c);
        Some(quote!(up * up * #c + #(#scaled)+*))
    }

    /// Whether the square of an exponential of parameters is a factor that overflows in single precision.
    fn may_overflow(&self, term: Id) -> bool {
        let Node::Product(factors) = self.graph.node(term) else { return false };
        factors.iter().any(|(b, _)| match self.graph.node(*b) {
            Node::Call(Fun::Cosh | Fun::Sinh | Fun::Exp | Fun::ExpM1, args) => {
                let range = self.graph.range(args[0]);
                range.hi.max(-range.lo) > 0.5 * SAFE && self.graph.deps(*b) & (UNKNOWNS | OUTS) == 0
            }
            _ => false,
        })
    }

    /// A sum of squares (with factors that are not negative), each square times `up`.
    pub(super) fn scaled_squares(&self, b: Id) -> Option<TokenStream> {
        let Node::Sum(c, terms) = self.graph.node(b) else { return None };
        if !c.is_zero() || terms.len() < 2 {
            return None;
        }
        let scaled = terms.iter().map(|(q, t)| {
            let Node::Product(factors) = self.graph.node(*t) else { return None };
            let two = |e: &Id| self.graph.as_number(*e) == Some(Q::int(2));
            let square = factors.iter().position(|(_, e)| two(e))?;
            let others = factors.iter().enumerate().filter(|(i, _)| *i != square);
            let mut product = Parts::default();
            for (_, (b, e)) in others {
                if !self.graph.range(*b).nonnegative() && !two(e) {
                    return None;
                }
                product.push(&self.known(*b)?, self.graph.as_number(*e)?);
            }
            let others = product.finish();
            let base = self.known(factors[square].0)?;
            let k = rational(*q);
            (!q.is_negative()).then(|| quote!((#base * up) * (#base * up) * #others * #k))
        });
        let scaled: Vec<TokenStream> = scaled.collect::<Option<_>>()?;
        Some(quote!(#(#scaled)+*))
    }

    /// Whether the product of the factors on one side that have a root is larger than any number of single precision where the
    /// parameter that all large ones have is as large as it is declared to be.
    pub(super) fn overflows(&self, factors: &[(Id, Id)], below: bool) -> bool {
        let has_root = |e: Id| {
            self.graph.as_number(e).is_some_and(|q| q.den() == 2 && q.is_negative() == below)
        };
        let under = factors.iter().filter(|(_, e)| has_root(*e)).map(|(b, _)| *b);
        let bounded = under.filter(|b| self.graph.range(*b).hi.is_finite());
        let (largest, shared) = bounded.fold((1.0, Deps::MAX), |(largest, shared), b| {
            let hi = self.graph.range(b).hi;
            (largest * hi, if hi > LARGE { shared & self.graph.deps(b) } else { shared })
        });
        largest > f64::from(f32::MAX) && shared & !(UNKNOWNS | OUTS) != 0
    }

    /// The root, above or below the line, that all factors have which are no numbers and have one: with numbers on the
    /// same side there is one root, and the same where else the product occurs, instead of a quotient of two.
    pub(super) fn side_of_roots(&self, factors: &[(Id, Id)]) -> Option<Q> {
        let exponents = factors.iter().filter(|(b, _)| self.graph.deps(*b) != 0);
        let mut halves = exponents
            .filter_map(|(_, e)| self.graph.as_number(*e).filter(|q| q.den() == 2))
            .map(|q| q.is_negative());
        let first = halves.next()?;
        let side = if first { Q::HALF.neg() } else { Q::HALF };
        halves.all(|below| below == first).then_some(side)
    }
}

/// The inputs among the bases of a sum of products.
fn bases(g: &Graph, id: Id) -> Vec<Id> {
    let Node::Sum(_, terms) = g.node(id) else { return Vec::new() };
    let factors = terms.iter().flat_map(|(_, term)| match g.node(*term) {
        Node::Product(factors) => factors.as_slice(),
        _ => &[],
    });
    let bases = factors.map(|(base, _)| *base);
    bases.filter(|base| matches!(g.node(*base), Node::Leaf(_))).collect()
}
