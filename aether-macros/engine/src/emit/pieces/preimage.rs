//! The functions of a preimage: its inverse, what tells whether it exists, and its density.

use proc_macro2::TokenStream;
use quote::{format_ident, quote};

use super::{Place, input, is_unguarded};
use crate::derive::{Scaled, Target};
use crate::emit::code::Code;
use crate::emit::item::Emitter;
use crate::emit::logarithm::{leaves_the_range, logarithm};
use crate::emit::plainly::plainly;
use crate::expr::Leaf;

impl<'a> Emitter<'a> {
    pub(super) fn preimage(&self, place: Place) -> TokenStream {
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
        let factor = preimage.back.as_ref().and_then(|image| image.factor).map(|factor| {
            let name = format_ident!("factor_{}", place.number);
            let mut code = Code::new(g, &at);
            let value = code.value(factor);
            let lets = code.statements();
            quote! {
                /// What each coordinate of the image of the unknowns is, over the coordinate.
                #[inline(always)]
                fn #name<R: Real>(p: &[R; #p], x: &[R; #m]) -> R { #lets #value }
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
            #factor
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
    pub(crate) fn has_logarithms(&self) -> bool {
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
    pub(crate) fn member(&self, place: Place, tracked: &TokenStream) -> TokenStream {
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
