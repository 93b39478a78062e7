//! A sample and its density where the way that it took tells the piece.

use proc_macro2::{Ident, TokenStream};
use quote::{format_ident, quote};

use super::at_once::{draws_plainly, plain_sample};
use super::exclusion::{exclusive, folded};
use super::told::Told;
use super::{has_density, is_alone};
use crate::emit::item::{Emitter, point_type};
use crate::emit::pieces::Place;
use crate::emit::sampler::{Asked, closed_in, encircled, existence_where, value_at};
use crate::emit::tame::Tame;
use crate::expr::{OUTS, UNKNOWNS};

/// The density `d` at the uniforms, or its limit.
pub(super) fn single(e: &Emitter) -> TokenStream {
    let told = Told::of(e);
    if !matches!(told, Told::AtUniforms) {
        let value = told.value();
        return quote!(::aether_core::Density::new(#value));
    }
    let inner = has_density(e, 0, &quote!(u));
    quote! {
        let inner: R::Mask = #inner;
        ::aether_core::Density::new(if inner.all() {
            d
        } else {
            ::aether_core::support::own_limit::<R, _>(*self, u, d, inner)
        })
    }
}

/// Whether the density of a piece has a value at all uniforms.
pub(super) fn is_tame(e: &Emitter, piece: usize) -> bool {
    let graph = &e.parsed.pieces[piece].problem.graph;
    Tame::new(graph, true, false).all(&[e.derived[piece].own_density])
}

/// Whether the density of a piece depends on parameters.
pub(super) fn has_parameters(e: &Emitter, piece: usize) -> bool {
    let graph = &e.parsed.pieces[piece].problem.graph;
    graph.has(e.derived[piece].own_density, !(UNKNOWNS | OUTS))
}

/// Where each piece has one preimage: that of the piece that `u` takes is `u` itself, with the density of the
/// uniforms, and only pieces whose images overlap with its own are inverted.
pub(super) fn one_a_piece(e: &Emitter) -> TokenStream {
    let (declared, masks) = (declared(e), masks(e));
    let own = e.by_piece(|j| {
        let [enter, own] = ["enter", "own"].map(|name| format_ident!("{name}_{j}"));
        let here = here(e, j);
        quote! {
            let t = #enter::<R>(&p, &u);
            let d = #own::<R>(&p, &t);
            #here
        }
    });
    quote! {
        #declared
        #own
        self.density_beside(u, point, exists, (sum, inner, at_border), [#(#masks),*])
    }
}

/// The point and its density from the piece that the uniforms take, where others may have it too.
pub(super) fn overlapping_with_density(e: &Emitter) -> TokenStream {
    let (n, _, _) = e.sizes();
    let parameters = e.parameters();
    let drawn = if draws_plainly(e) {
        let plain = plain_sample(e);
        quote! {
            #plain
            self.drawn_by_piece(u)
        }
    } else {
        drawn_by_piece(e)
    };
    quote! {
        #[inline(always)]
        fn forward_with_pdf(&self, u: [R; #n]) -> (Self::Point, R::Mask, ::aether_core::PdfOf<Self, R>) {
            #parameters
            #drawn
        }
    }
}

/// A method for the samples that are not plain, if there is a quick way for those that are.
pub(super) fn drawn_seldom(e: &Emitter) -> Option<TokenStream> {
    if is_alone(e) || !draws_plainly(e) {
        return None;
    }
    let (n, _, _) = e.sizes();
    let (parameters, drawn) = (e.parameters(), drawn_by_piece(e));
    let (point, (_, inside)) = (point_type(&e.signature().space), e.bounds());
    Some(quote! {
        #[inline(never)]
        fn drawn_by_piece #inside(self, u: [R; #n]) -> (#point, R::Mask, ::aether_core::PdfOf<Self, R>) {
            #parameters
            #drawn
        }
    })
}

/// The point and its density where lanes may take several pieces, and anything may be in doubt.
fn drawn_by_piece(e: &Emitter) -> TokenStream {
    let (_, m, _) = e.sizes();
    let (made, declared, masks) = (e.point(&quote!(c)), declared(e), masks(e));
    let pieces = e.by_piece(|j| {
        let [enter, both, exists] =
            ["enter", "both", "exists"].map(|name| format_ident!("{name}_{j}"));
        let (here, y) = (here(e, j), closed_in(e, j, &quote!(y)));
        quote! {
            let t = #enter::<R>(&p, &u);
            let (y, d) = #both::<R>(&p, &t);
            let (y, known) = #y;
            c = ::core::array::from_fn(|i| R::select(taken, y[i], c[i]));
            exists = exists.or(taken.and(known).and(#exists::<R>(&p, &t)));
            #here
        }
    });
    quote! {
        let mut c = [R::ZERO; #m];
        let mut exists = <R::Mask as Mask>::FALSE;
        #declared
        #pieces
        let point = #made;
        let density = self.density_beside(u, point, exists, (sum, inner, at_border), [#(#masks),*]);
        (point, exists, density)
    }
}

/// The masks of which uniforms take a piece and have a density there.
fn masks(e: &Emitter) -> Vec<Ident> {
    (0..e.parsed.pieces.len()).map(|j| format_ident!("own_piece_{j}")).collect()
}

/// What is found of the density at the uniforms.
fn declared(e: &Emitter) -> TokenStream {
    let masks = masks(e);
    quote! {
        let mut sum = R::ZERO;
        let mut inner = <R::Mask as Mask>::FALSE;
        let mut at_border = <R::Mask as Mask>::FALSE;
        #(let mut #masks = <R::Mask as Mask>::FALSE;)*
    }
}

/// Notes the density `d` at the unknowns `t` of a piece.
fn here(e: &Emitter, j: usize) -> TokenStream {
    let problem = &e.parsed.pieces[j].problem;
    let ends = problem.segments.iter().enumerate().filter(|(_, s)| s.is_some());
    let ends = ends.map(|(i, _)| quote!(.or(::aether_core::support::at_end(t[#i]))));
    // What else decides about the piece has no known distance.
    let ends = if problem.guards.is_empty() {
        quote!(<R::Mask as Mask>::FALSE #(#ends)*)
    } else {
        quote!(<R::Mask as Mask>::TRUE)
    };
    let here = has_density(e, j, &quote!(t));
    let taken = format_ident!("own_piece_{j}");
    quote! {
        let here = taken.and(#here);
        sum = R::select(here, d, sum);
        inner = inner.or(here);
        at_border = at_border.or(here.and(#ends));
        #taken = here;
    }
}

/// A method that adds to the density at the uniforms those of other pieces that reach the point.
pub(super) fn density_beside(e: &Emitter) -> TokenStream {
    let (n, _, _) = e.sizes();
    let (coordinates, belongs) = (e.coordinates(), e.belongs());
    let (pieces, masks) = (e.parsed.pieces.len(), masks(e));
    let (parameters, point) = (e.parameters(), point_type(&e.signature().space));
    let (_, inside) = e.bounds();
    let places = e.places();
    // Where one piece goes on from the end of another, rounding may put a sample of one into the other, but it is no second one.
    let wanted = |place: Place| {
        let others = places.iter().filter(|other| other.piece != place.piece);
        let overlapping = others.filter(|other| !exclusive(e, other, &place));
        let overlapping: Vec<_> = overlapping.map(|other| &masks[other.piece]).collect();
        Some(quote!(<R::Mask as Mask>::FALSE #(.or(#overlapping))*))
    };
    let others = if is_alone(e) {
        quote!()
    } else {
        let existence = existence_where(e, &wanted, Asked { near: false, own: true });
        let terms = e.places().into_iter().map(|place| {
            let [strict, recovered, inverse] = ["strict", "recovered", "inverse"]
                .map(|name| format_ident!("{name}_{}", place.number));
            let leave = format_ident!("leave_{}", place.piece);
            let value = value_at(e, place, &quote!(other));
            let turned = |j: usize| e.places().iter().any(|p| p.piece == j && folded(p, &place));
            let round = e.places().iter().any(|p| encircled(e, p, &place));
            let same = if round { quote!(same_around) } else { quote!(same) };
            let turned: Vec<_> = (0..pieces).filter(|&j| turned(j)).map(|j| &masks[j]).collect();
            let beside =
                (!turned.is_empty()).then(|| quote!(#(.and(#turned.not()))*));
            quote! {
                let other = #strict.or(::aether_core::support::lanes_of::<R, #n>(&#recovered));
                // On a border `u` itself may have been found in the other piece.
                let itself = other.and(at_border) #beside;
                let other = if itself.any() {
                    let v = ::aether_core::support::merged::<R, #n>(#recovered, #strict, || #leave::<R>(&p, &#inverse::<R>(&p, &x)));
                    let bounds = ::aether_core::support::bounds_of::<R, #n>(&#recovered);
                    other.and(itself.and(::aether_core::support::#same(&u, &(v, bounds))).not())
                } else {
                    other
                };
                if other.any() {
                    let d = #value;
                    sum += R::select(other.and(d.gt(R::ZERO)), d, R::ZERO);
                }
            }
        });
        quote! {
            let point = &point;
            let x = #coordinates;
            let belongs: R::Mask = #belongs;
            #existence
            #(#terms)*
        }
    };
    quote! {
        #[inline(always)]
        fn density_beside #inside(
            &self,
            u: [R; #n],
            point: #point,
            exists: R::Mask,
            (mut sum, inner, at_border): (R, R::Mask, R::Mask),
            [#(#masks),*]: [R::Mask; #pieces],
        ) -> ::aether_core::PdfOf<Self, R> {
        #parameters
        // At an end of a piece the map may only have a limit; the density at the point knows it.
        let outer = exists.and(inner.not());
        let limit = if outer.any() {
            ::aether_core::support::limit_at::<R, _>(*self, point)
        } else {
            R::ZERO
        };
        #others
        ::aether_core::Density::new(R::select(exists, R::select(inner, sum, limit), R::ZERO))
        }
    }
}
