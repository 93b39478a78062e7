//! The density of a sample that other pieces may reach too.

use proc_macro2::{Ident, TokenStream};
use quote::{format_ident, quote};

use super::exclusion::excludes;
use super::has_density;
use crate::emit::item::Emitter;
use crate::emit::sampler::{existence, value_at};

/// Of the preimages in the piece that `u` takes, the nearest is `u` itself: its density is that of
/// the uniforms, not of the rounded point.
pub(super) fn among_several(e: &Emitter) -> TokenStream {
    let (n, _, _) = e.sizes();
    let coordinates = e.coordinates();
    let existence = existence(e);
    let jacobians = jacobians(e);
    // Where no other preimage than that of the uniforms is in sight there is nothing to tell apart.
    let places = e.places();
    let inside: Vec<_> =
        places.iter().map(|place| format_ident!("inside_{}", place.number)).collect();
    let found = places.iter().zip(&inside).map(|(place, inside)| {
        let [strict, recovered] =
            ["strict", "recovered"].map(|name| format_ident!("{name}_{}", place.number));
        // Rounding may put a sample of one piece into another that excludes it, but it is no second one.
        let other = |j: &usize| *j != place.piece && excludes(e, &places, *j, place);
        let excluding = (0..e.parsed.pieces.len()).filter(other);
        let excluded = excluding.map(|j| {
            let taken = format_ident!("taken_{j}");
            quote! {
                let #inside = if #inside.any() {
                    #inside.and(#taken::<R>(&p, &u).not())
                } else {
                    #inside
                };
            }
        });
        quote! {
            let #inside = #strict.or(::aether_core::support::lanes_of::<R, #n>(&#recovered));
            #(#excluded)*
        }
    });
    let pairs = (0..places.len()).flat_map(|k| (0..k).map(move |j| (j, k)));
    let pairs = pairs.map(|(j, k)| {
        let (a, b) = (&inside[j], &inside[k]);
        quote!(.or(#a.and(#b)))
    });
    let others = if are_alike(e) { others_alike(e, &inside) } else { others_apart(e) };
    let elsewhere = places.iter().zip(&inside).filter(|_| !e.is_whole()).map(|(place, inside)| {
        let taken = format_ident!("taken_{}", place.piece);
        quote!(.or(#inside.and(#taken::<R>(&p, &u).not())))
    });
    quote! {
        let mut sum = R::ZERO;
        let mut inner = <R::Mask as Mask>::FALSE;
        #jacobians
        // At an end of a piece the map may only have a limit; the density at the point knows it.
        let outer = exists.and(inner.not());
        let limit = if outer.any() {
            ::aether_core::support::limit_at::<R, _>(*self, point)
        } else {
            R::ZERO
        };
        if exists.and(inner).any() {
            let point = &point;
            let x = #coordinates;
            #existence
            #(#found)*
            let several = <R::Mask as Mask>::FALSE #(#pairs)* #(#elsewhere)*;
            if several.any() { #others }
        }
        ::aether_core::Density::new(R::select(exists, R::select(inner, sum, limit), R::ZERO))
    }
}

/// Whether all preimages of a map of one piece have the same density, so that it does not matter which one `u` is.
fn are_alike(e: &Emitter) -> bool {
    let places = e.places();
    let first = places.first().map(|place| place.preimage.density);
    e.is_whole() && places.iter().all(|place| Some(place.preimage.density) == first)
}

/// Adds to `sum` the density by way of all preimages but one, where all have the same.
fn others_alike(e: &Emitter, inside: &[Ident]) -> TokenStream {
    let Some((&place, (first, rest))) = e.places().first().zip(inside.split_first()) else {
        return quote!();
    };
    let value = value_at(e, place, &quote!(several));
    quote! {
        let d = #value;
        let d = R::select(d.gt(R::ZERO), d, R::ZERO);
        let found = #first;
        #(
            sum += R::select(found.and(#rest), d, R::ZERO);
            let found = found.or(#rest);
        )*
    }
}

/// Adds to `sum` the densities by way of all preimages but the nearest to `u`, which is `u` itself.
fn others_apart(e: &Emitter) -> TokenStream {
    let (n, _, _) = e.sizes();
    let distances = e.places().into_iter().map(|place| {
        let [distance, inside, strict, recovered, inverse] =
            ["distance", "inside", "strict", "recovered", "inverse"]
                .map(|name| format_ident!("{name}_{}", place.number));
        let [leave, taken] = ["leave", "taken"].map(|name| format_ident!("{name}_{}", place.piece));
        // On a border `u` itself may have been found in the other piece.
        let mine = (!e.is_whole()).then(|| {
            let bounds = quote!(::aether_core::support::bounds_of::<R, #n>(&#recovered));
            quote!(.and(#taken::<R>(&p, &u).or(::aether_core::support::same(&u, &(v, #bounds)))))
        });
        quote! {
            let #distance = if #inside.any() {
                let v = ::aether_core::support::merged::<R, #n>(#recovered, #strict, || #leave::<R>(&p, &#inverse::<R>(&p, &x)));
                R::select(#inside #mine, ::aether_core::support::distance(&u, &v), R::INFINITY)
            } else {
                R::INFINITY
            };
            nearest = nearest.min(#distance);
        }
    });
    let others = e.places().into_iter().map(|place| {
        let [distance, inside] =
            ["distance", "inside"].map(|name| format_ident!("{name}_{}", place.number));
        let value = value_at(e, place, &quote!(other));
        quote! {
            let itself = #distance.le(nearest).and(#distance.lt(R::INFINITY)).and(counted.not());
            counted = counted.or(itself);
            let other = #inside.and(itself.not());
            if other.any() {
                let d = #value;
                sum += R::select(other.and(d.gt(R::ZERO)), d, R::ZERO);
            }
        }
    });
    quote! {
        let mut nearest = R::INFINITY;
        #(#distances)*
        let mut counted = <R::Mask as Mask>::FALSE;
        #(#others)*
    }
}

/// Adds to `sum` the density from the Jacobian of the piece that `u` takes; `inner` says whether it
/// has one there.
fn jacobians(e: &Emitter) -> TokenStream {
    let added = |j: usize, taken: &TokenStream| {
        let here = has_density(e, j, &quote!(t));
        quote! {
            let here = #taken.and(#here);
            sum = R::select(here, d, sum);
            inner = inner.or(here);
        }
    };
    if e.is_whole() {
        let added = added(0, &quote!(<R::Mask as Mask>::TRUE));
        return quote!(let t = u; #added);
    }
    e.by_piece(|j| {
        let [enter, own] = ["enter", "own"].map(|name| format_ident!("{name}_{j}"));
        let added = added(j, &quote!(taken));
        quote! {
            let t = #enter::<R>(&p, &u);
            let d = #own::<R>(&p, &t);
            #added
        }
    })
}
