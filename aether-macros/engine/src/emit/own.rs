//! The density of a sample from its uniforms.

mod at_once;
mod exclusion;
mod one_piece;
mod several;
mod told;

use proc_macro2::TokenStream;
use quote::{format_ident, quote};

use super::item::{Emitter, point_type};
use super::jumps::jumps;
pub(super) use exclusion::{excluding, exclusive, folded};
use one_piece::{
    density_beside, drawn_seldom, is_tame, one_a_piece, overlapping_with_density, single,
};
use several::among_several;
pub(super) use told::is_looked_at;
use told::{Told, is_told_everywhere};

/// The density at the uniforms, and the densities by way of the other preimages.
pub(super) fn own_density(e: &Emitter) -> TokenStream {
    if let Some(support) = e.support {
        let value = support.value();
        return quote!(::aether_core::Density::new(#value));
    }
    if e.is_single() {
        let density = quote!(let d = own_0::<R>(&p, &u););
        let checked = single(e);
        return quote!(#density #checked);
    }
    let told = told_apart(e);
    quote! {
        let (point, exists) = ::aether_core::Sampler::forward(self, u);
        self.density_of(u, #told point, exists)
    }
}

/// The density at the uniforms of a map of one piece, for [`density_of`], where the point is known already.
fn told_apart(e: &Emitter) -> Option<TokenStream> {
    e.is_whole().then(|| quote!(own_0::<R>(&p, &u),))
}

/// A method for the density of the point of the uniforms, where other uniforms may have that point too. Where the map is
/// one piece, it is given the density at the uniforms.
pub(super) fn density_of(e: &Emitter) -> Option<TokenStream> {
    if e.support.is_some() || e.is_single() {
        return None;
    }
    let (ty, args, point) = (e.density_type(), e.generics(), point_type(&e.signature().space));
    let (n, _, _) = e.sizes();
    let (parameters, density) = (e.parameters(), at_the_point(e));
    let beside = e.draws_pieces().then(|| density_beside(e));
    let seldom = e.draws_pieces().then(|| drawn_seldom(e));
    let told = e.is_whole().then(|| quote!(d: R,));
    let (outside, inside) = e.bounds();
    Some(quote! {
        impl #outside #ty #args {
            #[inline(always)]
            fn density_of #inside(&self, u: [R; #n], #told point: #point, exists: R::Mask) -> ::aether_core::PdfOf<Self, R> {
                #parameters
                #density
            }
            #beside
            #seldom
        }
    })
}

/// The density of the `point` of the uniforms, where other uniforms may have it too.
fn at_the_point(e: &Emitter) -> TokenStream {
    let several = e.derived.iter().any(|derived| derived.preimages.len() > 1);
    if several { among_several(e) } else { one_a_piece(e) }
}

/// The point and its density in one, where there is anything to share.
pub(super) fn forward_with_density(e: &Emitter) -> Option<TokenStream> {
    if e.support.is_some() {
        return None;
    }
    let (n, m, _) = e.sizes();
    if !e.is_single() {
        if is_alone(e) {
            return Some(pieces_with_density(e));
        }
        if e.draws_pieces() {
            return Some(overlapping_with_density(e));
        }
        let parameters = e.parameters();
        let (drawn, told) = if e.is_drawn_at_once() {
            let made = e.point(&quote!(c));
            let drawn = quote! {
                let (c, d) = both_0::<R>(&p, &u);
                let (point, exists) = (#made, exists_0::<R>(&p, &u));
            };
            (drawn, Some(quote!(d,)))
        } else {
            (quote!(let (point, exists) = ::aether_core::Sampler::forward(self, u);), told_apart(e))
        };
        return Some(quote! {
            #[inline(always)]
            fn forward_with_pdf(&self, u: [R; #n]) -> (Self::Point, R::Mask, ::aether_core::PdfOf<Self, R>) {
                #parameters
                #drawn
                (point, exists, self.density_of(u, #told point, exists))
            }
        });
    }
    let made = e.point(&quote!(c));
    let (parameters, told) = (e.parameters(), Told::of(e));
    let value = told.value();
    let sample = quote!((#made, exists_0::<R>(&p, &u), ::aether_core::Density::new(#value)));
    let coordinates = (!e.forward_is_tame(0)).then(|| quote!(&c));
    let plain = match (told, &coordinates) {
        (Told::AtUniforms, coordinates) => {
            let length = if coordinates.is_some() { m } else { 0 };
            let coordinates = coordinates.clone().unwrap_or_else(|| quote!(&[]));
            let inside = inside(e, 0, &quote!(u));
            Some(quote!(::aether_core::support::plain::<R, #length>(#coordinates, d) #inside))
        }
        (_, Some(_)) => Some(quote!(::aether_core::support::finite::<R, #m>(&c))),
        (_, None) => None,
    };
    let inner = match told {
        Told::AtUniforms => has_density(e, 0, &quote!(u)),
        _ => quote!(<R::Mask as Mask>::TRUE),
    };
    let sample = match plain {
        None => sample,
        Some(plain) => quote! {
            let plain: R::Mask = #plain;
            if plain.all() {
                #sample
            } else {
                let (point, exists, d) = ::aether_core::support::rare_sample::<R, _>(*self, u, d, #inner);
                (point, exists, ::aether_core::Density::new(#value))
            }
        },
    };
    Some(quote! {
        #[inline(always)]
        fn forward_with_pdf(&self, u: [R; #n]) -> (Self::Point, R::Mask, ::aether_core::PdfOf<Self, R>) {
            #parameters
            let (c, d) = both_0::<R>(&p, &u);
            #sample
        }
    })
}

/// Whether each point has one preimage, for the images of pieces are apart, or meet.
fn is_alone(e: &Emitter) -> bool {
    let one_each = e.derived.iter().all(|derived| derived.preimages.len() == 1);
    let places = e.places();
    let mut pairs = (0..places.len()).flat_map(|k| (0..k).map(move |j| (j, k)));
    one_each && pairs.all(|(j, k)| exclusive(e, &places[j], &places[k]))
}

/// The point and its density from the piece that the uniforms take, where there is no other.
fn pieces_with_density(e: &Emitter) -> TokenStream {
    let (n, m, _) = e.sizes();
    let (made, parameters) = (e.point(&quote!(c)), e.parameters());
    let pieces = e.by_piece(|j| {
        let [enter, both, exists] =
            ["enter", "both", "exists"].map(|name| format_ident!("{name}_{j}"));
        let inside = inside(e, j, &quote!(t));
        quote! {
            let t = #enter::<R>(&p, &u);
            let (y, own) = #both::<R>(&p, &t);
            c = ::core::array::from_fn(|i| R::select(taken, y[i], c[i]));
            exists = exists.or(taken.and(#exists::<R>(&p, &t)));
            d = R::select(taken, own, d);
            inside = inside.or(taken #inside);
        }
    });
    let tame = (0..e.parsed.pieces.len()).all(|j| e.forward_is_tame(j));
    let coordinates =
        if tame { quote!(plain::<R, 0>(&[], d)) } else { quote!(plain::<R, #m>(&c, d)) };
    let told = is_told_everywhere(e);
    let required = e.parsed.pieces.iter().any(|piece| !piece.problem.requirements.is_empty());
    // Where there is no sample, there is nothing to look after.
    let (exists, missing) = if e.parsed.total && !required {
        (quote!(<R::Mask as Mask>::TRUE), None)
    } else {
        (quote!(exists), Some(quote!(.or(exists.not()))))
    };
    let sample =
        quote!((#made, exists, ::aether_core::Density::new(R::select(exists, d, R::ZERO))));
    let sample = if told {
        sample
    } else {
        quote! {
            let plain: R::Mask = ::aether_core::support::#coordinates.and(inside);
            if plain #missing .all() {
                #sample
            } else {
                let inner = ::aether_core::support::positive::<R>(d).and(inside);
                let (point, exists, d) = ::aether_core::support::rare_sample_of_pieces::<R, _>(*self, u, d, inner);
                (point, exists, ::aether_core::Density::new(d))
            }
        }
    };
    quote! {
        #[inline(always)]
        fn forward_with_pdf(&self, u: [R; #n]) -> (Self::Point, R::Mask, ::aether_core::PdfOf<Self, R>) {
            #parameters
            let mut c = [R::ZERO; #m];
            let mut d = R::ZERO;
            let mut exists = <R::Mask as Mask>::FALSE;
            let mut inside = <R::Mask as Mask>::FALSE;
            #pieces
            let exists = #exists;
            #sample
        }
    }
}

/// Where the density `d` of a piece has a value at the unknowns `t`. Where one that it depends on is zero, it may only have
/// a limit; zero or infinite, it may have left the range of numbers on the way, which the density at the point need not.
fn has_density(e: &Emitter, j: usize, t: &TokenStream) -> TokenStream {
    let inside = inside(e, j, t);
    quote!(::aether_core::support::positive::<R>(d) #inside)
}

/// That unknowns are not zero where the density would not show it.
fn inside(e: &Emitter, j: usize, t: &TokenStream) -> TokenStream {
    let problem = &e.parsed.pieces[j].problem;
    let (tame, density) = (is_tame(e, j), e.derived[j].own_density);
    let matters = |i: &usize| !tame && jumps(&problem.graph, density, problem.unknowns[*i]);
    let matter = (0..problem.unknowns.len()).filter(matters);
    matter.map(|i| quote!(.and(#t[#i].gt(R::ZERO)))).collect()
}
