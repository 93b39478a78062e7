//! `impl Sampler`.

mod densities;
mod exists;
mod strict;

use proc_macro2::TokenStream;
use quote::{format_ident, quote};

use super::item::{Emitter, point_type};
use super::own::{density_of, forward_with_density, own_density};
use super::quick;
use crate::parse::Space;
use densities::{density, density_near, log_density};
pub(super) use densities::{general_density, value_at};
pub(super) use exists::{Asked, about, beside, encircled, existence, existence_where};
use strict::exceptions;

/// The implementation of the trait for an item whose inverse was derived.
pub fn implementation(e: &Emitter) -> TokenStream {
    let (ty, args) = (e.density_type(), e.generics());
    let (n, _, _) = e.sizes();
    let parameters = e.parameters();
    let point_ty = point_type(&e.signature().space);
    let forward = forward(e);
    let [density, where_finite, of_finite] = density(e);
    let anywhere = quick::anywhere(e);
    let own = own_density(e);
    let both = forward_with_density(e);
    let density_of = density_of(e);
    let visits = visits(e);
    let coordinates = e.coordinates();
    let exceptions = exceptions(e);
    let near = density_near(e);
    let logarithm = e.has_logarithms().then(|| log_density(e));
    quote! {
        #exceptions
        #anywhere
        #density_of
        #where_finite

        #[automatically_derived]
        impl<R: Real> ::aether_core::Sampler<R> for #ty #args {
            type Uniforms = [R; #n];
            type Point = #point_ty;

            #[inline(always)]
            fn forward(&self, u: [R; #n]) -> (Self::Point, R::Mask) {
                #parameters
                #forward
            }

            #[inline(always)]
            fn pdf(&self, point: &Self::Point) -> ::aether_core::PdfOf<Self, R> {
                #density
            }

            #of_finite

            #near

            #[inline(always)]
            fn pdf_of_uniforms(&self, u: [R; #n]) -> ::aether_core::PdfOf<Self, R> {
                #parameters
                #own
            }

            #both

            fn preimages(&self, point: &Self::Point, mut visit: impl FnMut([R; #n], R::Mask)) {
                #parameters
                let x = #coordinates;
                #visits
            }

            #logarithm
        }
    }
}

/// The point of `u` and whether there is one, from the piece that `u` falls into.
fn forward(e: &Emitter) -> TokenStream {
    let (_, m, _) = e.sizes();
    let made = e.point(&quote!(c));
    if e.is_whole() {
        let image = image(e);
        return quote! {
            let (c, known) = #image;
            (#made, exists_0::<R>(&p, &u).and(known))
        };
    }
    let pieces = e.by_piece(|j| {
        let [enter, exists] = ["enter", "exists"].map(|name| format_ident!("{name}_{j}"));
        let y = image_in(e, j);
        quote! {
            let t = #enter::<R>(&p, &u);
            let (y, known) = #y;
            c = ::core::array::from_fn(|i| R::select(taken, y[i], c[i]));
            exists = exists.or(taken.and(known).and(#exists::<R>(&p, &t)));
        }
    });
    quote! {
        let mut c = [R::ZERO; #m];
        let mut exists = <R::Mask as Mask>::FALSE;
        #pieces
        (#made, exists)
    }
}

/// The coordinates of the image of `t` under a piece, which the uniforms take where `taken` says so, and
/// whether they have values.
pub(super) fn image_in(e: &Emitter, j: usize) -> TokenStream {
    let forward = format_ident!("forward_{j}");
    closed_in(e, j, &quote!(#forward::<R>(&p, &t)))
}

/// The same where the coordinates are `value`.
pub(super) fn closed_in(e: &Emitter, j: usize, value: &TokenStream) -> TokenStream {
    let (n, m, s) = e.sizes();
    let forward = format_ident!("forward_{j}");
    if e.forward_is_tame(j) {
        quote!((#value, <R::Mask as Mask>::TRUE))
    } else {
        let bounded = is_bounded(e);
        quote!(::aether_core::support::closed::<R, #s, #n, #m>(taken, #bounded, (&p, &t), #value, #forward::<R>))
    }
}

/// Whether no point of the space has infinite coordinates, a direction or several points with one.
pub(super) fn is_bounded(e: &Emitter) -> bool {
    has_a_direction(&e.signature().space)
}

/// Whether a direction is a point of the space, or part of one.
fn has_a_direction(space: &Space) -> bool {
    match space {
        Space::Direction => true,
        Space::Joint(parts) => parts.iter().any(has_a_direction),
        _ => false,
    }
}

/// The coordinates of the image of `u` under the only piece, and whether they have values.
pub(super) fn image(e: &Emitter) -> TokenStream {
    if e.forward_is_tame(0) {
        return quote!((forward_0::<R>(&p, &u), <R::Mask as Mask>::TRUE));
    }
    let (n, m, s) = e.sizes();
    let (all, value) = (quote!(<R::Mask as Mask>::TRUE), quote!(forward_0::<R>(&p, &u)));
    let bounded = is_bounded(e);
    quote!(::aether_core::support::closed::<R, #s, #n, #m>(#all, #bounded, (&p, &u), #value, forward_0::<R>))
}

fn visits(e: &Emitter) -> TokenStream {
    let existence = existence(e);
    let (n, _, _) = e.sizes();
    let each = e.places().into_iter().map(|place| {
        let [inverse, strict, recovered] =
            ["inverse", "strict", "recovered"].map(|name| format_ident!("{name}_{}", place.number));
        let leave = format_ident!("leave_{}", place.piece);
        quote! {
            let inside = #strict.or(::aether_core::support::lanes_of::<R, #n>(&#recovered));
            if inside.any() {
                let u = ::aether_core::support::merged::<R, #n>(#recovered, #strict, || {
                    // The most accurate form may round to an end where a shorter one does not.
                    let t = #inverse::<R>(&p, &x).map(::aether_core::support::unit);
                    #leave::<R>(&p, &t)
                });
                visit(u, inside);
            }
        }
    });
    quote!(#existence #(#each)*)
}
