//! `impl Sampler`.

use proc_macro2::TokenStream;
use quote::{format_ident, quote};

use super::item::{Emitter, point_type};
use super::own::own_density;
use super::pieces::Place;

/// The implementation of the trait for an item whose inverse was derived.
pub fn implementation(e: &Emitter) -> TokenStream {
    let (ty, args) = (e.type_name(), e.generics());
    let (n, _, _) = e.sizes();
    let parameters = e.parameters();
    let point_ty = point_type(&e.signature().space);
    let forward = forward(e);
    let density = density(e);
    let own = own_density(e);
    let visits = visits(e);
    let coordinates = e.coordinates();
    quote! {
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
                #parameters
                let x = #coordinates;
                #density
            }

            #[inline(always)]
            fn pdf_of_uniforms(&self, u: [R; #n]) -> ::aether_core::PdfOf<Self, R> {
                #parameters
                #own
            }

            fn preimages(&self, point: &Self::Point, mut visit: impl FnMut([R; #n], R::Mask)) {
                #parameters
                let x = #coordinates;
                #visits
            }
        }
    }
}

/// The point of `u` and whether there is one, from the piece that `u` falls into.
fn forward(e: &Emitter) -> TokenStream {
    let (n, m, _) = e.sizes();
    let made = e.point(&quote!(c));
    if e.is_whole() {
        return quote! {
            let c = ::aether_core::support::closed::<R, #n, #m>(&u, |t| forward_0::<R>(&p, t));
            (#made, exists_0::<R>(&p, &u))
        };
    }
    let pieces = e.by_piece(|j| {
        let [enter, forward, exists] =
            ["enter", "forward", "exists"].map(|name| format_ident!("{name}_{j}"));
        quote! {
            let t = #enter::<R>(&p, &u);
            let y = ::aether_core::support::closed::<R, #n, #m>(&t, |t| #forward::<R>(&p, t));
            c = ::core::array::from_fn(|i| R::select(taken, y[i], c[i]));
            exists = exists.or(taken.and(#exists::<R>(&p, &t)));
        }
    });
    quote! {
        let mut c = [R::ZERO; #m];
        let mut exists = <R::Mask as Mask>::FALSE;
        #pieces
        (#made, exists)
    }
}

/// Binds `belongs`: finite coordinates, the right surface. For each preimage k, binds `strict_k`,
/// whether it plainly exists, and `recovered_k`, its uniforms if only rounding speaks against it.
pub(super) fn existence(e: &Emitter) -> TokenStream {
    let belongs = e.belongs();
    let places = e.places();
    let strict = places.iter().map(|&place| strictly(e, place));
    let once = places.iter().map(|&place| once(place, &places));
    let recovered = places.iter().map(|&place| recovered(e, place, &places));
    quote! {
        let belongs: R::Mask = #belongs;
        #(#strict)*
        #(#once)*
        #(#recovered)*
    }
}

/// On a border between two pieces rounding can put a point into both, and in the middle of a piece
/// two of its solutions can meet: the preimage counts once.
fn once(place: Place, places: &[Place]) -> TokenStream {
    let guarded = |p: &Place| !p.problem.guards.is_empty();
    let [strict, inverse] = ["strict", "inverse"].map(|n| format_ident!("{n}_{}", place.number));
    let leave = format_ident!("leave_{}", place.piece);
    let pairs = places[..place.number].iter().filter(|other| guarded(other) || guarded(&place));
    let pairs = pairs.map(|other| {
        let [strict_other, inverse_other] =
            ["strict", "inverse"].map(|n| format_ident!("{n}_{}", other.number));
        let leave_other = format_ident!("leave_{}", other.piece);
        quote! {
            let #strict = if #strict.and(#strict_other).any()
                && ::aether_core::support::coincide(
                    &#leave::<R>(&p, &#inverse::<R>(&p, &x)),
                    &#leave_other::<R>(&p, &#inverse_other::<R>(&p, &x)),
                )
            {
                #strict.and(#strict_other.not())
            } else {
                #strict
            };
        }
    });
    quote!(#(#pairs)*)
}

fn strictly(e: &Emitter, place: Place) -> TokenStream {
    let (k, j) = (place.number, place.piece);
    let (n, m, _) = e.sizes();
    let [support, inverse, strict, possible] =
        ["support", "inverse", "strict", "possible"].map(|name| format_ident!("{name}_{k}"));
    let [forward, guards] = ["forward", "guards"].map(|name| format_ident!("{name}_{j}"));
    let guarded =
        (!place.problem.guards.is_empty()).then(|| quote!(.and(#guards::<R>(&p, &checked))));
    let confined = place.problem.segments.iter().any(Option::is_some);
    let wide = format_ident!("wide_{j}");
    let wide = confined.then(|| quote!(.and(#wide::<R>(&p))));
    let membership = place.derived.check_forward.then(|| {
        let tracked = tracked(e, place);
        quote! {
            let #strict = if #strict.any()
                && !::aether_core::support::near::<R, #m>(&#forward::<R>(&p, &#inverse::<R>(&p, &x)), &x)
            {
                let (tp, tt) = #tracked;
                #strict.and(::aether_core::support::mask(
                    ::aether_core::support::leads_back::<R, #n, #m>(tt, &x, |t| #forward::<R::Tracked>(&tp, t))))
            } else { #strict };
        }
    });
    quote! {
        let (checked, ok) = #support::<R>(&p, &x);
        let #possible = ok.and(belongs) #wide;
        let #strict = #possible.and(::aether_core::support::in_unit::<R, _>(&checked)) #guarded;
        #membership
    }
}

/// Parameters and unknowns with error bounds.
fn tracked(e: &Emitter, place: Place) -> TokenStream {
    let inverse = format_ident!("inverse_{}", place.number);
    let tracked = e.tracked();
    quote! {
        {
            let (tp, tx) = (::aether_core::support::track(&p), #tracked);
            let tt = #inverse::<R::Tracked>(&tp, &tx);
            (tp, tt)
        }
    }
}

fn recovered(e: &Emitter, place: Place, places: &[Place]) -> TokenStream {
    let (k, j) = (place.number, place.piece);
    let (n, m, _) = e.sizes();
    let [strict, possible, recovered] =
        ["strict", "possible", "recovered"].map(|name| format_ident!("{name}_{k}"));
    let [forward, margins, leave] =
        ["forward", "margins", "leave"].map(|name| format_ident!("{name}_{j}"));
    let tracked = tracked(e, place);
    let admitted = (!place.problem.guards.is_empty()).then(|| {
        quote!(.filter(|_| ::aether_core::support::admits::<R, _>(#margins::<R::Tracked>(&tp, &tt))))
    });
    let membership = place.derived.check_forward.then(|| {
        quote! {
            .filter(|_| ::aether_core::support::leads_back::<R, #n, #m>(tt, &x, |t| #forward::<R::Tracked>(&tp, t)))
        }
    });
    // Across a jump there is another point: what rounding carried over a border has to lead back.
    let taken = format_ident!("taken_{j}");
    let landed = (!place.problem.guards.is_empty()).then(|| {
        quote! {
            .filter(|u| #taken::<R>(&p, u).any()
                || ::aether_core::support::leads_back::<R, #n, #m>(
                    u.map(Real::track), &x, |u| whole::<R::Tracked>(&tp, u)))
        }
    });
    // A preimage that was accepted by tolerance and equals one that counts already counts once.
    let again = places.iter().filter(|other| other.number != k).map(|other| {
        let [inverse, strict, recovered] =
            ["inverse", "strict", "recovered"].map(|name| format_ident!("{name}_{}", other.number));
        let leave = format_ident!("leave_{}", other.piece);
        let earlier = (other.number < k).then(|| {
            quote! {
                .filter(|u| !#recovered.as_ref().is_some_and(|v| ::aether_core::support::coincide(v, u)))
            }
        });
        quote! {
            .filter(|u| !(#strict.any()
                && ::aether_core::support::coincide(&#leave::<R>(&p, &#inverse::<R>(&p, &x)), u)))
            #earlier
        }
    });
    quote! {
        let #recovered: Option<[R; #n]> = if #possible.any() && !#strict.any() {
            let (tp, tt) = #tracked;
            ::aether_core::support::recover::<R, #n, #m>(tt, &x, |t| #forward::<R::Tracked>(&tp, t))
                #admitted
                #membership
                .map(|t| #leave::<R>(&p, &t))
                #landed
                #(#again)*
        } else {
            None
        };
    }
}

fn density(e: &Emitter) -> TokenStream {
    let existence = existence(e);
    let terms = e.places().into_iter().map(|place| {
        let [density, strict, recovered] =
            ["density", "strict", "recovered"].map(|name| format_ident!("{name}_{}", place.number));
        quote! {
            let inside = #strict.or(::aether_core::support::mask(#recovered.is_some()));
            if inside.any() {
                let d = #density::<R>(&p, &x);
                sum += R::select(inside.and(d.gt(R::ZERO)), d, R::ZERO);
            }
        }
    });
    quote! {
        #existence
        let mut sum = R::ZERO;
        #(#terms)*
        ::aether_core::Density::new(sum)
    }
}

fn visits(e: &Emitter) -> TokenStream {
    let existence = existence(e);
    let each = e.places().into_iter().map(|place| {
        let [inverse, strict, recovered] =
            ["inverse", "strict", "recovered"].map(|name| format_ident!("{name}_{}", place.number));
        let leave = format_ident!("leave_{}", place.piece);
        quote! {
            if let Some(u) = #recovered {
                visit(u, <R::Mask as Mask>::TRUE);
            } else if #strict.any() {
                // The most accurate form may round to one where a shorter one does not.
                let t = #inverse::<R>(&p, &x).map(::aether_core::support::below_one);
                visit(#leave::<R>(&p, &t), #strict);
            }
        }
    });
    quote!(#existence #(#each)*)
}
