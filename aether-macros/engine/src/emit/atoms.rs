//! A sampler whose distribution has atoms: its continuous part is a sampler like any other, of a type of its own, and the
//! whole puts the atoms next to it.

use proc_macro2::{Ident, Literal, TokenStream};
use quote::{format_ident, quote};

use super::code::Code;
use super::item::{Emitter, point_type};
use super::logarithm::{leaves_the_range, logarithm};
use super::passed::passed;
use super::pieces::input;
use crate::derive::Atom;
use crate::expr::Leaf;
use crate::sorted;

/// The type of the continuous part, and all that the whole is made of.
pub fn implementation(e: &Emitter, continuous: &TokenStream) -> TokenStream {
    let (ty, part, args) = (e.type_name(), e.density_type(), e.generics());
    let bounds = if args.is_empty() { quote!() } else { quote!(<R: Real>) };
    let place = point_type(&e.signature().space);
    let (n, _, _) = e.sizes();
    let functions = e.atoms.iter().enumerate().map(|(k, atom)| functions(e, k, atom));
    let parts = parts(e);
    let vis = &e.item.vis;
    let mixed = quote!(::aether_core::mixed);
    quote! {
        /// The continuous part.
        #[derive(Clone, Copy, Debug)]
        #vis struct #part #bounds (#ty #args);
        impl #bounds ::core::ops::Deref for #part #args {
            type Target = #ty #args;
            #[inline(always)]
            fn deref(&self) -> &#ty #args { &self.0 }
        }
        #continuous
        #(#functions)*
        #parts

        #[automatically_derived]
        impl<R: ::aether_core::Scalar> ::aether_core::Sampler<R> for #ty #args {
            type Uniforms = [R; #n];
            type Point = ::aether_core::Mixed<#place>;
            #[inline(always)]
            fn forward(&self, u: [R; #n]) -> (Self::Point, bool) { #mixed::forward(self, u) }
            #[inline(always)]
            fn pdf(&self, x: &Self::Point) -> ::aether_core::PdfOf<Self, R> {
                #mixed::pdf_by(self, x, |part, x| ::aether_core::Sampler::pdf(part, x))
            }
            #[inline(always)]
            fn pdf_as_is(&self, x: &Self::Point) -> ::aether_core::PdfOf<Self, R> {
                #mixed::pdf_by(self, x, |part, x| ::aether_core::Sampler::pdf_as_is(part, x))
            }
            fn pdf_near(
                &self,
                x: &Self::Point,
                errors: ::aether_core::sampler::Errors<'_, Self::Point, R>,
            ) -> ::aether_core::PdfOf<Self, R> {
                #mixed::pdf_by(self, x, |part, x| ::aether_core::Sampler::pdf_near(part, x, errors))
            }
            #[inline(always)]
            fn pdf_of_uniforms(&self, u: [R; #n]) -> ::aether_core::PdfOf<Self, R> {
                #mixed::forward_with_pdf(self, u).2
            }
            #[inline(always)]
            fn forward_with_pdf(&self, u: [R; #n]) -> (Self::Point, bool, ::aether_core::PdfOf<Self, R>) {
                #mixed::forward_with_pdf(self, u)
            }
            fn preimages(&self, x: &Self::Point, visit: impl FnMut([R; #n], bool)) {
                #mixed::preimages(self, x, visit)
            }
            fn log_pdf(&self, x: &Self::Point) -> R { #mixed::log_pdf(self, x) }
        }
    }
}

/// What is computed for a way to an atom.
fn functions(e: &Emitter, k: usize, atom: &Atom) -> TokenStream {
    let (n, m, p) = e.sizes();
    let [taken, open, place, probability, log_probability] =
        ["taken", "open", "place", "probability", "log_probability"]
            .map(|name| format_ident!("atom_{name}_{k}"));
    let at = |l: Leaf| input(l, "u");
    let mut code = Code::new(&atom.way.graph, &at);
    let tests = passed(&mut code, &atom.way.tests);
    let test_lets = code.statements();
    let mut code = Code::new(&atom.way.graph, &at);
    let opened = passed(&mut code, &atom.open);
    let open_lets = code.statements();
    let mut code = Code::new(&atom.way.graph, &at);
    let coordinates: Vec<TokenStream> = atom.way.place.iter().map(|&c| code.value(c)).collect();
    let place_lets = code.statements();
    let mut code = Code::new(&atom.graph, &at);
    let value = code.value(atom.probability);
    // Rounding must not lead out of the interval.
    let range = atom.graph.range(atom.probability);
    let least = (!range.nonnegative()).then(|| quote!(.max(R::ZERO)));
    let most = (range.hi > 1.0).then(|| quote!(.min(R::ONE)));
    let value_lets = code.statements();
    let logarithm = leaves_the_range(&atom.graph, atom.probability).then(|| {
        let mut code = Code::new(&atom.graph, &at);
        let value = logarithm(&mut code, atom.probability);
        let lets = code.statements();
        quote! {
            #[cold]
            fn #log_probability<R: Real>(p: &[R; #p]) -> R { #lets #value }
        }
    });
    quote! {
        /// Whether uniforms lead to the atom this way.
        #[inline(always)]
        fn #taken<R: Real>(p: &[R; #p], u: &[R; #n]) -> R::Mask { #test_lets #tests }
        /// Whether the parameters leave the way open.
        #[inline(always)]
        fn #open<R: Real>(p: &[R; #p]) -> R::Mask { #open_lets #opened }
        /// Where the atom lies.
        #[inline(always)]
        fn #place<R: Real>(p: &[R; #p]) -> [R; #m] { #place_lets [#(#coordinates),*] }
        /// The measure of the uniforms that lead to it this way, if it is open.
        #[inline(always)]
        fn #probability<R: Real>(p: &[R; #p]) -> R { #value_lets #value #least #most }
        #logarithm
    }
}

/// `impl Parts`.
fn parts(e: &Emitter) -> TokenStream {
    let (ty, part, args) = (e.type_name(), e.density_type(), e.generics());
    let place = point_type(&e.signature().space);
    let (n, _, _) = e.sizes();
    let parameters = e.parameters();
    let mut numbers: Vec<usize> = e.atoms.iter().map(|atom| atom.way.number).collect();
    sorted::sort(&mut numbers);
    numbers.dedup();
    let literal = Literal::usize_unsuffixed;
    let names = |k: usize| {
        ["taken", "open", "place", "probability", "log_probability"]
            .map(|name| format_ident!("atom_{name}_{k}"))
    };
    let at = |at: &Ident, atom: &Atom| e.point_with(&quote!(#at::<R>(&p)), &atom.way.identities);
    let ways = || e.atoms.iter().enumerate().map(|(k, atom)| (literal(atom.way.number), k, atom));
    let taken = ways().map(|(number, k, atom)| {
        let [taken, _, place, ..] = names(k);
        let point = at(&place, atom);
        quote!(if #taken::<R>(&p, &u) { return Some((#number, #point)); })
    });
    let places = ways().map(|(number, k, atom)| {
        let [_, open, place, ..] = names(k);
        let point = at(&place, atom);
        quote!(if number == #number && #open::<R>(&p) { return Some(#point); })
    });
    // Several ways to one atom add up.
    let sum = |of: &dyn Fn(usize, &Atom) -> TokenStream,
               add: &dyn Fn(TokenStream) -> TokenStream| {
        numbers
            .iter()
            .map(|&number| {
                let ways = e.atoms.iter().enumerate().filter(|(_, atom)| atom.way.number == number);
                let terms = ways.map(|(k, atom)| {
                    let [_, open, ..] = names(k);
                    let term = add(of(k, atom));
                    quote!(if #open::<R>(&p) { #term })
                });
                let number = literal(number);
                quote!(#number => { #(#terms)* })
            })
            .collect::<Vec<_>>()
    };
    let probabilities = sum(
        &|k, _| {
            let [_, _, _, probability, _] = names(k);
            quote!(#probability::<R>(&p))
        },
        &|term| quote!(sum += #term;),
    );
    let logarithms = sum(
        &|k, atom| {
            let [_, _, _, probability, log_probability] = names(k);
            if leaves_the_range(&atom.graph, atom.probability) {
                quote!(#log_probability::<R>(&p))
            } else {
                quote!(#probability::<R>(&p).ln())
            }
        },
        &|term| quote!(sum = ::aether_core::support::add_logs(sum, #term);),
    );
    let numbers = numbers.iter().map(|&number| literal(number));
    quote! {
        #[automatically_derived]
        impl<R: ::aether_core::Scalar> ::aether_core::mixed::Parts<R> for #ty #args {
            type Place = #place;
            type Continuous = #part #args;
            const ATOMS: &'static [usize] = &[#(#numbers),*];
            #[inline(always)]
            fn continuous(&self) -> Self::Continuous { #part(*self) }
            #[inline(always)]
            fn atom(&self, u: [R; #n]) -> Option<(usize, #place)> {
                #parameters
                #(#taken)*
                None
            }
            fn place(&self, number: usize) -> Option<#place> {
                #parameters
                #(#places)*
                None
            }
            #[inline(always)]
            fn probability(&self, number: usize) -> R {
                #parameters
                let mut sum = R::ZERO;
                match number { #(#probabilities)* _ => {} }
                sum
            }
            fn log_probability(&self, number: usize) -> R {
                let probability = ::aether_core::mixed::Parts::<R>::probability(self, number);
                ::aether_core::support::log_density(probability, || {
                    #parameters
                    let mut sum = -R::INFINITY;
                    match number { #(#logarithms)* _ => {} }
                    sum
                })
            }
        }
    }
}
