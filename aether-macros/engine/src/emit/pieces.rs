//! The free functions of an item: for each piece its map, Jacobian and tests, for each preimage its
//! inverse, support and density.
//!
//! `p` are the scalar parameters, `u` the uniforms (or the coordinates of a map's argument), `t` the
//! unknowns of a piece, which run over the unit interval where `u` is confined to a segment, and `x`
//! the coordinates of the point whose density is asked.

mod forward;
mod preimage;

use proc_macro2::{Ident, Literal, Span, TokenStream};
use quote::{format_ident, quote};

use super::item::Emitter;
use super::sampler::is_bounded;
use super::tame::{Tame, has_values};
use crate::derive::{Derived, Preimage, Problem};
use crate::expr::{Id, Leaf};

/// A preimage with its number among all, and the piece that it belongs to.
#[derive(Clone, Copy)]
pub struct Place<'a> {
    /// Number among the preimages of all pieces.
    pub number: usize,
    /// Number of the piece.
    pub piece: usize,
    /// The derivation of the piece.
    pub derived: &'a Derived,
    /// The map of the piece.
    pub problem: &'a Problem,
    /// The preimage.
    pub preimage: &'a Preimage,
}

impl Place<'_> {
    /// The unknowns that have to be tested: those whose range is not settled by interval arithmetic,
    /// and all of them where the piece has tests of its own.
    pub(super) fn checked(&self) -> Vec<usize> {
        let g = &self.problem.graph;
        let settled = |id: Id| g.range(id).within_one();
        let guarded = !self.problem.guards.is_empty();
        let tested = &self.preimage.tested;
        (0..tested.len()).filter(|&i| guarded || !settled(tested[i])).collect()
    }

    /// That the parameters leave the piece any points, where it depends on them whether they do.
    pub(super) fn wide(&self) -> Option<TokenStream> {
        let (wide, problem) = (format_ident!("wide_{}", self.piece), self.problem);
        let confined =
            !problem.existence.is_empty() || problem.segments.iter().any(Option::is_some);
        confined.then(|| quote!(.and(#wide::<R>(&p))))
    }

    /// Whether one of these has a longer and more accurate form.
    pub(super) fn has_longer_forms(&self) -> bool {
        let Preimage { tested, unknowns, .. } = self.preimage;
        self.checked().into_iter().any(|i| tested[i] != unknowns[i])
    }
}

impl<'a> Emitter<'a> {
    /// Whether a piece of the map has a value at all uniforms, so that nobody need look.
    pub(super) fn forward_is_tame(&self, piece: usize) -> bool {
        let graph = &self.parsed.pieces[piece].problem.graph;
        let derived = &self.derived[piece];
        let is_tame = || Tame::new(graph, true, true).all(&derived.forward);
        // In a space of directions, what is infinite is no value.
        let has_values = || {
            let unknowns = self.parsed.pieces[piece].problem.unknowns.len() as u32;
            !is_bounded(self) && unknowns <= 3 && has_values(graph, unknowns, &derived.forward)
        };
        !derived.undefined && (is_tame() || has_values())
    }

    /// All preimages.
    pub(super) fn places(&self) -> Vec<Place<'a>> {
        let pieces = self.parsed.pieces.iter().zip(self.derived).enumerate();
        let all = pieces.flat_map(|(piece, (p, derived))| {
            let place =
                move |preimage| Place { number: 0, piece, derived, problem: &p.problem, preimage };
            derived.preimages.iter().map(place)
        });
        all.enumerate().map(|(number, place)| Place { number, ..place }).collect()
    }

    /// Whether the item is one map on the whole of its domain.
    pub(super) fn is_whole(&self) -> bool {
        let [piece] = &self.parsed.pieces[..] else { return false };
        piece.tests.is_empty()
    }

    /// Whether a point has one preimage at most, and no uniforms are tested.
    pub(super) fn is_single(&self) -> bool {
        self.is_whole() && self.places().len() == 1
    }

    /// Whether one function has the point of the uniforms and their density. A map with several preimages whose point may
    /// be a limit has them apart.
    pub(super) fn is_drawn_at_once(&self) -> bool {
        self.is_single() || self.is_whole() && self.forward_is_tame(0)
    }

    /// Whether it is one of several pieces, of which each has one preimage, that the uniforms of a sample take, and one function
    /// has the point and the density there.
    pub(super) fn draws_pieces(&self) -> bool {
        !self.is_whole() && self.derived.iter().all(|derived| derived.preimages.len() == 1)
    }

    /// All of them.
    pub(super) fn functions(&self) -> TokenStream {
        let mut functions = TokenStream::new();
        for (j, (piece, derived)) in self.parsed.pieces.iter().zip(self.derived).enumerate() {
            functions.extend(self.piece(j, piece, derived));
        }
        for place in self.places() {
            functions.extend(self.preimage(place));
        }
        if !self.is_whole() {
            functions.extend(self.whole());
        }
        functions.extend(self.ways.as_ref().map(|ways| ways.functions(self)));
        functions
    }

    /// What is done in each piece that uniforms `u` take, where `taken` says which of them do. Where every way leads to
    /// a point, the last one is that of those that take no other.
    pub(super) fn by_piece(&self, then: impl Fn(usize) -> TokenStream) -> TokenStream {
        if let Some(ways) = &self.ways {
            let branches = ways.code(&then);
            return quote! {
                let left = <R::Mask as Mask>::TRUE;
                #branches
            };
        }
        let count = self.parsed.pieces.len();
        let pieces = (0..count).map(|j| {
            let (test, then) = (format_ident!("taken_{j}"), then(j));
            if self.parsed.total && j + 1 == count {
                return quote! {
                    let taken = left;
                    if taken.any() { #then }
                };
            }
            quote! {
                let taken = left.and(#test::<R>(&p, &u));
                if taken.any() { #then }
                let left = left.and(taken.not());
            }
        });
        quote! {
            let left = <R::Mask as Mask>::TRUE;
            #(#pieces)*
        }
    }

    /// The map of uniforms as a whole.
    fn whole(&self) -> TokenStream {
        let (n, m, p) = self.sizes();
        let pieces = self.by_piece(|j| {
            let [enter, forward] = ["enter", "forward"].map(|name| format_ident!("{name}_{j}"));
            quote! {
                let y = #forward::<R>(p, &#enter::<R>(p, u));
                c = ::core::array::from_fn(|i| R::select(taken, y[i], c[i]));
            }
        });
        quote! {
            fn whole<R: Real>(p: &[R; #p], u: &[R; #n]) -> [R; #m] {
                let mut c = [R::of(f64::NAN); #m];
                #pieces
                c
            }
        }
    }
}

/// Whether nothing but the ends of unknowns limits the piece of a sampler.
pub(super) fn is_unguarded(place: Place) -> bool {
    place.problem.guards.is_empty() && place.problem.argument.is_none()
}

pub(super) fn input(l: Leaf, unknown: &str) -> TokenStream {
    match l {
        Leaf::Unknown(i) | Leaf::Out(i) => {
            let name = Ident::new(unknown, Span::call_site());
            let i = Literal::usize_unsuffixed(i as usize);
            quote!(#name[#i])
        }
        Leaf::Param(i) => {
            let i = Literal::usize_unsuffixed(i as usize);
            quote!(p[#i])
        }
        Leaf::Bound(_) => super::numeric::variable(l),
    }
}
