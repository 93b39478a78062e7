//! The functions of a piece: its map, its Jacobian, and whether points and uniforms take its way.

use proc_macro2::{Ident, Literal, Span, TokenStream};
use quote::{format_ident, quote};

use super::input;
use crate::derive::{Derived, Problem};
use crate::emit::code::Code;
use crate::emit::item::Emitter;
use crate::emit::own::is_looked_at;
use crate::emit::passed::passed;
use crate::expr::{Id, Leaf};
use crate::parse::Piece;

impl<'a> Emitter<'a> {
    pub(super) fn piece(&self, j: usize, piece: &Piece, derived: &Derived) -> TokenStream {
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
        let at_once = self.is_drawn_at_once() || self.draws_pieces();
        let joint = (is_sampler && at_once).then(|| {
            let mut code = Code::lenient(g, &at);
            if is_looked_at(self) {
                code.look_at(size);
            }
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
}
