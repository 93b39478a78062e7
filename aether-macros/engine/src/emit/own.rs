//! The density of a sample from its uniforms.

use proc_macro2::{Ident, TokenStream};
use quote::{format_ident, quote};

use super::item::{Emitter, point_type};
use super::jumps::jumps;
use super::meeting;
use super::pieces::Place;
use super::sampler::{Asked, encircled, existence, existence_where, value_at};
use super::tame::Tame;
use crate::derive::Derived;
use crate::expr::{Id, Node, OUTS, UNKNOWNS};
use crate::rational::Q;

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
    let told = e.is_whole().then(|| quote!(d: R,));
    let (outside, inside) = e.bounds();
    Some(quote! {
        impl #outside #ty #args {
            #[inline(always)]
            fn density_of #inside(&self, u: [R; #n], #told point: #point, exists: R::Mask) -> ::aether_core::PdfOf<Self, R> {
                #parameters
                #density
            }
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

/// What there is to know of the density `d` at uniforms, where a map has one preimage.
#[derive(Clone, Copy)]
enum Told {
    /// It has a value at all uniforms and depends on nothing else.
    Always,
    /// It depends on parameters alone, as the density at any point does: that would not tell more.
    ByParameters,
    /// The uniforms may not tell it. At zero the map may only have a limit (a pole, an axis), and so may the Jacobian; the
    /// density at the point knows it. Parameters may overflow.
    AtUniforms,
}

impl Told {
    fn of(e: &Emitter) -> Self {
        let graph = &e.parsed.pieces[0].problem.graph;
        let Derived { own_density, preimages, .. } = &e.derived[0];
        if is_tame(e, 0) && !has_parameters(e, 0) {
            Told::Always
        } else if !graph.has(*own_density, UNKNOWNS) && preimages[0].density == *own_density {
            Told::ByParameters
        } else {
            Told::AtUniforms
        }
    }

    /// The density from `d`.
    fn value(self) -> TokenStream {
        match self {
            // What parameters make no number is none at the point.
            Told::ByParameters => quote!(d.max(R::ZERO)),
            _ => quote!(d),
        }
    }
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
        let [enter, forward, own, exists] =
            ["enter", "forward", "own", "exists"].map(|name| format_ident!("{name}_{j}"));
        let inside = inside(e, j, &quote!(t));
        quote! {
            let t = #enter::<R>(&p, &u);
            let y = #forward::<R>(&p, &t);
            c = ::core::array::from_fn(|i| R::select(taken, y[i], c[i]));
            exists = exists.or(taken.and(#exists::<R>(&p, &t)));
            d = R::select(taken, #own::<R>(&p, &t), d);
            inside = inside.or(taken #inside);
        }
    });
    let tame = (0..e.parsed.pieces.len()).all(|j| e.forward_is_tame(j));
    let coordinates =
        if tame { quote!(plain::<R, 0>(&[], d)) } else { quote!(plain::<R, #m>(&c, d)) };
    let required = e.parsed.pieces.iter().any(|piece| !piece.problem.requirements.is_empty());
    // Where there is no sample, there is nothing to look after.
    let (exists, missing) = if e.parsed.total && !required {
        (quote!(<R::Mask as Mask>::TRUE), None)
    } else {
        (quote!(exists), Some(quote!(.or(exists.not()))))
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
            let plain: R::Mask = ::aether_core::support::#coordinates.and(inside);
            if plain #missing .all() {
                (#made, exists, ::aether_core::Density::new(R::select(exists, d, R::ZERO)))
            } else {
                let inner = ::aether_core::support::positive::<R>(d).and(inside);
                let (point, exists, d) = ::aether_core::support::rare_sample_of_pieces::<R, _>(*self, u, d, inner);
                (point, exists, ::aether_core::Density::new(d))
            }
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

/// The density `d` at the uniforms, or its limit.
fn single(e: &Emitter) -> TokenStream {
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
fn is_tame(e: &Emitter, piece: usize) -> bool {
    let graph = &e.parsed.pieces[piece].problem.graph;
    Tame::new(graph, true, false).all(&[e.derived[piece].own_density])
}

/// Whether the density of a piece depends on parameters.
fn has_parameters(e: &Emitter, piece: usize) -> bool {
    let graph = &e.parsed.pieces[piece].problem.graph;
    graph.has(e.derived[piece].own_density, !(UNKNOWNS | OUTS))
}

/// Where each piece has one preimage: that of the piece that `u` takes is `u` itself, with the density of the
/// uniforms, and only pieces whose images overlap with its own are inverted.
fn one_a_piece(e: &Emitter) -> TokenStream {
    let (n, _, _) = e.sizes();
    let (coordinates, belongs) = (e.coordinates(), e.belongs());
    let pieces = e.parsed.pieces.len();
    let own = e.by_piece(|j| {
        let [enter, own] = ["enter", "own"].map(|name| format_ident!("{name}_{j}"));
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
            let t = #enter::<R>(&p, &u);
            let d = #own::<R>(&p, &t);
            let here = taken.and(#here);
            sum = R::select(here, d, sum);
            inner = inner.or(here);
            at_border = at_border.or(here.and(#ends));
            #taken = here;
        }
    });
    let masks: Vec<_> = (0..pieces).map(|j| format_ident!("own_piece_{j}")).collect();
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
        let mut sum = R::ZERO;
        let mut inner = <R::Mask as Mask>::FALSE;
        let mut at_border = <R::Mask as Mask>::FALSE;
        #(let mut #masks = <R::Mask as Mask>::FALSE;)*
        #own
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

/// Whether the images of two pieces have no more than a border in common, by the ranges of a coordinate.
pub(super) fn apart(e: &Emitter, j: usize, k: usize) -> bool {
    let range = |piece: usize, i: usize| {
        let problem = &e.parsed.pieces[piece].problem;
        problem.graph.range(problem.outputs[i])
    };
    let (_, m, _) = e.sizes();
    (0..m).any(|i| {
        let (a, b) = (range(j, i), range(k, i));
        a.hi <= b.lo || b.hi <= a.lo
    })
}

/// Whether no point has both preimages, but on a border, where they are one: those of pieces that are apart or meet, and of
/// one piece if one asks a number to be negative that the other asks to be positive, as two signs of an amplitude do.
pub(super) fn exclusive(e: &Emitter, one: &Place, other: &Place) -> bool {
    if one.piece != other.piece {
        return apart(e, one.piece, other.piece) || meeting::known(&e.meeting, one, other);
    }
    let g = &one.problem.graph;
    let negated = |a: Id, b: Id| match g.node(a) {
        Node::Sum(c, terms) => c.is_zero() && terms[..] == [(Q::int(-1), b)],
        _ => false,
    };
    let theirs = &other.preimage.conditions;
    one.preimage.conditions.iter().any(|&a| theirs.iter().any(|&b| negated(a, b) || negated(b, a)))
}

/// Whether no point of a piece has a preimage in another one.
fn excludes(e: &Emitter, places: &[Place], piece: usize, place: &Place) -> bool {
    let mut of_piece = places.iter().filter(|other| other.piece == piece);
    of_piece.all(|other| exclusive(e, other, place))
}

/// Whether the images of two pieces lie on the same side of a border that they have in common, as the map turns its
/// orientation round there: a point next to it has a preimage in both, and one on it has, in the limit, two.
pub(super) fn folded(one: &Place, other: &Place) -> bool {
    let sides = [one, other].map(|place| place.derived.orientation);
    one.piece != other.piece && matches!(sides, [Some(a), Some(b)] if a != b)
}

/// Those of some preimages that exclude one.
pub(super) fn excluding<'p, 'a: 'p>(
    e: &Emitter,
    place: Place<'a>,
    others: &'p [Place<'a>],
) -> impl Iterator<Item = &'p Place<'a>> {
    let others = others.iter().filter(move |other| other.number != place.number);
    others.filter(move |other| exclusive(e, other, &place))
}

/// Of the preimages in the piece that `u` takes, the nearest is `u` itself: its density is that of
/// the uniforms, not of the rounded point.
fn among_several(e: &Emitter) -> TokenStream {
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
