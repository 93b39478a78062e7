//! The density of a point that plainly lies inside the support or plainly outside: a few comparisons, and
//! then the formula. What only rounding may have put on its side is left to the general code.

use std::collections::HashMap;

use proc_macro2::TokenStream;
use quote::{format_ident, quote};

use super::code::Code;
use super::fading::{Fading, fading};
use super::item::Emitter;
use super::own::excluding;
use super::peeled::{UnitTest, passed_on};
use super::pieces::{Place, is_unguarded};
use super::plainly::{Condition, between, conditions, kept_between, unit_tests};
use super::sampler::{about, beside, general_density};
use super::seldom::{numbers, taken_numbers};
use super::sure::Sure;
use super::tame::Tame;
use crate::expr::{Leaf, OUTS, leaf_bit};

/// Whether nothing but the ends of unknowns limits the pieces, so that there is a quick way.
fn is_quick(e: &Emitter) -> bool {
    let places = e.places();
    e.support.is_none() && !places.is_empty() && places.iter().all(|p| is_unguarded(*p))
}

/// The density at `point`, if there is a quick way; points that are not plain are left to [`anywhere`]. `belongs` tells whether
/// it belongs to the space.
pub(super) fn density(e: &Emitter) -> Option<TokenStream> {
    if !is_quick(e) {
        return None;
    }
    let places = e.places();
    let plain = places.iter().map(|&place| plain_preimage(e, place, &places));
    let first = belongs_first(e, &places);
    let doubtful = places.iter().map(|&place| doubtful_preimage(e, place, &places, &member(first)));
    // What is read again after calls of functions need not be kept over them.
    let again = e.read_again();
    let [told, found] = ["told", "found"].map(|name| {
        places.iter().map(|place| format_ident!("{name}_{}", place.number)).collect::<Vec<_>>()
    });
    let elsewhere = first.then(|| elsewhere(e));
    Some(quote! {
        'quick: {
            #elsewhere
            let mut sum = R::ZERO;
            #(let (mut #told, mut #found) = (false, false);)*
            #(#plain)*
            if #(!#told)||* {
                #again
                #(#doubtful)*
            }
            sum
        }
    })
}

/// Whether [`density`] asks of coordinates that it does not depend on whether they are finite, and nothing else of the space.
pub(super) fn asks_of_others(e: &Emitter) -> bool {
    let (_, m, _) = e.sizes();
    let depends = |place: &Place, i: usize| {
        place.problem.graph.deps(place.preimage.density) & leaf_bit(Leaf::Out(i as u8)) != 0
    };
    let places = e.places();
    let others = (0..m).any(|i| !places.iter().any(|place| depends(place, i)));
    others
        && is_quick(e)
        && !e.has_surfaces()
        && !places.iter().all(|place| needs_no_look(e, *place))
}

/// Whether it is looked first if a point belongs to the space: on another surface there is no preimage to look for, and of
/// several preimages each would look again. A point that has a preimage is otherwise looked at afterwards.
fn belongs_first(e: &Emitter, places: &[Place]) -> bool {
    let several = places.len() > 1 && !places.iter().all(|place| needs_no_look(e, *place));
    e.has_surfaces() || several
}

/// Whether a point belongs to the space, where that may have been looked at `first`: what is known is not computed again, nor kept.
fn member(first: bool) -> TokenStream {
    if first { quote!(<R::Mask as Mask>::TRUE) } else { quote!(belongs()) }
}

/// Leaves the block if a point does not belong to the space.
fn elsewhere(e: &Emitter) -> TokenStream {
    let (numbers, (_, m, _)) = (numbers(e), e.sizes());
    quote! {
        if !belongs().all() {
            break 'quick if belongs().any() {
                let x: [R; #m] = ::aether_core::support::copied(&x);
                pdf_anywhere::<R>(#numbers belongs(), None)
            } else {
                R::ZERO
            };
        }
    }
}

/// Whether nobody need ask if the coordinates of a point that plainly has a preimage are finite: if they are not, it has none, or
/// the formula of the density tells none.
fn needs_no_look(e: &Emitter, place: Place) -> bool {
    let (_, m, _) = e.sizes();
    tells_finite(e, place) || fading(place, m) != Fading::Stays
}

/// Whether it is the formula of the density that tells none at a point that is not finite.
fn fades(e: &Emitter, place: Place) -> bool {
    let (_, m, _) = e.sizes();
    !tells_finite(e, place) && fading(place, m) == Fading::Fades
}

/// Whether a point with a coordinate that is not finite never plainly has a preimage.
fn tells_finite(e: &Emitter, place: Place) -> bool {
    let (_, m, _) = e.sizes();
    let g = &place.problem.graph;
    let mut known = HashMap::new();
    let tests = tests(place).filter_map(|test| test.bounded);
    let told = tests.fold(0, |all, id| all | passed_on(g, id, &mut known));
    let kept = kept_between(place, 0.0);
    (0..m).all(|i| {
        let between = kept.iter().any(|(k, range)| *k == i && range.width().is_finite());
        between || told & leaf_bit(Leaf::Out(i as u8)) != 0
    })
}

/// The tests of unknowns by which a point plainly has a preimage.
fn tests(place: Place) -> impl Iterator<Item = UnitTest> {
    let mut code = Code::new(&place.problem.graph, &|_| TokenStream::new());
    unit_tests(place, &mut code).into_iter()
}

/// Whether the density of a point that plainly has a preimage is a number that is not negative.
fn is_sure(place: Place) -> bool {
    let compared = tests(place).filter(|test| !test.inside.is_empty());
    let finite = compared.filter_map(|test| test.bounded);
    let signs = conditions(place).into_iter().filter_map(|(id, condition)| match condition {
        Condition::Positive => Some((id, true)),
        Condition::NotNegative => Some((id, false)),
        Condition::HardlyNegative | Condition::Finite => None,
    });
    let sure = Sure::new(&place.problem.graph, finite).told(signs);
    sure.between(between(place).into_iter()).is_positive(place.preimage.density)
}

/// The function for points that are not plainly inside or outside; if there is no quick way, that for all.
pub(super) fn anywhere(e: &Emitter) -> Option<TokenStream> {
    if e.support.is_some() {
        return None;
    }
    let inline = if is_quick(e) { quote!(never) } else { quote!(always) };
    let (numbers, arrays) = taken_numbers(e);
    let (_, m, _) = e.sizes();
    let density = general_density(e);
    let rare = e.places().into_iter().filter(|_| is_quick(e)).map(|place| rare_density(e, place));
    Some(quote! {
        #(#rare)*
        /// The density at any point, whose coordinates may be off by `errors` besides their rounding.
        #[inline(#inline)]
        fn pdf_anywhere<R: Real>(
            #numbers
            belongs: R::Mask,
            errors: Option<&dyn Fn() -> [R; #m]>,
        ) -> R {
            #arrays
            #density
        }
    })
}

/// Adds the density by way of a preimage, if the point plainly has it.
fn plain_preimage(e: &Emitter, place: Place, places: &[Place]) -> TokenStream {
    let (k, j) = (place.number, place.piece);
    let (_, m, s) = e.sizes();
    let [plainly, told, found, inverse, back] =
        ["plainly", "told", "found", "inverse", "back"].map(|name| format_ident!("{name}_{k}"));
    let forward = format_ident!("forward_{j}");
    let value = positive_density(e, place);
    let (belongs, numbers) = (member(belongs_first(e, places)), numbers(e));
    let anywhere = quote!(break 'quick pdf_anywhere::<R>(#numbers #belongs, None););
    let is_multiple = place.preimage.back.as_ref().is_some_and(|image| image.factor.is_some());
    let on_manifold = |beside: Option<TokenStream>| {
        let lies = format_ident!("lies_{k}");
        let near = match place.preimage.back {
            // Multiples of the point are near it where the factor is near one.
            Some(_) if is_multiple => {
                let factor = format_ident!("factor_{k}");
                quote!(::aether_core::support::near_one::<R>(#factor::<R>(&p, &x)))
            }
            Some(_) => quote!(::aether_core::support::near::<R, #m>(&#back::<R>(&p, &x), &x)),
            None => {
                let image = quote!(#forward::<R>(&p, &#inverse::<R>(&p, &x)));
                quote!(::aether_core::support::near::<R, #m>(&#image, &x))
            }
        };
        // What lies far off has no preimage here; next to the manifold it takes other error bounds to tell.
        let otherwise = match place.preimage.back {
            Some(_) => quote! {
                #beside
                let [on, off] = ::aether_core::support::on_or_off::<R, #m, #s>(&p, &x, #lies::<R::Lane>);
                if off.all() {
                    break 'inside;
                }
                if !on.all() { #anywhere }
            },
            None => quote!(#beside #anywhere),
        };
        if place.preimage.back.as_ref().is_some_and(|image| image.scaled.is_some()) {
            let scaled = format_ident!("scaled_{k}");
            return quote! {
                let [on, off] = #scaled::<R>(&p, &x);
                if !on.all() {
                    if off.all() {
                        break 'inside;
                    }
                    #otherwise
                }
            };
        }
        quote!(if !#near.all() { #otherwise })
    };
    let wide = place.wide();
    // On a border it may seem to lie on both sides.
    let beside = places[..k].iter().filter(|other| beside(e, other, &place));
    let beside: Vec<_> = beside.map(|other| format_ident!("found_{}", other.number)).collect();
    let twice = (!beside.is_empty()).then(|| quote!(if #(#beside)||* { #anywhere }));
    // What is infinite fails the tests of unknowns, if each coordinate takes part in one.
    let asked = !belongs_first(e, places) && !needs_no_look(e, place);
    // What is its own image, to a few roundings, is finite; but of what is infinite the factor may be any.
    let (elsewhere, beside_manifold) = match place.derived.check_forward && !is_multiple {
        true => (None, asked.then(|| elsewhere(e))),
        false => (asked.then(|| elsewhere(e)), None),
    };
    let on_manifold = place.derived.check_forward.then(|| on_manifold(beside_manifold));
    let again = e.read_again();
    // Nothing is added to where all others are excluded, or come later.
    let alone = k == 0 || excluding(e, place, places).count() + 1 == places.len();
    let counted = if alone { quote!(sum = #value;) } else { quote!(sum += #value;) };
    let accepted = quote! {
        #elsewhere
        #twice
        #on_manifold
        #again
        #counted
        #found = true;
    };
    let leaves = place.derived.check_forward && place.preimage.back.is_some();
    let accepted = if leaves { quote!('inside: { #accepted }) } else { accepted };
    // Of several lanes some may lie on a border, where an earlier preimage has them.
    let others = excluding(e, place, &places[..k]).map(|other| {
        let plainly = format_ident!("plainly_{}", other.number);
        quote!(.and(#plainly::<R>(&p, &x).not()))
    });
    let tested = quote! {
        #told = #plainly::<R>(&p, &x) #wide #(#others)* .all();
        if #told { #accepted }
    };
    unless_excluded(e, place, &places[..k], tested)
}

/// The density of a point that plainly has a preimage; zero where the formula is no positive number.
fn positive_density(e: &Emitter, place: Place) -> TokenStream {
    let density = format_ident!("density_{}", place.number);
    if is_sure(place) && !fades(e, place) {
        return quote!(#density::<R>(&p, &x));
    }
    if !place.problem.graph.has(place.preimage.density, OUTS) {
        // Of parameters alone there is no limit, and what they make no number is none.
        return quote!(#density::<R>(&p, &x).max(R::ZERO));
    }
    if Tame::new(&place.problem.graph, false, false).all(&[place.preimage.density]) {
        return quote!({ let d = #density::<R>(&p, &x); R::select(d.gt(R::ZERO), d, R::ZERO) });
    }
    let (rare, numbers) = (format_ident!("rare_density_{}", place.number), numbers(e));
    quote!({
        let d = #density::<R>(&p, &x);
        if d.ge(R::ZERO).all() { d } else { #rare::<R>(#numbers d) }
    })
}

/// The function for what a formula of a density tells where it tells none: its limit where it is 0/0, and zero where it is no
/// positive number or the point is not finite.
fn rare_density(e: &Emitter, place: Place) -> TokenStream {
    let (_, m, s) = e.sizes();
    let [rare, density] =
        ["rare_density", "density"].map(|name| format_ident!("{name}_{}", place.number));
    let (numbers, arrays) = taken_numbers(e);
    let at = if fades(e, place) { quote!(rare_density_if_finite) } else { quote!(rare_density) };
    quote! {
        #[cold]
        #[inline(never)]
        fn #rare<R: Real>(#numbers d: R) -> R {
            #arrays
            ::aether_core::support::#at::<R, #s, #m>(d, &p, &x, #density::<R>)
        }
    }
}

/// Leaves the block if only rounding may have put a point outside of a preimage.
fn doubtful_preimage(
    e: &Emitter,
    place: Place,
    places: &[Place],
    belongs: &TokenStream,
) -> TokenStream {
    let [possibly, told, support] =
        ["possibly", "told", "support"].map(|name| format_ident!("{name}_{}", place.number));
    let (near, wide, numbers) = (about(place), place.wide(), numbers(e));
    let tested = quote! {
        let ok = #possibly::<R>(&p, &x) #wide;
        if ok.any() {
            let (checked, ..) = #support::<R>(&p, &x);
            if ok.and(#near).any() {
                break 'quick pdf_anywhere::<R>(#numbers #belongs, None);
            }
        }
    };
    unless_excluded(e, place, places, quote!(if !#told { #tested }))
}

/// What is done unless one of some other preimages has been found, which exclude this one.
fn unless_excluded(e: &Emitter, place: Place, others: &[Place], then: TokenStream) -> TokenStream {
    let found: Vec<_> =
        excluding(e, place, others).map(|other| format_ident!("found_{}", other.number)).collect();
    if found.is_empty() { then } else { quote!(if !(#(#found)||*) { #then }) }
}
