//! Whether a sample has the preimages that a formula says.

use proc_macro2::TokenStream;
use quote::{format_ident, quote};

use super::strict::{recovered, strictly};
use crate::emit::item::Emitter;
use crate::emit::meeting::{adjacent, around};
use crate::emit::own::{excluding, exclusive, folded};
use crate::emit::pieces::Place;

/// Binds `belongs`: finite coordinates, the right surface. For each preimage k, binds `strict_k`,
/// where it plainly exists, and `recovered_k`, its uniforms where only rounding speaks against it.
pub(in crate::emit) fn existence(e: &Emitter) -> TokenStream {
    let (belongs, found) = (e.belongs(), existence_where_it_belongs(e, false));
    quote! {
        let belongs: R::Mask = #belongs;
        #found
    }
}

/// The same where `belongs` is known; `near` says that coordinates may be off by `errors`.
pub(super) fn existence_where_it_belongs(e: &Emitter, near: bool) -> TokenStream {
    let places = e.places();
    // A point that has one of two preimages that exclude each other does not have the other.
    let wanted = |place: Place| {
        let earlier = excluding(e, place, &places[..place.number]);
        let found: Vec<_> = earlier.map(|other| format_ident!("strict_{}", other.number)).collect();
        (!found.is_empty()).then(|| quote!((<R::Mask as Mask>::FALSE #(.or(#found))*).not()))
    };
    existence_where(e, &wanted, Asked { near, own: false })
}

/// For whom preimages are looked for.
#[derive(Clone, Copy)]
pub(in crate::emit) struct Asked {
    /// Whether coordinates may be off by `errors`.
    pub(in crate::emit) near: bool,
    /// Whether the point is a sample, whose own preimage is known to be in another piece.
    pub(in crate::emit) own: bool,
}

/// The same for the preimages of each piece only where a mask holds, if there is one; `belongs` is known.
pub(in crate::emit) fn existence_where(
    e: &Emitter,
    wanted: &dyn Fn(Place) -> Option<TokenStream>,
    asked: Asked,
) -> TokenStream {
    let places = e.places();
    let strict = places.iter().map(|&place| strictly(e, place, wanted(place)));
    let once = places.iter().map(|&place| once(e, place, &places));
    let recovered = places.iter().map(|&place| recovered(e, place, &places, asked));
    quote! {
        #(#strict)*
        #(#once)*
        #(#recovered)*
    }
}

/// On a border between two pieces rounding can put a point into both, and in the middle of a piece
/// two of its solutions can meet: the preimage counts once. Pieces that are folded there both have it.
fn once(e: &Emitter, place: Place, places: &[Place]) -> TokenStream {
    let guarded = |p: &Place| !p.problem.guards.is_empty();
    let [strict, inverse] = ["strict", "inverse"].map(|n| format_ident!("{n}_{}", place.number));
    let leave = format_ident!("leave_{}", place.piece);
    let tested = |other: &&Place| guarded(other) || guarded(&place) || beside(e, other, &place);
    let pairs = places[..place.number].iter().filter(tested);
    let pairs = pairs.filter(|other| !folded(other, &place));
    let pairs = pairs.map(|other| {
        let [strict_other, inverse_other] =
            ["strict", "inverse"].map(|n| format_ident!("{n}_{}", other.number));
        let leave_other = format_ident!("leave_{}", other.piece);
        let coincide =
            if encircled(e, other, &place) { quote!(coincide_around) } else { quote!(coincide) };
        quote! {
            let both = #strict.and(#strict_other);
            let #strict = if both.any() {
                let same = ::aether_core::support::#coincide(
                    &#leave::<R>(&p, &#inverse::<R>(&p, &x)),
                    &#leave_other::<R>(&p, &#inverse_other::<R>(&p, &x)),
                );
                #strict.and(both.and(same).not())
            } else {
                #strict
            };
        }
    });
    quote!(#(#pairs)*)
}

/// Whether rounding alone can give a point two preimages on a border between two pieces, which no other test excludes.
pub(in crate::emit) fn beside(e: &Emitter, one: &Place, other: &Place) -> bool {
    // What costs most is asked last.
    let open = !folded(one, other) && !exclusive(e, one, other);
    open && (around(one, other) || adjacent(one, other))
}

/// Whether the first and the last of the pieces have a border in common which no other test excludes.
pub(in crate::emit) fn encircled(e: &Emitter, one: &Place, other: &Place) -> bool {
    around(one, other) && !exclusive(e, one, other)
}

/// Whether the unknowns that are `checked` lie so near to their range that error bounds have to decide.
pub(in crate::emit) fn about(place: Place) -> TokenStream {
    let about = quote!(::aether_core::support::about_unit::<R, _>);
    if !place.has_longer_forms() {
        return quote!(#about(&checked));
    }
    // What is tested is short; where a longer form is more accurate, it says whether a point is near.
    let accurate = format_ident!("accurate_{}", place.number);
    quote! {
        {
            let near = #about(&checked);
            if near.all() { near } else { near.or(#about(&#accurate::<R>(&p, &x))) }
        }
    }
}
