//! The ends of a body: densities of what was drawn, atoms, other strategies.

use proc_macro2::{Span, TokenStream};
use quote::quote_spanned;
use syn::Ident;
use syn::spanned::Spanned;

use super::kinds::Kinds;
use super::{Emitter, Pending, part};
use crate::strategy::tree::{Action, End, Kind, Leaf, Plan};

impl Emitter<'_> {
    pub(super) fn end(&self, end: &End<Action, Leaf>, pending: &Pending) -> TokenStream {
        let (real, site) = (self.real, Span::mixed_site());
        let all = Kinds::of_end(end);
        let block = |plan: &Plan, pending: &Pending| {
            let kinds = Kinds::of_end(&plan.end);
            if kinds == Kinds::default() {
                return TokenStream::new();
            }
            let rest = self.rest(&plan.steps, &plan.end, pending);
            if kinds == all {
                return rest;
            }
            let asked = kinds.asked();
            quote_spanned!(site=> if #asked { #rest })
        };
        match end {
            End::Stop => TokenStream::new(),
            End::Delegate { strategy, number } => {
                let term = quote_spanned! {site=>
                    sum += ::aether_core::forms::emitted::delegated_pdf(
                        &#strategy, &view, target, probability,
                    );
                };
                if self.ways {
                    quote_spanned!(site=> if !(same && way == #number) { #term })
                } else {
                    term
                }
            }
            End::Vertex(leaf) => self.leaf(leaf, pending),
            End::If { condition, late: true, then, otherwise } => {
                let zero = quote_spanned!(site=> <#real as ::aether_core::Real>::ZERO);
                let holds = quote_spanned!(site=> if !(#condition) { return #zero; });
                let fails = quote_spanned!(site=> if #condition { return #zero; });
                let then = block(then, &pending.factor(holds));
                let otherwise = block(otherwise, &pending.factor(fails));
                quote_spanned!(site=> { #then } { #otherwise })
            }
            End::If { condition, then, otherwise, .. } => {
                let (then, otherwise) = (block(then, pending), block(otherwise, pending));
                quote_spanned!(site=> if #condition { #then } else { #otherwise })
            }
            End::Match { value, arms } => {
                let arms = arms.iter().map(|(pat, arm)| {
                    let arm = block(arm, pending);
                    quote_spanned!(site=> #pat => { #arm })
                });
                quote_spanned!(site=> match #value { #(#arms)* })
            }
        }
    }

    fn leaf(&self, leaf: &Leaf, pending: &Pending) -> TokenStream {
        // A space that does not fit the vertex is reported at the vertex expression.
        let site = leaf.vertex.span().resolved_at(Span::mixed_site());
        let dirac = quote_spanned!(site=> ::aether_core::strategy::Dirac);
        let other = self.is_other(leaf, site);
        let atom = |kind: TokenStream| {
            quote_spanned! {site=>
                if kind == ::core::option::Option::Some(#dirac::#kind) #other { sum += probability; }
            }
        };
        match &leaf.kind {
            Kind::AtomPosition => atom(quote_spanned!(site=> Position)),
            Kind::AtomDirection(None) => atom(quote_spanned!(site=> Direction)),
            Kind::AtomDirection(Some(point)) => {
                let asked = quote_spanned!(site=>
                    kind == ::core::option::Option::Some(#dirac::Direction));
                self.term(point, leaf, &asked, pending)
            }
            Kind::Density(point) => {
                self.term(point, leaf, &quote_spanned!(site=> kind.is_none()), pending)
            }
        }
    }

    /// Adds the density of a point, if that is `asked` for and not what was sampled.
    fn term(
        &self,
        point: &Ident,
        leaf: &Leaf,
        asked: &TokenStream,
        pending: &Pending,
    ) -> TokenStream {
        let site = leaf.vertex.span().resolved_at(Span::mixed_site());
        let (value, other) = (self.value(point, pending, site), self.is_other(leaf, site));
        quote_spanned!(site=> if #asked #other { sum += probability * #value; })
    }

    /// The condition, after others, that a leaf is not the one that was sampled.
    fn is_other(&self, leaf: &Leaf, site: Span) -> Option<TokenStream> {
        let number = leaf.number;
        self.ways.then(|| quote_spanned!(site=> && !(same && way == #number)))
    }

    fn value(&self, point: &Ident, pending: &Pending, site: Span) -> TokenStream {
        let (real, vertex) = (self.real, self.vertex);
        let emitted = quote_spanned!(site=> ::aether_core::forms::emitted);
        let sampler = part(point, "sampler");
        let Some(root) = pending.root.as_ref().filter(|_| pending.weighs) else {
            return quote_spanned!(site=> #emitted::density::<#vertex, _>(&#sampler, target));
        };
        let statements = &pending.statements;
        let factor = quote_spanned! {site=>
            |#root| {
                let mut factor = <#real as ::aether_core::Real>::ONE;
                #(#statements)*
                factor
            }
        };
        if root == point {
            quote_spanned!(site=>
                #emitted::density_times::<#vertex, _>(&#sampler, target, #factor))
        } else {
            let (origin, maps) = (part(root, "sampler"), part(point, "maps"));
            quote_spanned!(site=>
                #emitted::density_through::<#vertex, _, _>(&#origin, &#maps, target, #factor))
        }
    }
}
