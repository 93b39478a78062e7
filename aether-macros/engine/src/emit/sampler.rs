//! `impl Sampler`.

use proc_macro2::{Literal, TokenStream};
use quote::{format_ident, quote};

use super::item::{Emitter, point, point_type};
use crate::derive::Target;

/// The implementation of the trait for an item whose inverse was derived.
pub fn implementation(e: &Emitter) -> TokenStream {
    let (ty, args) = (e.type_name(), e.generics());
    let n = e.problem().unknowns.len();
    let m = e.problem().outputs.len();
    let parameters = e.parameters();
    let point_ty = point_type(&e.signature().space);
    let made = point(&e.signature().space, &quote!(c), e.parsed.identity.as_ref());
    let density = density(e);
    let own = own_density(e);
    let visits = visits(e);
    quote! {
        #[automatically_derived]
        impl<R: Real> ::aether_core::Sampler<R> for #ty #args {
            type Uniforms = [R; #n];
            type Point = #point_ty;

            #[inline(always)]
            fn forward(&self, u: [R; #n]) -> (Self::Point, R::Mask) {
                #parameters
                let c = ::aether_core::support::closed::<R, #n, #m>(&u, |u| forward::<R>(&p, u));
                (#made, exists::<R>(&p, &u))
            }

            #[inline(always)]
            fn pdf(&self, point: &Self::Point) -> ::aether_core::PdfOf<Self, R> {
                #parameters
                let x = point.coordinates();
                #density
            }

            #[inline(always)]
            fn pdf_of_uniforms(&self, u: [R; #n]) -> ::aether_core::PdfOf<Self, R> {
                #parameters
                #own
            }

            fn preimages(&self, point: &Self::Point, mut visit: impl FnMut([R; #n], R::Mask)) {
                #parameters
                let x = point.coordinates();
                #visits
            }
        }
    }
}

/// What every preimage needs of the point: finite coordinates, the right surface.
fn belongs(e: &Emitter) -> TokenStream {
    let identity = e
        .parsed
        .identity
        .as_ref()
        .map(|id| quote!(.and(::aether_core::support::mask(point.surface == #id))));
    quote!(let belongs: R::Mask = ::aether_core::support::finite::<R>(&x) #identity;)
}

/// Binds `inside`: whether preimage k exists, with rounding at the borders and off the manifold.
fn inside(e: &Emitter, k: usize) -> TokenStream {
    let (inverse, support) = (format_ident!("inverse_{k}"), format_ident!("support_{k}"));
    let n = e.problem().unknowns.len();
    let m = e.problem().outputs.len();
    let track = track(e);
    let tracked = quote! {
        {
            let (tp, tx) = (::aether_core::support::track(&p), #track(&x));
            let tu = #inverse::<R::Tracked>(&tp, &tx);
            (tp, tu)
        }
    };
    let membership = e.derived.check_forward.then(|| {
        quote! {
            let inside = if inside.any()
                && !::aether_core::support::near::<R, #m>(&forward::<R>(&p, &#inverse::<R>(&p, &x)), &x)
            {
                let (tp, tu) = #tracked;
                inside.and(::aether_core::support::mask(
                    ::aether_core::support::leads_back::<R, #n, #m>(tu, &x, |u| forward::<R::Tracked>(&tp, u))))
            } else { inside };
        }
    });
    quote! {
        let (checked, ok) = #support::<R>(&p, &x);
        let ok = ok.and(belongs);
        let strict = ok.and(::aether_core::support::in_unit::<R, _>(&checked));
        let inside = if ok.any() && !strict.any() {
            let (tp, tu) = #tracked;
            ::aether_core::support::mask(
                ::aether_core::support::recover::<R, #n, #m>(tu, &x, |u| forward::<R::Tracked>(&tp, u)).is_some())
        } else { strict };
        #membership
    }
}

/// How the coordinates of the query point were rounded.
fn track(e: &Emitter) -> TokenStream {
    match e.problem().target {
        Target::Direction => quote!(::aether_core::support::track_unit),
        _ => quote!(::aether_core::support::track),
    }
}

fn density(e: &Emitter) -> TokenStream {
    let belongs = belongs(e);
    let terms = (0..e.derived.preimages.len()).map(|k| {
        let inside = inside(e, k);
        let density = format_ident!("density_{k}");
        let counted = counted(e, k);
        quote! {
            {
                #inside
                #counted
                if inside.any() {
                    let d = #density::<R>(&p, &x);
                    sum += R::select(inside.and(d.gt(R::ZERO)), d, R::ZERO);
                }
            }
        }
    });
    let memory = memory(e);
    quote! {
        #belongs
        #memory
        let mut sum = R::ZERO;
        #(#terms)*
        ::aether_core::Density::new(sum)
    }
}

/// Where several preimages can meet, the ones already counted.
fn memory(e: &Emitter) -> TokenStream {
    let k = e.derived.preimages.len();
    if k < 2 {
        return quote!();
    }
    let n = e.problem().unknowns.len();
    quote!(let mut counted = [[R::of(f64::NAN); #n]; #k];)
}

/// A preimage that was accepted by tolerance and equals one that counts already counts once.
fn counted(e: &Emitter, k: usize) -> TokenStream {
    if e.derived.preimages.len() < 2 {
        return quote!();
    }
    let inverse = format_ident!("inverse_{k}");
    let k = Literal::usize_unsuffixed(k);
    quote! {
        let recovered = #inverse::<R>(&p, &x);
        let again = !strict.any() && counted.iter().any(|c| ::aether_core::support::coincide(c, &recovered));
        let inside = inside.and(::aether_core::support::mask(!again));
        if inside.any() { counted[#k] = recovered; }
    }
}

/// The density of a sample from its uniforms: the Jacobian there, if there is no other preimage.
fn own_density(e: &Emitter) -> TokenStream {
    let (n, m) = (e.problem().unknowns.len(), e.problem().outputs.len());
    let made = point(
        &e.signature().space,
        &quote!(::aether_core::support::closed::<R, #n, #m>(&u, |u| forward::<R>(&p, u))),
        e.parsed.identity.as_ref(),
    );
    let through_point = quote!(::aether_core::Sampler::pdf(self, &#made));
    if e.derived.preimages.len() > 1 {
        return through_point;
    }
    quote! {
        let d = R::ONE / volume::<R>(&p, &u);
        // At a uniform of zero the map may only have a limit (a pole, an axis), and so may the
        // Jacobian; the density at the point knows it.
        let inner = u.iter().fold(d.ge(R::ZERO), |m, u| m.and(u.gt(R::ZERO)));
        if inner.any() { ::aether_core::Density::new(d) } else { #through_point }
    }
}

fn visits(e: &Emitter) -> TokenStream {
    let belongs = belongs(e);
    let memory = memory(e);
    let n = e.problem().unknowns.len();
    let m = e.problem().outputs.len();
    let track = track(e);
    let each = (0..e.derived.preimages.len()).map(|k| {
        let inside = inside(e, k);
        let counted = counted(e, k);
        let inverse = format_ident!("inverse_{k}");
        quote! {
            {
                #inside
                #counted
                if inside.any() {
                    let (tp, tx) = (::aether_core::support::track(&p), #track(&x));
                    let u = #inverse::<R>(&p, &x);
                    let u = if ::aether_core::support::in_unit::<R, _>(&u).any() { u } else {
                        ::aether_core::support::recover::<R, #n, #m>(
                            #inverse::<R::Tracked>(&tp, &tx), &x, |u| forward::<R::Tracked>(&tp, u)).unwrap_or(u)
                    };
                    visit(u, inside);
                }
            }
        }
    });
    quote!(#belongs #memory #(#each)*)
}
