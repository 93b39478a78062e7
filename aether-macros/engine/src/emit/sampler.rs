//! `impl Sampler`.

use proc_macro2::TokenStream;
use quote::{format_ident, quote};

use super::item::{Emitter, point_type};
use super::meeting::{adjacent, around};
use super::own::{density_of, excluding, exclusive, folded, forward_with_density, own_density};
use super::pieces::{Place, is_unguarded};
use super::quick;
use super::tame::Tame;
use crate::parse::Space;

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
    let (n, m, s) = e.sizes();
    let forward = format_ident!("forward_{j}");
    if e.forward_is_tame(j) {
        quote!((#forward::<R>(&p, &t), <R::Mask as Mask>::TRUE))
    } else {
        let (value, bounded) = (quote!(#forward::<R>(&p, &t)), is_bounded(e));
        quote!(::aether_core::support::closed::<R, #s, #n, #m>(taken, #bounded, (&p, &t), #value, #forward::<R>))
    }
}

/// Whether no point of the space has infinite coordinates, a direction or several points with one.
fn is_bounded(e: &Emitter) -> bool {
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

/// Binds `belongs`: finite coordinates, the right surface. For each preimage k, binds `strict_k`,
/// where it plainly exists, and `recovered_k`, its uniforms where only rounding speaks against it.
pub(super) fn existence(e: &Emitter) -> TokenStream {
    let (belongs, found) = (e.belongs(), existence_where_it_belongs(e, false));
    quote! {
        let belongs: R::Mask = #belongs;
        #found
    }
}

/// The same where `belongs` is known; `near` says that coordinates may be off by `errors`.
fn existence_where_it_belongs(e: &Emitter, near: bool) -> TokenStream {
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
pub(super) struct Asked {
    /// Whether coordinates may be off by `errors`.
    pub(super) near: bool,
    /// Whether the point is a sample, whose own preimage is known to be in another piece.
    pub(super) own: bool,
}

/// The same for the preimages of each piece only where a mask holds, if there is one; `belongs` is known.
pub(super) fn existence_where(
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
pub(super) fn beside(e: &Emitter, one: &Place, other: &Place) -> bool {
    // What costs most is asked last.
    let open = !folded(one, other) && !exclusive(e, one, other);
    open && (around(one, other) || adjacent(one, other))
}

/// Whether the first and the last of the pieces have a border in common which no other test excludes.
pub(super) fn encircled(e: &Emitter, one: &Place, other: &Place) -> bool {
    around(one, other) && !exclusive(e, one, other)
}

/// Whether the unknowns that are `checked` lie so near to their range that error bounds have to decide.
pub(super) fn about(place: Place) -> TokenStream {
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

fn strictly(e: &Emitter, place: Place, wanted: Option<TokenStream>) -> TokenStream {
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
fn exceptions(e: &Emitter) -> TokenStream {
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

fn recovered(e: &Emitter, place: Place, places: &[Place], asked: Asked) -> TokenStream {
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

/// The density at `point`; the method that tells it, if it is one of its own; and that for points whose coordinates are finite, if
/// it is another.
fn density(e: &Emitter) -> [TokenStream; 3] {
    let (parameters, coordinates, belongs) = (e.parameters(), e.coordinates(), e.belongs());
    let density = match (e.support, quick::density(e)) {
        (Some(support), _) => {
            let (test, value) = (support.test(), support.value());
            support.where_it_belongs(e, &quote!(R::select(belongs #test, #value, R::ZERO)))
        }
        (None, Some(quick)) if quick::asks_of_others(e) => return density_where(e, &quick),
        (None, Some(quick)) => quote!(let belongs = || -> R::Mask { #belongs }; #quick),
        (None, None) => quote!(pdf_anywhere::<R>(p, x, #belongs, None)),
    };
    let density = quote! {
        #parameters
        let x = #coordinates;
        ::aether_core::Density::new({ #density })
    };
    [density, quote!(), quote!()]
}

/// The same by a method that is told whether the point belongs to the space.
fn density_where(e: &Emitter, quick: &TokenStream) -> [TokenStream; 3] {
    let (parameters, coordinates, belongs) = (e.parameters(), e.coordinates(), e.belongs());
    let (ty, args, point) = (e.density_type(), e.generics(), point_type(&e.signature().space));
    let (outside, inside) = e.bounds();
    let method = quote! {
        impl #outside #ty #args {
            #[inline(always)]
            fn density_where #inside(&self, point: &#point, belongs: impl Fn() -> R::Mask) -> ::aether_core::PdfOf<Self, R> {
                #parameters
                let x = #coordinates;
                ::aether_core::Density::new(#quick)
            }
        }
    };
    let density = quote! {
        let x = #coordinates;
        self.density_where(point, || #belongs)
    };
    let of_finite = quote! {
        #[inline(always)]
        fn pdf_of_finite(&self, point: &Self::Point) -> ::aether_core::PdfOf<Self, R> {
            self.density_where(point, || <R::Mask as Mask>::TRUE)
        }
    };
    [density, method, of_finite]
}

/// [`pdf_near`](::aether_core::Sampler::pdf_near), unless every point of the space has a density.
fn density_near(e: &Emitter) -> Option<TokenStream> {
    let (parameters, coordinates, belongs) = (e.parameters(), e.coordinates(), e.belongs());
    let (_, m, _) = e.sizes();
    let density = match e.support {
        Some(support) => support.density_near(e)?,
        None => quote!(pdf_anywhere::<R>(p, x, #belongs, Some(&errors))),
    };
    Some(quote! {
        fn pdf_near(
            &self,
            point: &Self::Point,
            errors: ::aether_core::sampler::Errors<'_, Self::Point, R>,
        ) -> ::aether_core::PdfOf<Self, R> {
            #parameters
            let x = #coordinates;
            let errors = || -> [R; #m] { ::aether_core::support::numbers(errors()) };
            ::aether_core::Density::new(#density)
        }
    })
}

/// The density at any point, where it is known which belong to the space and by how much coordinates may be off.
pub(super) fn general_density(e: &Emitter) -> TokenStream {
    let existence = existence_where_it_belongs(e, true);
    let (n, _, _) = e.sizes();
    let places = e.places();
    let single = places.len() == 1;
    let terms = places.into_iter().map(|place| {
        let [strict, recovered] =
            ["strict", "recovered"].map(|name| format_ident!("{name}_{}", place.number));
        let value = value_at(e, place, &quote!(inside));
        let sum = if single { quote!(sum = d) } else { quote!(sum += d) };
        quote! {
            let inside = #strict.or(::aether_core::support::lanes_of::<R, #n>(&#recovered));
            if inside.any() {
                let d = #value;
                let d = R::select(inside.and(d.gt(R::ZERO)), d, R::ZERO);
                #sum;
            }
        }
    });
    quote! {
        #existence
        let mut sum = R::ZERO;
        #(#terms)*
        sum
    }
}

/// The density at `x` by way of a preimage, or its limit where it is 0/0 and `wanted`.
pub(super) fn value_at(e: &Emitter, place: Place, wanted: &TokenStream) -> TokenStream {
    let (_, m, s) = e.sizes();
    let density = format_ident!("density_{}", place.number);
    if Tame::new(&place.problem.graph, false, false).all(&[place.preimage.density]) {
        quote!(#density::<R>(&p, &x))
    } else {
        quote!(::aether_core::support::limit::<R, #s, #m>(#wanted, &p, &x, #density::<R>))
    }
}

/// The logarithm of the density where the density has left the range of numbers.
fn log_density(e: &Emitter) -> TokenStream {
    let existence = existence(e);
    let (n, _, _) = e.sizes();
    let (parameters, coordinates) = (e.parameters(), e.coordinates());
    let terms = e.places().into_iter().map(|place| {
        let [density, strict, recovered] = ["log_density", "strict", "recovered"]
            .map(|name| format_ident!("{name}_{}", place.number));
        quote! {
            let inside = #strict.or(::aether_core::support::lanes_of::<R, #n>(&#recovered));
            if inside.any() {
                let d = #density::<R>(&p, &x);
                let d = R::select(inside.and(d.ge(d)), d, -R::INFINITY);
                sum = ::aether_core::support::add_logs(sum, d);
            }
        }
    });
    quote! {
        fn log_pdf(&self, point: &Self::Point) -> R {
            let density = ::aether_core::Sampler::pdf(self, point).value();
            ::aether_core::support::log_density(density, || {
                #parameters
                let x = #coordinates;
                #existence
                let mut sum = -R::INFINITY;
                #(#terms)*
                sum
            })
        }
    }
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
