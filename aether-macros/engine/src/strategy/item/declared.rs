//! What a strategy declares of itself: atoms, classes of lengths, when it is another one.

use proc_macro2::{Span, TokenStream};
use quote::{ToTokens, quote, quote_spanned};
use syn::spanned::Spanned;
use syn::{Ident, ItemFn, Type};

use super::structure::is_reference;
use super::{is_number, parameters};
use crate::strategy::names::referenced;
use crate::strategy::reads::{Reads, comparisons};
use crate::strategy::signature::{Field, Signature};
use crate::strategy::tree::{Apart, Kind, Other, Plan};

/// Makes sure that two strategies, or one and an atom of the body, can be told apart.
pub(super) fn told_apart(Apart { strategy, other }: &Apart, vertex: &Type) -> TokenStream {
    let site = strategy.span().resolved_at(Span::mixed_site());
    let emitted = quote_spanned!(site=> ::aether_core::forms::emitted);
    match other {
        Other::Atom(direction) => quote_spanned! {site=>
            #emitted::apart_from_atom::<#vertex, _, #direction>(|| #strategy);
        },
        Other::Strategy(other) => quote_spanned! {site=>
            #emitted::apart_from::<#vertex, _, _>(|| #strategy, || #other);
        },
    }
}

/// The kinds of atoms that the body or the strategies that it delegates to may yield: any if their
/// types have no name here.
pub(super) fn atoms(signature: &Signature, plan: Option<&Plan>) -> TokenStream {
    let (site, vertex) = (Span::mixed_site(), &signature.vertex);
    let module = quote_spanned!(site=> ::aether_core::strategy);
    let (mut position, mut direction) = (false, false);
    let mut others = Vec::new();
    if let Some(plan) = plan {
        plan.walk(&mut |_| {}, &mut |leaf| match leaf.kind {
            Kind::Density(_) => {}
            Kind::AtomPosition => position = true,
            Kind::AtomDirection(_) => direction = true,
        });
        plan.delegates(&mut |strategy| {
            let field = referenced(strategy)
                .and_then(|name| signature.fields.iter().find(|field| field.name == *name));
            others.push(match field {
                Some(Field { ty, .. }) => {
                    quote_spanned!(site=> <#ty as #module::Strategy<#vertex>>::ATOMS)
                }
                None => quote_spanned!(site=> #module::Atoms::ANY),
            });
        });
    }
    quote_spanned! {site=>
        #module::Atoms { position: #position, direction: #direction } #(.and(#others))*
    }
}

/// What the body reads of the path, and what the strategies read that it delegates to.
pub(super) fn declared(signature: &Signature, reads: Reads, plan: Option<&Plan>) -> TokenStream {
    let (site, vertex) = (Span::mixed_site(), &signature.vertex);
    let Reads { vertices, length } = reads;
    let vertices =
        if vertices == usize::MAX { quote!(usize::MAX) } else { vertices.to_token_stream() };
    let mut delegates = Vec::new();
    if let Some(plan) = plan {
        plan.delegates(&mut |strategy| delegates.push(strategy));
    }
    let parameters = (!delegates.is_empty()).then(|| parameters(signature));
    quote_spanned! {site=>
        #parameters
        ::aether_core::strategy::Reads { vertices: #vertices, length: #length }
            #(.and(::aether_core::strategy::Strategy::<#vertex>::reads(&#delegates)))*
    }
}

/// The method that says which lengths of the path make no difference, where the body only compares the length.
pub(super) fn classes(
    function: &ItemFn,
    signature: &Signature,
    plan: Option<&Plan>,
) -> Option<TokenStream> {
    let site = Span::mixed_site();
    let mut delegates = false;
    plan?.delegates(&mut |_| delegates = true);
    if delegates {
        return None;
    }
    let fixed = signature.fields.iter().filter(|field| !field.mutable);
    let names: Vec<&Ident> = fixed.map(|field| &field.name).collect();
    let comparisons = comparisons(&function.block, &signature.path, &names)?;
    let parameters = parameters(signature);
    Some(quote_spanned! {site=>
        #[inline]
        fn length_class(&self, len: usize) -> u32 {
            #parameters
            let class = 0;
            #(let class = 2 * class + u32::from(#comparisons);)*
            class
        }
    })
}

/// Whether two strategies have the same arguments, as far as that can be told: references by
/// address, numbers by their bits, as zeros of different signs are equal and yet not the same, strategies to
/// delegate to by asking them, and all else by equality.
pub(super) fn same(signature: &Signature, plan: Option<&Plan>) -> TokenStream {
    let (site, vertex) = (Span::mixed_site(), &signature.vertex);
    let some = quote_spanned!(site=> ::core::option::Option::Some);
    let mut strategies = Vec::new();
    if let Some(plan) = plan {
        plan.delegates(&mut |strategy| strategies.extend(referenced(strategy)));
    }
    let equal = signature.fields.iter().map(|Field { name, ty, .. }| {
        if is_reference(ty) {
            quote_spanned!(site=> ::core::ptr::eq(self.#name, other.#name))
        } else if is_number(ty) {
            quote_spanned!(site=> self.#name.to_bits() == other.#name.to_bits())
        } else if strategies.contains(&name) {
            quote_spanned! {site=>
                ::aether_core::strategy::Strategy::<#vertex>::same(&self.#name, &other.#name)
            }
        } else {
            // Equal, if the type knows equality.
            quote_spanned!(site=> (&Alike(&self.#name, &other.#name)).alike() == #some(true))
        }
    });
    quote_spanned! {site=>
        #[allow(unused_imports)]
        use ::aether_core::forms::emitted::{Alike, ByEquality as _, Otherwise as _};
        true #(&& #equal)*
    }
}
