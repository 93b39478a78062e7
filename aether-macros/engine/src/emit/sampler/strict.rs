//! Whether a point is one of the map, to within rounding or by error bounds.

use proc_macro2::TokenStream;
use quote::{format_ident, quote};

use super::exists::{Asked, about, encircled};
use crate::emit::item::Emitter;
use crate::emit::own::{excluding, folded};
use crate::emit::pieces::{Place, is_unguarded};

pub(super) fn strictly(e: &Emitter, place: Place, wanted: Option<TokenStream>) -> TokenStream {
    let (k, j) = (place.number, place.piece);
    let (_, m, s) = e.sizes();
    let [support, inverse, strict, possible, open] =
        ["support", "inverse", "strict", "possible", "open"]
            .map(|name| format_ident!("{name}_{k}"));
    let [forward, guards] = ["forward", "guards"].map(|name| format_ident!("{name}_{j}"));
    let guarded =
        (!place.problem.guards.is_empty()).then(|| quote!(.and(#guards::<R>(&p, &checked))));
    let wide = place.wide();
    let member = format_ident!("member_{k}");
    let near = about(place);
    let membership = place.derived.check_forward.then(|| {
        quote! {
            let #strict = if #strict.any() {
                let back = #forward::<R>(&p, &#inverse::<R>(&p, &x));
                let near = ::aether_core::support::near::<R, #m>(&back, &x);
                #strict.and(near.or(::aether_core::support::member::<R, #m, #s>(
                    #strict.and(near.not()), &p, &x, #member::<R::Lane>)))
            } else { #strict };
        }
    });
    let mostly = if is_unguarded(place) {
        let [plainly, possibly] = ["plainly", "possibly"].map(|name| format_ident!("{name}_{k}"));
        quote! {
            let #strict = #plainly::<R>(&p, &x).and(belongs) #wide;
            let ok = if #strict.all() { #strict } else { #possibly::<R>(&p, &x).and(belongs) #wide };
            let unknowns = || { let (checked, ..) = #support::<R>(&p, &x); checked };
        }
    } else {
        quote! {
            let (checked, _, plain, ok) = #support::<R>(&p, &x);
            let ok = ok.and(belongs) #wide;
            let #strict = ok.and(plain).and(::aether_core::support::in_unit::<R, _>(&checked)) #guarded;
            let unknowns = || checked;
        }
    };
    let tested = quote! {
        #mostly
        // Mostly a point lies plainly inside, or not at all.
        let #possible = if #strict.all() {
            #strict
        } else if ok.any() {
            let checked = unknowns();
            ok.and(#near)
        } else {
            ok
        };
        // Unknowns that plainly lie inside are none that rounding could have put outside.
        let #open = #possible.and(#strict.not());
        #membership
    };
    match wanted {
        None => tested,
        Some(wanted) => quote! {
            let wanted: R::Mask = #wanted;
            let (#strict, #open) = if wanted.any() {
                let belongs = belongs.and(wanted);
                #tested
                (#strict, #open)
            } else {
                (wanted, wanted)
            };
        },
    }
}

/// What is decided with error bounds, and so for each lane alone: whether a point that does not
/// plainly lie on the manifold is a member of it, and whether only rounding has put it outside.
pub(super) fn exceptions(e: &Emitter) -> TokenStream {
    let functions = e.places().into_iter().map(|place| {
        let member = place.derived.check_forward.then(|| e.member(place, &e.tracked()));
        let (lies, rounded) = (lies(e, place), rounded(e, place));
        quote!(#member #lies #rounded)
    });
    quote!(#(#functions)*)
}

/// Whether a point is its image under a preimage, and whether it lies far from it, where that image is known as such.
fn lies(e: &Emitter, place: Place) -> Option<TokenStream> {
    let (_, m, s) = e.sizes();
    let [lies, back] = ["lies", "back"].map(|name| format_ident!("{name}_{}", place.number));
    let tracked = e.tracked();
    place.preimage.back.as_ref().map(|_| {
        quote! {
            /// Whether a point lies on the manifold to within error bounds, and whether it plainly does not.
            fn #lies<R: Single>(p: &[R; #s], x: &[R; #m]) -> (bool, bool) {
                let (tp, tx) = (::aether_core::support::track(p), #tracked);
                ::aether_core::support::near_or_far::<R, #m>(#back::<R::Tracked>(&tp, &tx), x)
            }
        }
    })
}

fn rounded(e: &Emitter, place: Place) -> TokenStream {
    let (k, j) = (place.number, place.piece);
    let (n, m, s) = e.sizes();
    let [inverse, rounded, member, support] =
        ["inverse", "rounded", "member", "support"].map(|name| format_ident!("{name}_{k}"));
    let tested = (!place.preimage.conditions.is_empty()).then(
        || quote!(::aether_core::support::admits::<R, _>(#support::<R::Tracked>(&tp, &tx).1)),
    );
    let [forward, margins, leave, taken] =
        ["forward", "margins", "leave", "taken"].map(|name| format_ident!("{name}_{j}"));
    let tracked = e.tracked();
    let guarded = !place.problem.guards.is_empty();
    let admitted = guarded
        .then(|| quote!(::aether_core::support::admits::<R, _>(#margins::<R::Tracked>(&tp, &tt))));
    let membership = place.derived.check_forward.then(|| quote!(#member::<R>(p, x)));
    // Statements, because in unoptimised code a chain of closures is long.
    let checks = tested.into_iter().chain(admitted).chain(membership);
    // Across a jump there is another point: what rounding carried over a border has to lead back.
    let landed = guarded.then(|| {
        quote! {
            let leads = |u: &[R; #n]| ::aether_core::support::leads_back::<R, #n, #m>(
                ::aether_core::support::track(u), x,
                &|u| ::aether_core::support::widened::<R, #m>(whole::<R::Tracked>(&tp, u), errors));
            let taken = |u: &[R; #n]| #taken::<R>(p, u);
            let u = if taken(&u) || leads(&u) {
                u
            } else {
                ::aether_core::support::beside(&u, &bounds, &|u| taken(u) && leads(u))?
            };
        }
    });
    quote! {
        /// The uniforms of a preimage that lies outside by no more than rounding, and by how much they may be off.
        #[cold]
        fn #rounded<R: Single>(p: &[R; #s], x: &[R; #m], errors: Option<[R; #m]>)
            -> Option<::aether_core::support::Rounded<R, #n>>
        {
            let (tp, tx) = (::aether_core::support::track(p), #tracked);
            let tx = ::aether_core::support::widened::<R, #m>(tx, errors);
            let tt = #inverse::<R::Tracked>(&tp, &tx);
            let beside =
                || #inverse::<R::Tracked>(&tp, &::aether_core::support::off_zero::<R, #m>(&tx));
            let (t, bounds) = ::aether_core::support::recover::<R, #n, #m>(tt, x, &beside, &|t| {
                ::aether_core::support::widened::<R, #m>(#forward::<R::Tracked>(&tp, t), errors)
            })?;
            #(if !#checks {
                return None;
            })*
            let u = #leave::<R>(p, &t);
            #landed
            Some((u, bounds))
        }
    }
}

pub(super) fn recovered(e: &Emitter, place: Place, places: &[Place], asked: Asked) -> TokenStream {
    let bounds = if asked.near {
        quote!(errors.map(|errors| ::aether_core::support::lane(&errors(), i)))
    } else {
        quote!(None)
    };
    let k = place.number;
    let (n, _, _) = e.sizes();
    let [open, recovered, rounded] =
        ["open", "recovered", "rounded"].map(|name| format_ident!("{name}_{k}"));
    // A preimage that was accepted by tolerance and equals one that counts already counts once.
    let again = places.iter().filter(|other| other.number != k && !folded(other, &place));
    let again = again.map(|other| {
        let [inverse, strict, recovered] =
            ["inverse", "strict", "recovered"].map(|name| format_ident!("{name}_{}", other.number));
        let leave = format_ident!("leave_{}", other.piece);
        let [same, as_recovered] = if encircled(e, other, &place) {
            [quote!(same_around), quote!(recovered_around)]
        } else {
            [quote!(same), quote!(recovered_as)]
        };
        let earlier = (other.number < k).then(
            || quote!(|| ::aether_core::support::#as_recovered::<R, #n>(&#recovered, i, &found)),
        );
        quote! {
            #strict.lane(i)
                && ::aether_core::support::#same(
                    &#leave::<R::Lane>(&p, &#inverse::<R::Lane>(&p, &x)), &found)
                #earlier
        }
    });
    // Where a whole border leads to one point, as a corner does, the pieces that have it there are one.
    let inverse = format_ident!("inverse_{k}");
    let others = places.iter().filter(|other| other.number != k).map(|other| {
        let [strict, recovered] =
            ["strict", "recovered"].map(|name| format_ident!("{name}_{}", other.number));
        let earlier = (other.number < k)
            .then(|| quote!(.or(::aether_core::support::lanes_of::<R, #n>(&#recovered))));
        quote!(|| #strict #earlier.lane(i))
    });
    // What has a preimage that excludes this one; where an earlier one is plain, this one is not even open.
    let excluded = excluding(e, place, places).map(|other| {
        let [strict, recovered] =
            ["strict", "recovered"].map(|name| format_ident!("{name}_{}", other.number));
        let is_there = if other.number < k {
            quote!(::aether_core::support::lanes_of::<R, #n>(&#recovered))
        } else {
            quote!(#strict)
        };
        quote!(#is_there.lane(i))
    });
    let alone = (places.len() > 1).then(|| {
        let undetermined = quote! {
            ::aether_core::support::undetermined(&#inverse::<R::Lane>(&p, &x))
        };
        if asked.own { undetermined } else { quote!(#undetermined && (false #(#others)*)) }
    });
    let reasons: Vec<TokenStream> = again.chain(excluded).chain(alone).collect();
    let found = quote!(#rounded::<R::Lane>(&p, &x, #bounds));
    // Statements, because in unoptimised code a chain of closures is long.
    let found = match reasons.is_empty() {
        true => found,
        false => quote! {
            let found = #found?;
            #(if #reasons {
                return None;
            })*
            Some(found)
        },
    };
    quote! {
        let #recovered = ::aether_core::support::recovered::<R, #n>(#open, |i| {
            let (p, x) = (::aether_core::support::lane(&p, i), ::aether_core::support::lane(&x, i));
            #found
        });
    }
}
