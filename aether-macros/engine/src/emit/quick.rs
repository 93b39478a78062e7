//! The density of a point that plainly lies inside the support or plainly outside: a few comparisons, and
//! then the formula. What only rounding may have put on its side is left to the general code.

use std::collections::HashMap;

use proc_macro2::TokenStream;
use quote::{format_ident, quote};

use super::code::Code;
use super::item::Emitter;
use super::own::exclusive;
use super::peeled::{passed_on, unit_test};
use super::pieces::{Place, is_unguarded};
use super::sampler::{about, general_density, value_at};
use crate::expr::{Leaf, leaf_bit};

/// Whether nothing but the ends of unknowns limits the pieces, so that there is a quick way.
fn is_quick(e: &Emitter) -> bool {
    let places = e.places();
    e.support.is_none() && !places.is_empty() && places.iter().all(|p| is_unguarded(*p))
}

/// The density at `point`, if there is a quick way; points that are not plain are left to [`anywhere`].
pub(super) fn density(e: &Emitter) -> Option<TokenStream> {
    if !is_quick(e) {
        return None;
    }
    let (belongs, places) = (e.belongs(), e.places());
    let each = places.iter().map(|&place| preimage(e, place, &places));
    let found = places.iter().map(|place| format_ident!("found_{}", place.number));
    // What is infinite fails the tests of unknowns, if each coordinate takes part in one.
    let told = !e.has_surfaces() && places.iter().all(|place| tells_finite(e, *place));
    let elsewhere = (!told).then(|| {
        quote! {
            if !belongs().all() {
                break 'quick if belongs().any() { pdf_anywhere::<R>(p, x, belongs()) } else { R::ZERO };
            }
        }
    });
    Some(quote! {
        let belongs = || -> R::Mask { #belongs };
        'quick: {
            #elsewhere
            let mut sum = R::ZERO;
            #(let mut #found = false;)*
            #(#each)*
            sum
        }
    })
}

/// Whether a point with a coordinate that is not finite never plainly has a preimage.
fn tells_finite(e: &Emitter, place: Place) -> bool {
    let (_, m, _) = e.sizes();
    let g = &place.problem.graph;
    let mut code = Code::new(g, &|_| TokenStream::new());
    let tests = place.checked().into_iter();
    let tests = tests.map(|i| unit_test(&mut code, place.preimage.tested[i], false).bounded);
    let mut known = HashMap::new();
    let told = tests.flatten().fold(0, |all, id| all | passed_on(g, id, &mut known));
    (0..m).all(|i| told & leaf_bit(Leaf::Out(i as u8)) != 0)
}

/// The function for points that are not plainly inside or outside.
pub(super) fn anywhere(e: &Emitter) -> Option<TokenStream> {
    if !is_quick(e) {
        return None;
    }
    let (_, m, p) = e.sizes();
    let density = general_density(e);
    Some(quote! {
        /// The density at any point.
        #[inline(never)]
        fn pdf_anywhere<R: Real>(p: [R; #p], x: [R; #m], belongs: R::Mask) -> R {
            #density
        }
    })
}

/// Adds the density by way of a preimage, if the point has it; leaves the block if that is not plain.
fn preimage(e: &Emitter, place: Place, places: &[Place]) -> TokenStream {
    let (k, j) = (place.number, place.piece);
    let (_, m, _) = e.sizes();
    let [plainly, found, support, inverse, back] =
        ["plainly", "found", "support", "inverse", "back"].map(|name| format_ident!("{name}_{k}"));
    let forward = format_ident!("forward_{j}");
    let all = quote!(<R::Mask as Mask>::TRUE);
    let value = value_at(e, place, &all);
    let near = about(place);
    let on_manifold = place.derived.check_forward.then(|| {
        let (_, _, s) = e.sizes();
        let lies = format_ident!("lies_{k}");
        let image = match place.preimage.back {
            Some(_) => quote!(#back::<R>(&p, &x)),
            None => quote!(#forward::<R>(&p, &#inverse::<R>(&p, &x))),
        };
        let elsewhere = quote!(break 'quick pdf_anywhere::<R>(p, x, belongs()););
        // What lies far off has no preimage here; next to the manifold it takes other error bounds to tell.
        let otherwise = match place.preimage.back {
            Some(_) => quote! {
                let [on, off] = ::aether_core::support::on_or_off::<R, #m, #s>(&p, &x, #lies::<R::Lane>);
                if off.all() {
                    break 'inside;
                }
                if !on.all() { #elsewhere }
            },
            None => elsewhere,
        };
        quote! {
            let back = #image;
            if !::aether_core::support::near::<R, #m>(&back, &x).all() { #otherwise }
        }
    });
    let wide = format_ident!("wide_{j}");
    let confined = place.problem.segments.iter().any(Option::is_some);
    let wide = confined.then(|| quote!(let ok = ok.and(#wide::<R>(&p));));
    let inside = if confined { quote!(plain.and(ok).all()) } else { quote!(plain.all()) };
    let accepted = quote! {
        #on_manifold
        let d = #value;
        sum += R::select(d.gt(R::ZERO), d, R::ZERO);
        #found = true;
    };
    let leaves = place.derived.check_forward && place.preimage.back.is_some();
    let accepted = if leaves { quote!('inside: { #accepted }) } else { accepted };
    let tested = quote! {
        let (plain, ok) = #plainly::<R>(&p, &x);
        #wide
        if #inside {
            #accepted
        } else if ok.any() {
            let (checked, ..) = #support::<R>(&p, &x);
            if ok.and(#near).any() {
                break 'quick pdf_anywhere::<R>(p, x, belongs());
            }
        }
    };
    // A point that has one of two preimages that exclude each other does not have the other.
    let earlier = places[..place.number].iter().filter(|other| exclusive(e, other, &place));
    let earlier: Vec<_> = earlier.map(|other| format_ident!("found_{}", other.number)).collect();
    if earlier.is_empty() { tested } else { quote!(if !(#(#earlier)||*) { #tested }) }
}
