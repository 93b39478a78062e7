//! Samplers and maps that are compositions of others: `map(…).apply(&other(…).sample(u))`.
//!
//! The called item is opaque here; its space is known by its type, and the composition is resolved
//! through the traits when the code is monomorphised.

use std::collections::HashMap;

use proc_macro2::{Ident, TokenStream};
use quote::{ToTokens, quote};
use syn::{Expr, ItemFn, Lit, Pat, Stmt};

use super::documentation::measures;
use super::interface::{given, hidden_body, hidden_body_with, interface};
use super::item::point_type;
use crate::diagnostics::Diagnostics;
use crate::parse::{Constants, Domain, Options, Param, Signature, Source, type_name};
use crate::walk::{self, Bound, Look};

/// Whether a body calls other samplers or maps.
pub fn is_composition(item: &ItemFn) -> bool {
    let mut calls = Calls(false);
    walk::block(&mut calls, &item.block);
    calls.0
}

struct Calls(bool);

impl Look for Calls {
    fn expr(&mut self, expr: &Expr) -> bool {
        if let Expr::MethodCall(m) = expr {
            self.0 |= m.method == "sample" || m.method == "apply";
        }
        true
    }
}

/// The chain of a composition: how a name or the result is built from the first parameter.
struct Chain<'a> {
    argument: String,
    links: HashMap<String, TokenStream>,
    plain: TokenStream,
    /// The names that links may have read: parameters, and what has been computed of them.
    names: Vec<String>,
    errors: &'a mut Diagnostics,
    sampler: bool,
}

impl Chain<'_> {
    /// The sampler (or map) that an expression stands for.
    fn link(&mut self, e: &Expr) -> Option<TokenStream> {
        match e {
            Expr::Paren(p) => self.link(&p.expr),
            Expr::Reference(r) => self.link(&r.expr),
            Expr::Group(p) => self.link(&p.expr),
            Expr::Path(p) => {
                let name = p.path.get_ident()?.to_string();
                self.links.get(&name).cloned()
            }
            Expr::MethodCall(m)
                if m.method == "sample" && m.args.len() == 1 && self.is_argument(&m.args[0]) =>
            {
                Some(generic(&m.receiver))
            }
            Expr::MethodCall(m) if m.method == "apply" && m.args.len() == 1 => {
                let map = generic(&m.receiver);
                if self.is_argument(&m.args[0]) && !self.sampler {
                    return Some(map);
                }
                let inner = self.link(&m.args[0])?;
                Some(quote!(::aether_core::Then::new(#inner, #map)))
            }
            _ => None,
        }
    }

    fn is_argument(&self, e: &Expr) -> bool {
        match e {
            Expr::Reference(r) => self.is_argument(&r.expr),
            Expr::Path(p) => p.path.get_ident().is_some_and(|i| *i == self.argument),
            _ => false,
        }
    }

    fn statement(&mut self, s: &Stmt) {
        let Stmt::Local(local) = s else {
            self.errors.error(s, "a composition is a chain of `let`s and a result: samplers' `.sample(u)` and maps' `.apply(&x)`");
            return;
        };
        let Some(init) = &local.init else {
            self.errors.error(local, "give this name its value at once");
            return;
        };
        match (&local.pat, self.link(&init.expr)) {
            (Pat::Ident(name), Some(link)) => {
                self.links.insert(name.ident.to_string(), link);
            }
            (pat, Some(_)) => self.errors.error(pat, "give the sampled point a plain name"),
            (pat, None) => {
                if mentions(&init.expr, &self.links, &self.argument) {
                    self.errors.error(&init.expr, "a sampled point can only be passed on to maps: write this computation as a `#[map]` of its own and `.apply` it");
                    return;
                }
                let mut bound = Bound::default();
                walk::pat(&mut bound, pat);
                if let Some(name) = bound.0.iter().find(|name| self.names.contains(name)) {
                    self.errors.error(pat, format!("a chain is put together at its end, where `{name}` can have one value alone: give this one another name"));
                }
                self.names.extend(bound.0);
                let value = generic(&init.expr);
                self.plain.extend(quote!(let #pat = #value;));
            }
        }
    }
}

/// An expression whose number literals are numbers of the generic type.
fn generic(e: &Expr) -> TokenStream {
    let mut e = e.clone();
    let literals = &mut |e: &mut Expr| {
        let Expr::Lit(l) = &*e else { return true };
        if matches!(l.lit, Lit::Float(_))
            && let Ok(new) = syn::parse2(quote!(<R as ::aether_core::Real>::of(#l)))
        {
            *e = new;
        }
        false
    };
    walk::change(literals, &mut e);
    e.to_token_stream()
}

fn mentions(e: &Expr, links: &HashMap<String, TokenStream>, argument: &str) -> bool {
    struct Names<'a>(&'a HashMap<String, TokenStream>, &'a str, bool);
    impl Look for Names<'_> {
        fn name(&mut self, name: &Ident) {
            let name = name.to_string();
            self.2 |= self.0.contains_key(&name) || name == self.1;
        }
    }
    let mut names = Names(links, argument, false);
    walk::expr(&mut names, e);
    names.2
}

/// Emits a composition. `None` if there were errors.
pub fn emit(
    item: &ItemFn,
    signature: &Signature,
    options: &Options,
    errors: &mut Diagnostics,
) -> Option<TokenStream> {
    let (sampler, argument) = match &signature.source {
        Source::Uniforms { name, .. } => (true, name.clone()),
        Source::Point { name, .. } => (false, name.clone()),
    };
    let before = errors.len();
    let names = signature.params.iter().map(|p| p.name.to_string()).collect();
    let (links, plain) = (HashMap::new(), TokenStream::new());
    let mut chain = Chain { argument, links, plain, names, errors, sampler };
    let (last, statements) = item.block.stmts.split_last()?;
    for s in statements {
        chain.statement(s);
    }
    let result = match last {
        Stmt::Expr(e, None) => chain.link(e),
        _ => None,
    };
    let (plain, failed) = (chain.plain.clone(), chain.errors.len() > before);
    let Some(result) = result else {
        if !failed {
            errors.error(last, "the result of a composition is a chain of samplers and maps, such as `rotate(frame).apply(&lobe(n).sample(u))`; write any other computation with the point as a `#[map]` and apply it");
        }
        return None;
    };
    if failed {
        return None;
    }
    let names: Vec<&Ident> = signature.params.iter().map(|p: &Param| &p.name).collect();
    let ty = type_name(&signature.name);
    let generic = signature.params.iter().any(|p| p.kind.is_real());
    let args = if generic { quote!(<R>) } else { quote!() };
    let about = format!(
        "\nA composition: densities divide by the change of measure of each map, over all preimages. \
         Measure: {}. Its parts were checked while compiling; the battery checks it as a whole.",
        measures(signature)
    );
    let docs = quote!(#[doc = #about]);
    let interface = interface(item, signature, options, (&Constants::default(), &[]), &docs);
    let hidden = hidden_body(item);
    let point = point_type(&signature.space);
    let fields = signature.params.iter().map(|p| {
        let name = &p.name;
        given(&p.kind, quote!(self.#name))
    });
    let unpack = quote!(#(let #names = #fields;)* #plain);
    let implementation = match &signature.source {
        Source::Uniforms { count, .. } => quote! {
            #[automatically_derived]
            impl<R: Real> ::aether_core::Sampler<R> for #ty #args {
                type Uniforms = [R; #count];
                type Point = #point;
                #[inline(always)]
                fn forward(&self, u: [R; #count]) -> (Self::Point, R::Mask) { let s = { #unpack #result }; Sampler::<R>::forward(&s, u) }
                #[inline(always)]
                fn pdf(&self, x: &Self::Point) -> ::aether_core::PdfOf<Self, R> { let s = { #unpack #result }; Sampler::<R>::pdf(&s, x) }
                #[inline(always)]
                fn pdf_as_is(&self, x: &Self::Point) -> ::aether_core::PdfOf<Self, R> { let s = { #unpack #result }; Sampler::<R>::pdf_as_is(&s, x) }
                fn pdf_near(&self, x: &Self::Point, errors: ::aether_core::sampler::Errors<'_, Self::Point, R>) -> ::aether_core::PdfOf<Self, R> { let s = { #unpack #result }; Sampler::<R>::pdf_near(&s, x, errors) }
                #[inline(always)]
                fn pdf_of_uniforms(&self, u: [R; #count]) -> ::aether_core::PdfOf<Self, R> { let s = { #unpack #result }; Sampler::<R>::pdf_of_uniforms(&s, u) }
                fn preimages(&self, x: &Self::Point, visit: impl FnMut([R; #count], R::Mask)) { let s = { #unpack #result }; Sampler::<R>::preimages(&s, x, visit) }
            }
        },
        Source::Point { space, .. } => {
            let source = point_type(space);
            quote! {
                #[automatically_derived]
                impl<R: Real> ::aether_core::Map<R> for #ty #args {
                    type Source = #source;
                    type Target = #point;
                    #[inline(always)]
                    fn forward(&self, x: &Self::Source) -> (Self::Target, R::Mask) { let m = { #unpack #result }; Map::<R>::forward(&m, x) }
                    #[inline(always)]
                    fn preimages(&self, y: &Self::Target, visit: impl FnMut(Self::Source, R::Mask)) { let m = { #unpack #result }; Map::<R>::preimages(&m, y, visit) }
                    fn preimages_near(&self, y: &Self::Target, errors: ::aether_core::sampler::Errors<'_, Self::Target, R>, visit: impl FnMut(Self::Source, ::aether_core::sampler::Errors<'_, Self::Source, R>, R::Mask)) { let m = { #unpack #result }; Map::<R>::preimages_near(&m, y, errors, visit) }
                    #[inline(always)]
                    fn jacobian(&self, x: &Self::Source) -> R { let m = { #unpack #result }; Map::<R>::jacobian(&m, x) }
                }
            }
        }
    };
    Some(quote! {
        #interface
        #[allow(clippy::all, clippy::pedantic, unused)]
        const _: () = {
            use ::aether_core::{Map, Real, Sampler};
            #hidden
            #implementation
        };
    })
}

/// What stands in for an item with errors: the body for the editor, and a constructor and impl that
/// keep rustc from reporting the same error again at every use.
pub fn fallback(item: &ItemFn, options: &Options, sampler: bool) -> TokenStream {
    fallback_with(item, options, (&item.block.to_token_stream(), sampler))
}

/// [`fallback`] with the tokens of a body that need not be Rust yet.
pub fn fallback_with(
    item: &ItemFn,
    options: &Options,
    (block, sampler): (&TokenStream, bool),
) -> TokenStream {
    if item.sig.receiver().is_some() {
        // Inside of an `impl` only the method itself can stand.
        let (attrs, vis, sig) = (&item.attrs, &item.vis, &item.sig);
        return quote!(#(#attrs)* #vis #sig #block);
    }
    let hidden = hidden_body_with(item, block);
    let hidden = quote!(#[allow(unused, clippy::all)] const _: () = { #hidden };);
    let mut silent = Diagnostics::new();
    let Some(signature) = crate::parse::signature(item, sampler, &mut silent) else {
        return hidden;
    };
    // With domains the constructor is one that may fail, as it will be; what is wrong may be a relation itself.
    let is_number =
        |d: &&Domain| signature.params.iter().any(|p| p.name == d.name && p.kind.is_number());
    let domains = options.domains.iter().filter(is_number).cloned().collect();
    let options = Options { domains, ..Options::default() };
    let interface = interface(item, &signature, &options, (&Constants::default(), &[]), &quote!());
    let ty = type_name(&signature.name);
    let generic = signature.params.iter().any(|p| p.kind.is_real());
    let args = if generic { quote!(<R>) } else { quote!() };
    let point = point_type(&signature.space);
    let point = if signature.mixed { quote!(::aether_core::Mixed<#point>) } else { point };
    let implementation = match &signature.source {
        Source::Uniforms { count, .. } => quote! {
            impl<R: ::aether_core::Real> ::aether_core::Sampler<R> for #ty #args {
                type Uniforms = [R; #count];
                type Point = #point;
                fn forward(&self, _: [R; #count]) -> (Self::Point, R::Mask) { unimplemented!() }
                fn pdf(&self, _: &Self::Point) -> ::aether_core::PdfOf<Self, R> { unimplemented!() }
                fn pdf_of_uniforms(&self, _: [R; #count]) -> ::aether_core::PdfOf<Self, R> { unimplemented!() }
                fn preimages(&self, _: &Self::Point, _: impl FnMut([R; #count], R::Mask)) { unimplemented!() }
            }
        },
        Source::Point { space, .. } => {
            let source = point_type(space);
            quote! {
                impl<R: ::aether_core::Real> ::aether_core::Map<R> for #ty #args {
                    type Source = #source;
                    type Target = #point;
                    fn forward(&self, _: &Self::Source) -> (Self::Target, R::Mask) { unimplemented!() }
                    fn preimages(&self, _: &Self::Target, _: impl FnMut(Self::Source, R::Mask)) { unimplemented!() }
                    fn jacobian(&self, _: &Self::Source) -> R { unimplemented!() }
                }
            }
        }
    };
    quote!(#hidden #interface #implementation)
}
