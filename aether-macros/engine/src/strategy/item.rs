//! Emits the items of a strategy: the hidden function, the struct, its constructor, the trait.

mod declared;
mod documented;
mod structure;

use proc_macro2::{Span, TokenStream};
use quote::{quote, quote_spanned};
use syn::{ItemFn, Type, parse_quote};

use super::analyse::Analysed;
use super::reads::Reads;
use super::signature::{Field, Signature};
use super::{density, sample};
use crate::diagnostics::is_lint;
use crate::walk;
use declared::{atoms, classes, declared, same, told_apart};
pub use documented::documentation;
use structure::{Qualify, and, cloneable, constructor, is_reference, real, structure};

/// Everything that the attribute emits; without a plan the methods are left unimplemented.
pub fn item(
    function: &ItemFn,
    signature: &Signature,
    documentation: &str,
    reads: Reads,
    plan: Option<&Analysed>,
) -> TokenStream {
    let hidden = hidden(function, Some(signature));
    let structure = structure(function, signature);
    let constructor = constructor(function, signature, documentation);
    let strategy = strategy(function, signature, reads, plan);
    quote!(#structure #constructor #hidden #strategy)
}

/// The function as it was written, for type checking and editors; nobody can call it.
pub fn hidden(function: &ItemFn, signature: Option<&Signature>) -> TokenStream {
    let mut copy = function.clone();
    copy.vis = syn::Visibility::Inherited;
    copy.attrs.retain(is_lint);
    if let Some(Signature { vertex, yields, count, path, .. }) = signature {
        let real = real(vertex);
        let qualify = Qualify { real: &real, vertex: yields, joint: *count > 1 };
        walk::change_block(&mut |expr| qualify.expr(expr), &mut copy.block);
        // A strategy that does not look at the path has the parameter all the same.
        copy.block.stmts.insert(0, parse_quote!(let _ = &#path;));
    }
    quote! {
        const _: () = {
            #[allow(dead_code, clippy::needless_pass_by_value, clippy::trivially_copy_pass_by_ref)]
            #copy
        };
    }
}

fn is_number(ty: &Type) -> bool {
    matches!(ty, Type::Path(path) if path.path.is_ident("f32") || path.path.is_ident("f64"))
}

fn strategy(
    function: &ItemFn,
    signature: &Signature,
    reads: Reads,
    analysed: Option<&Analysed>,
) -> TokenStream {
    let Signature { name, vertex, generics, .. } = signature;
    let (implementation, arguments, conditions) = generics.split_for_impl();
    let conditions = and(conditions, &cloneable(signature));
    let site = Span::mixed_site();
    let methods = if signature.count == 1 {
        methods(signature, analysed)
    } else {
        joint_methods(signature, analysed)
    };
    let ways = analysed.filter(|analysed| analysed.has_ways());
    let ways = ways.map(|analysed| {
        let Signature { yields, .. } = signature;
        let real = real(vertex);
        // Where it lies: a view of its own would be copied.
        let prelude = prelude(signature, &quote_spanned!(site=> *view));
        let density = density::density(analysed, yields, signature.count > 1, &real);
        quote_spanned! {site=>
            #[allow(unused, unreachable_code, irrefutable_let_patterns, clippy::all, clippy::pedantic)]
            impl #implementation #name #arguments #conditions {
                /// The density; if `OTHERS`, without the way that was `taken` to the vertex `way`.
                fn __density<const OTHERS: bool>(
                    &self,
                    view: &::aether_core::sequence::PathView<'_, #vertex>,
                    target: &#yields,
                    taken: &[usize],
                    way: usize,
                ) -> #real {
                    #prelude
                    #density
                }
            }
        }
    });
    let plan = analysed.map(|analysed| &analysed.plan);
    let atoms = atoms(signature, plan);
    let classes = classes(function, signature, plan);
    let reads = declared(signature, reads, plan);
    let same = same(signature, plan);
    let module = quote!(::aether_core::strategy);
    quote_spanned! {site=>
        #[automatically_derived]
        #[allow(unused, unreachable_code, irrefutable_let_patterns, clippy::all, clippy::pedantic)]
        impl #implementation #module::Strategy<#vertex> for #name #arguments #conditions {
            const ATOMS: #module::Atoms = #atoms;

            #methods

            #[inline]
            fn reads(&self) -> #module::Reads {
                #reads
            }

            #classes

            fn same(&self, other: &Self) -> bool {
                #same
            }
        }

        #ways
    }
}

/// The density of `target`.
fn density(signature: &Signature, analysed: &Analysed, real: &TokenStream) -> TokenStream {
    let site = Span::mixed_site();
    if analysed.has_ways() {
        return quote_spanned!(site=> self.__density::<false>(&view, target, &[], 0));
    }
    let prelude = prelude(signature, &quote_spanned!(site=> view));
    let density = density::density(analysed, &signature.yields, signature.count > 1, real);
    quote_spanned!(site=> { #prelude #density })
}

/// `sample` and `pdf` of a strategy of one vertex.
fn methods(signature: &Signature, analysed: Option<&Analysed>) -> TokenStream {
    let (site, vertex) = (Span::mixed_site(), &signature.vertex);
    let (real, view) = (real(vertex), quote_spanned!(site=> view));
    let prelude = prelude(signature, &view);
    let (sample, pdf) = match analysed {
        Some(analysed @ Analysed { apart, .. }) => {
            let sample = sample::sample(analysed, &real);
            let apart = (!apart.is_empty()).then(|| {
                let checks = apart.iter().map(|apart| told_apart(apart, vertex));
                // Parameters of their own, because naming the type of an expression may move them.
                let parameters = parameters(signature);
                quote!({ #parameters #(#checks)* })
            });
            let value = density(signature, analysed, &real);
            let pdf = quote_spanned! {site=>
                let dirac = ::aether_core::sequence::PathView::dirac(&view);
                ::aether_core::strategy::Conditional { value: #value, dirac }
            };
            (quote!(#prelude #sample), quote!(#apart #pdf))
        }
        None => (quote!(::core::unimplemented!()), quote!(::core::unimplemented!())),
    };
    let module = quote!(::aether_core::strategy);
    quote_spanned! {site=>
        fn sample<U: ::aether_core::UniformSource<#real> + ?::core::marker::Sized>(
            &self,
            view: ::aether_core::sequence::PathView<'_, #vertex>,
            uniforms: &mut U,
        ) -> ::core::option::Option<#module::Drawn<#vertex>> {
            #sample
        }

        fn pdf(
            &self,
            view: ::aether_core::sequence::PathView<'_, #vertex>,
            target: &#vertex,
        ) -> #module::Conditional<#real> {
            #pdf
        }
    }
}

/// The methods of a strategy of several vertices: it never yields a single one.
fn joint_methods(signature: &Signature, analysed: Option<&Analysed>) -> TokenStream {
    let Signature { vertex, yields, count, .. } = signature;
    let (site, real) = (Span::mixed_site(), real(vertex));
    let prelude = prelude(signature, &quote_spanned!(site=> view));
    let (sample, pdf) = match analysed {
        Some(analysed) => {
            let sample = sample::sample(analysed, &real);
            let value = density(signature, analysed, &real);
            let pdf = quote_spanned! {site=>
                let ::core::result::Result::Ok(target) = <&#yields>::try_from(targets) else {
                    return <#real as ::aether_core::Real>::ZERO;
                };
                let view = ::aether_core::sequence::PathView::asking(
                    view, ::core::option::Option::None,
                );
                #value
            };
            (quote!(#prelude #sample), pdf)
        }
        None => (quote!(::core::unimplemented!()), quote!(::core::unimplemented!())),
    };
    let module = quote!(::aether_core::strategy);
    quote_spanned! {site=>
        const VERTICES: usize = #count;

        fn sample<U: ::aether_core::UniformSource<#real> + ?::core::marker::Sized>(
            &self,
            _: ::aether_core::sequence::PathView<'_, #vertex>,
            _: &mut U,
        ) -> ::core::option::Option<#module::Drawn<#vertex>> {
            ::core::option::Option::None
        }

        fn pdf(
            &self,
            _: ::aether_core::sequence::PathView<'_, #vertex>,
            _: &#vertex,
        ) -> #module::Conditional<#real> {
            #module::Conditional::ZERO
        }

        fn sample_joint<U: ::aether_core::UniformSource<#real> + ?::core::marker::Sized>(
            &self,
            view: ::aether_core::sequence::PathView<'_, #vertex>,
            uniforms: &mut U,
        ) -> ::core::option::Option<#module::DrawnRun<#vertex>> {
            let mut draw = || -> ::core::option::Option<#module::Drawn<#yields>> { #sample };
            ::core::option::Option::map(draw(), ::core::convert::From::from)
        }

        fn pdf_joint(
            &self,
            view: ::aether_core::sequence::PathView<'_, #vertex>,
            targets: &[#vertex],
        ) -> #real {
            #pdf
        }
    }
}

/// Binds the path, a view of which is given, and the parameters to their names.
fn prelude(signature: &Signature, view: &TokenStream) -> TokenStream {
    let site = Span::mixed_site();
    let path = &signature.path;
    let reference = signature.path_by_reference.then(|| quote!(&));
    let parameters = parameters(signature);
    quote_spanned!(site=> let #path = #reference #view; #parameters)
}

/// Binds the parameters to their names.
fn parameters(signature: &Signature) -> TokenStream {
    let site = Span::mixed_site();
    let fields = signature.fields.iter().map(|field| {
        let Field { name, mutable, ty } = field;
        let mutable = mutable.then(|| quote!(mut));
        if is_reference(ty) {
            quote_spanned!(site=> let #mutable #name = self.#name;)
        } else {
            quote_spanned!(site=> let #mutable #name = ::core::clone::Clone::clone(&self.#name);)
        }
    });
    quote_spanned!(site=> #(#fields)*)
}
