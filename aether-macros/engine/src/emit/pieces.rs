//! The free functions of an item: for each piece its map, Jacobian and tests, for each preimage its
//! inverse, support and density.
//!
//! `p` are the scalar parameters, `u` the uniforms (or the coordinates of a map's argument), `t` the
//! unknowns of a piece, which run over the unit interval where `u` is confined to a segment, and `x`
//! the coordinates of the point whose density is asked.

use proc_macro2::{Ident, Literal, Span, TokenStream};
use quote::{format_ident, quote};

use super::code::Code;
use super::item::Emitter;
use super::logarithm::{leaves_the_range, logarithm};
use super::passed::passed;
use super::plainly::plainly;
use super::tame::Tame;
use crate::derive::{Derived, Preimage, Problem, Scaled, Target};
use crate::expr::{Id, Leaf};
use crate::parse::Piece;

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
        !derived.undefined && Tame::new(graph, true, true).all(&derived.forward)
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

    fn piece(&self, j: usize, piece: &Piece, derived: &Derived) -> TokenStream {
        let (n, m, p) = self.sizes();
        let problem = &piece.problem;
        let g = &problem.graph;
        let [forward, exists, size_name, both, leave] =
            ["forward", "exists", "volume", "both", "leave"]
                .map(|name| format_ident!("{name}_{j}"));
        let at = |l: Leaf| input(l, "t");
        let mut code = Code::lenient(g, &at);
        let outputs = code.values(&derived.forward);
        let forward_lets = code.statements();
        let mut code = Code::new(g, &at);
        let required: Vec<TokenStream> =
            problem.requirements.iter().map(|&r| code.value(r)).collect();
        let exists_lets = code.statements();
        // Of a sampler the density is asked, of a map the Jacobian.
        let is_sampler = problem.argument.is_none();
        let size = if is_sampler { derived.own_density } else { derived.volume };
        let size_name = if is_sampler { format_ident!("own_{j}") } else { size_name };
        let mut code = Code::new(g, &at);
        let size_value = code.value(size);
        let size_lets = code.statements();
        let joint = (is_sampler && self.is_drawn_at_once()).then(|| {
            let mut code = Code::lenient(g, &at);
            let mut values = code.values(&[&derived.forward[..], &[size]].concat());
            let density = values.pop();
            let lets = code.statements();
            quote! {
                /// The point and its density.
                #[inline(always)]
                fn #both<R: Real>(p: &[R; #p], t: &[R; #n]) -> ([R; #m], R) {
                    #lets
                    ([#(#values),*], #density)
                }
            }
        });
        let (into, out, open) = self.segments(problem);
        // One map on the whole of its domain has no borders.
        let borders = (!self.is_whole()).then(|| self.borders(j, piece, &into, &open));
        quote! {
            #[inline(always)]
            fn #forward<R: Real>(p: &[R; #p], t: &[R; #n]) -> [R; #m] { #forward_lets [#(#outputs),*] }
            #[inline(always)]
            fn #exists<R: Real>(p: &[R; #p], t: &[R; #n]) -> R::Mask {
                #exists_lets
                <R::Mask as Mask>::TRUE #(.and(#required.gt(R::ZERO)))*
            }
            #[inline(always)]
            fn #size_name<R: Real>(p: &[R; #p], t: &[R; #n]) -> R { #size_lets #size_value }
            #joint
            #borders
            #[inline(always)]
            fn #leave<R: Real>(p: &[R; #p], t: &[R; #n]) -> [R; #n] { #out }
        }
    }

    /// What tells which uniforms, and which unknowns, belong to a piece.
    fn borders(
        &self,
        j: usize,
        piece: &Piece,
        into: &TokenStream,
        open: &TokenStream,
    ) -> TokenStream {
        let (n, _, p) = self.sizes();
        let problem = &piece.problem;
        let [guards, margins, enter, taken, wide] =
            ["guards", "margins", "enter", "taken", "wide"].map(|name| format_ident!("{name}_{j}"));
        let at = |l: Leaf| input(l, "t");
        let mut code = Code::new(&problem.graph, &at);
        let guarded = passed(&mut code, &problem.guards);
        let guard_lets = code.statements();
        let mut code = Code::new(&problem.graph, &at);
        let differences: Vec<TokenStream> =
            problem.guards.iter().map(|t| code.value(t.difference)).collect();
        let c = differences.len();
        let difference_lets = code.statements();
        let at_uniforms = |l: Leaf| input(l, "u");
        let mut code = Code::new(&piece.graph, &at_uniforms);
        let taken_tests = passed(&mut code, &piece.tests);
        let taken_lets = code.statements();
        quote! {
            /// Whether unknowns lie in the piece.
            #[inline(always)]
            fn #guards<R: Real>(p: &[R; #p], t: &[R; #n]) -> R::Mask { #guard_lets #guarded }
            /// By how much.
            #[inline(always)]
            fn #margins<R: Real>(p: &[R; #p], t: &[R; #n]) -> [R; #c] { #difference_lets [#(#differences),*] }
            /// Whether uniforms take this way through the branches.
            #[inline(always)]
            fn #taken<R: Real>(p: &[R; #p], u: &[R; #n]) -> R::Mask { #taken_lets #taken_tests }
            #[inline(always)]
            fn #enter<R: Real>(p: &[R; #p], u: &[R; #n]) -> [R; #n] { #into }
            /// Whether the parameters leave the piece any width.
            #[inline(always)]
            fn #wide<R: Real>(p: &[R; #p]) -> R::Mask { let t = [R::ZERO; #n]; #open }
        }
    }

    /// From uniforms to the unknowns of a piece, and back; and whether the piece has any width.
    fn segments(&self, problem: &Problem) -> (TokenStream, TokenStream, TokenStream) {
        let at = |l: Leaf| input(l, "t");
        let mut code = Code::new(&problem.graph, &at);
        let ends: Vec<Option<(TokenStream, TokenStream)>> = (0..problem.unknowns.len())
            .map(|i| {
                let s = problem.segments.get(i).copied().flatten()?;
                Some((code.value(s.low), code.value(s.width)))
            })
            .collect();
        let lets = code.statements();
        let widths: Vec<&TokenStream> = ends.iter().flatten().map(|(_, width)| width).collect();
        let exists = (!problem.existence.is_empty()).then(|| {
            let mut code = Code::new(&problem.graph, &at);
            let passed = passed(&mut code, &problem.existence);
            let lets = code.statements();
            quote!(.and({ #lets #passed }))
        });
        let open = quote!(#lets <R::Mask as Mask>::TRUE #(.and(#widths.gt(R::ZERO)))* #exists);
        let place = |name: &str, i: usize| {
            let name = Ident::new(name, Span::call_site());
            let i = Literal::usize_unsuffixed(i);
            quote!(#name[#i])
        };
        // Differences of numbers with few binary digits are not rounded, nor is one from zero; an end that belongs to the
        // piece has a place just below one.
        let exact = |i: usize| {
            let few = |id: Id| problem.graph.as_number(id).filter(|q| q.den().count_ones() == 1);
            let segment = problem.segments.get(i).copied().flatten();
            segment.filter(|s| !s.closed).is_some_and(|s| {
                few(s.low).is_some_and(|low| low.is_zero() || few(s.width).is_some())
            })
        };
        let into = ends.iter().enumerate().map(|(i, s)| {
            let u = place("u", i);
            s.as_ref().map_or(u.clone(), |(low, width)| {
                let place = quote!((#u - #low) / (#width));
                // Below its end a uniform may be so near to it that its place is rounded up to one.
                if exact(i) { place } else { quote!(::aether_core::support::unit(#place)) }
            })
        });
        let out = ends.iter().enumerate().map(|(i, s)| {
            let t = place("t", i);
            s.as_ref().map_or(
                t.clone(),
                |(low, width)| quote!(::aether_core::support::within(#low, #width, #t)),
            )
        });
        let (into, out) = (quote!(#lets [#(#into),*]), quote!(#lets [#(#out),*]));
        (into, out, open)
    }

    fn preimage(&self, place: Place) -> TokenStream {
        let g = &place.problem.graph;
        let preimage = place.preimage;
        let (n, m, p) = self.sizes();
        let at = |l: Leaf| input(l, "x");
        let [inverse, support, density] =
            ["inverse", "support", "density"].map(|name| format_ident!("{name}_{}", place.number));
        let mut code = Code::new(g, &at);
        let unknowns: Vec<TokenStream> = preimage.unknowns.iter().map(|&u| code.value(u)).collect();
        let inverse_lets = code.statements();
        let checked = place.checked();
        let c = checked.len();
        let mut code = Code::new(g, &at);
        let conditions: Vec<TokenStream> =
            preimage.conditions.iter().map(|&c| code.value(c)).collect();
        let tests = conditions.len();
        let requirements: Vec<TokenStream> =
            preimage.requirements.iter().map(|&c| code.value(c)).collect();
        let uniforms: Vec<TokenStream> =
            checked.iter().map(|&i| code.value(preimage.tested[i])).collect();
        let support_lets = code.statements();
        // The rim of a lobe belongs to it even if a rotation rounded the point below the horizon.
        let least = if place.problem.parts.iter().any(|p| p.target == Target::Direction) {
            quote!(R::of(-16.0) * R::EPSILON)
        } else {
            quote!(R::ZERO)
        };
        let plainly = is_unguarded(place).then(|| plainly(self, place, &least));
        let back = preimage.back.as_ref().map(|image| {
            let name = format_ident!("back_{}", place.number);
            let mut code = Code::sharing(g, &at, &image.shared);
            let values: Vec<TokenStream> =
                image.coordinates.iter().map(|&id| code.value(id)).collect();
            let lets = code.statements();
            quote! {
                /// The image of the unknowns.
                #[inline(always)]
                fn #name<R: Real>(p: &[R; #p], x: &[R; #m]) -> [R; #m] { #lets [#(#values),*] }
            }
        });
        let scaled = preimage.back.as_ref().and_then(|image| image.scaled.as_ref());
        let scaled = scaled.map(|scaled| self.scaled(place, scaled));
        let mut code = Code::new(g, &at);
        let value = code.value(preimage.density);
        let density_lets = code.statements();
        let log_density = self.has_logarithms().then(|| self.log_density(place));
        let accurate = place.has_longer_forms().then(|| {
            let name = format_ident!("accurate_{}", place.number);
            let mut code = Code::new(g, &at);
            let values: Vec<TokenStream> =
                checked.iter().map(|&i| code.value(preimage.unknowns[i])).collect();
            let lets = code.statements();
            quote! {
                /// The unknowns that are tested, as accurate as they can be had.
                #[inline(always)]
                fn #name<R: Real>(p: &[R; #p], x: &[R; #m]) -> [R; #c] { #lets [#(#values),*] }
            }
        });
        quote! {
            #[inline(always)]
            fn #inverse<R: Real>(p: &[R; #p], x: &[R; #m]) -> [R; #n] { #inverse_lets [#(#unknowns),*] }
            #[inline(always)]
            fn #support<R: Real>(p: &[R; #p], x: &[R; #m]) -> ([R; #c], [R; #tests], R::Mask, R::Mask) {
                #support_lets
                let exists = <R::Mask as Mask>::TRUE #(.and(#requirements.gt(R::ZERO)))*;
                let tests: [R; #tests] = [#(#conditions),*];
                let plain = ::aether_core::support::all_at_least(exists, &tests, #least);
                // A test that is 0/0, in a corner, says nothing, and one that fails by little may have
                // been rounded: error bounds decide.
                let possible = ::aether_core::support::none_below(exists, &tests, R::of(-1.0 / 256.0));
                ([#(#uniforms),*], tests, plain, possible)
            }
            #plainly
            #accurate
            #back
            #scaled
            #[inline(always)]
            fn #density<R: Real>(p: &[R; #p], x: &[R; #m]) -> R { #density_lets #value }
            #log_density
        }
    }

    /// The function that tells whether a point lies on the manifold where its image is a multiple of it.
    fn scaled(&self, place: Place, scaled: &Scaled) -> TokenStream {
        let (_, m, p) = self.sizes();
        let name = format_ident!("scaled_{}", place.number);
        let at = |l: Leaf| input(l, "x");
        let mut code = Code::new(&place.problem.graph, &at);
        let offsets = code.values(&scaled.offsets);
        let sums = code.values(&[scaled.excess, scaled.below, scaled.sizes]);
        let lets = code.statements();
        quote! {
            /// Whether the point plainly lies on the manifold, and whether it plainly does not.
            #[inline(always)]
            fn #name<R: Real>(p: &[R; #p], x: &[R; #m]) -> [R::Mask; 2] {
                #lets
                ::aether_core::support::near_or_far_multiple(x, [#(#offsets),*], [#(#sums),*])
            }
        }
    }

    /// Whether densities leave the range of numbers, so that their logarithm is emitted too.
    pub(super) fn has_logarithms(&self) -> bool {
        let is_sampler = self.parsed.pieces.iter().all(|p| p.problem.argument.is_none());
        let leaves = |p: &Place| leaves_the_range(&p.problem.graph, p.preimage.density);
        is_sampler && self.places().iter().any(leaves)
    }

    fn log_density(&self, place: Place) -> TokenStream {
        let (_, m, p) = self.sizes();
        let at = |l: Leaf| input(l, "x");
        let name = format_ident!("log_density_{}", place.number);
        let mut code = Code::new(&place.problem.graph, &at);
        let value = logarithm(&mut code, place.preimage.density);
        let lets = code.statements();
        quote! {
            #[cold]
            fn #name<R: Real>(p: &[R; #p], x: &[R; #m]) -> R { #lets #value }
        }
    }

    /// Whether a point lies on the manifold to within error bounds, those of its coordinates `tracked`.
    pub(super) fn member(&self, place: Place, tracked: &TokenStream) -> TokenStream {
        let (n, m, s) = self.sizes();
        let [member, inverse, lies] =
            ["member", "inverse", "lies"].map(|name| format_ident!("{name}_{}", place.number));
        let forward = format_ident!("forward_{}", place.piece);
        // Rounding may put a uniform beyond its end, where the map need not have a value.
        let unit = place.problem.argument.is_none();
        let clamped = unit.then(|| quote!(let tt = ::aether_core::support::to_unit(tt);));
        // The image in terms of the point tells first, as it does on the quick way of samplers.
        let told = place.preimage.back.as_ref().filter(|_| unit).map(|_| {
            quote! {
                let (on, off) = #lies::<R>(p, x);
                if on || off {
                    return on;
                }
            }
        });
        quote! {
            #[cold]
            fn #member<R: Single>(p: &[R; #s], x: &[R; #m]) -> bool {
                #told
                let (tp, tx) = (::aether_core::support::track(p), #tracked);
                let tt = #inverse::<R::Tracked>(&tp, &tx);
                #clamped
                ::aether_core::support::leads_back::<R, #n, #m>(tt, x, &|t| #forward::<R::Tracked>(&tp, t))
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
