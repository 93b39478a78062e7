//! `impl Map`.

use proc_macro2::TokenStream;
use quote::{format_ident, quote};

use super::item::{Emitter, point, point_type};
use crate::parse::{Source, Space};

/// The implementation of the trait for a map whose inverse was derived.
pub fn implementation(e: &Emitter) -> TokenStream {
    let (ty, args) = (e.type_name(), e.generics());
    let Source::Point { space: source, .. } = &e.signature().source else { return quote!() };
    let (source_ty, target_ty) = (point_type(source), point_type(&e.signature().space));
    let parameters = e.parameters();
    let made = point(&e.signature().space, &quote!(c), e.parsed.identity.as_ref());
    let visits = visits(e, source);
    quote! {
        #[automatically_derived]
        impl<R: Real> ::aether_core::Map<R> for #ty #args {
            type Source = #source_ty;
            type Target = #target_ty;

            #[inline(always)]
            fn forward(&self, point: &Self::Source) -> (Self::Target, R::Mask) {
                #parameters
                let u = point.coordinates();
                let c = forward::<R>(&p, &u);
                (#made, exists::<R>(&p, &u))
            }

            #[inline(always)]
            fn preimages(&self, point: &Self::Target, mut visit: impl FnMut(Self::Source, R::Mask)) {
                #parameters
                let x = point.coordinates();
                #visits
            }

            #[inline(always)]
            fn jacobian(&self, point: &Self::Source) -> R {
                #parameters
                let u = point.coordinates();
                volume::<R>(&p, &u)
            }
        }
    }
}

fn visits(e: &Emitter, source: &Space) -> TokenStream {
    let identity = e
        .parsed
        .identity
        .as_ref()
        .map(|id| quote!(.and(::aether_core::support::mask(point.surface == #id))));
    let n = e.problem().unknowns.len();
    let m = e.problem().outputs.len();
    let each = (0..e.derived.preimages.len()).map(|k| {
        let (inverse, support) = (format_ident!("inverse_{k}"), format_ident!("support_{k}"));
        let made = point(source, &quote!(u), None);
        let membership = e.derived.check_forward.then(|| {
            quote! {
                let ok = if ok.any() {
                    let (tp, tx) = (::aether_core::support::track(&p), ::aether_core::support::track(&x));
                    let tu = #inverse::<R::Tracked>(&tp, &tx);
                    ok.and(::aether_core::support::mask(
                        ::aether_core::support::leads_back::<R, #n, #m>(tu, &x, |u| forward::<R::Tracked>(&tp, u))))
                } else { ok };
            }
        });
        quote! {
            {
                let (_, ok) = #support::<R>(&p, &x);
                let ok = ok.and(belongs);
                #membership
                if ok.any() {
                    let u = #inverse::<R>(&p, &x);
                    visit(#made, ok.and(::aether_core::support::finite::<R>(&u)));
                }
            }
        }
    });
    quote! {
        let belongs: R::Mask = ::aether_core::support::finite::<R>(&x) #identity;
        #(#each)*
    }
}
