//! The type of a strategy and its constructor.

use proc_macro2::{Span, TokenStream};
use quote::{ToTokens, quote};
use syn::{Expr, GenericParam, Ident, ItemFn, Type, parse_quote};

use crate::diagnostics::is_lint;
use crate::strategy::names::{delegate, form, is_stop};
use crate::strategy::signature::{Field, Signature};

pub(super) fn real(vertex: &Type) -> TokenStream {
    quote!(<#vertex as ::aether_core::strategy::Vertex>::Real)
}

/// Makes the special forms name functions of the runtime.
pub(super) struct Qualify<'a> {
    pub(super) real: &'a TokenStream,
    pub(super) vertex: &'a Type,
    /// Whether there are several vertices.
    pub(super) joint: bool,
}

impl Qualify<'_> {
    pub(super) fn expr(&self, expr: &mut Expr) -> bool {
        if let Expr::Return(_) = expr
            && is_stop(expr)
            && let Expr::Return(ret) = expr
            && let Some(stop) = ret.expr.take()
        {
            *expr = *stop;
        }
        if let Expr::MethodCall(call) = expr
            && call.method == "identified_by"
            && let Some((name, choice)) = form(&call.receiver)
            && name == "choose"
        {
            let (real, vertex) = (self.real, self.vertex);
            let (distribution, rule) = (&choice.args, &call.args);
            let function = Ident::new("choose_identified", name.span());
            *expr = parse_quote! {
                ::aether_core::forms::#function::<#vertex, #real, _, _>(#distribution, #rule)
            };
        } else if self.joint && delegate(expr).is_some() {
            // It is refused, and has no type: that alone is the error.
            *expr = parse_quote!(::aether_core::forms::stop());
        } else if let Some((name, call)) = form(expr) {
            let (real, vertex) = (self.real, self.vertex);
            let generics = match name.to_string().as_str() {
                "choose" | "draw" | "atom" => quote!(::<#real, _>),
                "delegate" => quote!(::<#vertex, _>),
                _ => TokenStream::new(),
            };
            let arguments = &call.args;
            *expr = parse_quote!(::aether_core::forms::#name #generics (#arguments));
        }
        true
    }
}

pub(super) fn names(fields: &[Field]) -> Vec<&Ident> {
    fields.iter().map(|field| &field.name).collect()
}

/// The struct, and `Clone` for it.
pub(super) fn structure(function: &ItemFn, signature: &Signature) -> TokenStream {
    let Signature { name, generics, fields, .. } = signature;
    let visibility = &function.vis;
    let (implementation, arguments, conditions) = generics.split_for_impl();
    let names = names(fields);
    let types: Vec<_> = fields.iter().map(|field| &field.ty).collect();
    let (marker, marker_type) = marker(signature);
    let marker_field = marker_type.map(|ty| quote!(#marker: #ty,));
    let marker_value = marker_field.as_ref().map(|_| quote!(#marker: ::core::marker::PhantomData,));
    let documentation = format!("The strategy that [`{}`](fn@{0}) returns.", function.sig.ident);
    let cloned = cloneable(signature);
    let conditions_and = and(conditions, &cloned);
    quote! {
        #[doc = #documentation]
        #visibility struct #name #generics #conditions { #(#names: #types,)* #marker_field }

        #[automatically_derived]
        #[allow(clippy::all, clippy::pedantic)]
        impl #implementation ::core::clone::Clone for #name #arguments #conditions_and {
            #[inline]
            fn clone(&self) -> Self {
                Self { #(#names: ::core::clone::Clone::clone(&self.#names),)* #marker_value }
            }
        }
    }
}

/// What cloning asks of the parameters: nothing of references.
pub(super) fn cloneable(signature: &Signature) -> Vec<TokenStream> {
    let owned = signature.fields.iter().map(|field| &field.ty).filter(|ty| !is_reference(ty));
    owned.map(|ty| quote!(#ty: ::core::clone::Clone)).collect()
}

pub(super) fn is_reference(ty: &Type) -> bool {
    matches!(ty, Type::Reference(reference) if reference.mutability.is_none())
}

pub(super) fn and(conditions: Option<&syn::WhereClause>, more: &[TokenStream]) -> TokenStream {
    let given = conditions.map(|clause| {
        let predicates = clause.predicates.iter();
        quote!(#(#predicates,)*)
    });
    quote!(where #given #(#more,)*)
}

/// The field that stands for generics which no parameter mentions.
fn marker(signature: &Signature) -> (Ident, Option<TokenStream>) {
    let mut name = "marker".to_owned();
    while signature.fields.iter().any(|field| field.name == name) {
        name.push('_');
    }
    let unused = signature.unused.iter().map(|parameter| match parameter {
        GenericParam::Lifetime(parameter) => {
            let lifetime = &parameter.lifetime;
            quote!(&#lifetime ())
        }
        GenericParam::Type(parameter) => parameter.ident.to_token_stream(),
        GenericParam::Const(_) => TokenStream::new(),
    });
    let unused: Vec<_> = unused.collect();
    let ty =
        (!unused.is_empty()).then(|| quote!(::core::marker::PhantomData<fn() -> (#(#unused,)*)>));
    (Ident::new(&name, Span::mixed_site()), ty)
}

pub(super) fn constructor(
    function: &ItemFn,
    signature: &Signature,
    documentation: &str,
) -> TokenStream {
    let Signature { name, generics, fields, .. } = signature;
    let (visibility, ident) = (&function.vis, &function.sig.ident);
    let (_, arguments, conditions) = generics.split_for_impl();
    let attributes = function.attrs.iter().filter(|attribute| !is_lint(attribute));
    let names = names(fields);
    let types = fields.iter().map(|field| &field.ty);
    let (marker, marker_type) = marker(signature);
    let marker = marker_type.map(|_| quote!(#marker: ::core::marker::PhantomData));
    quote! {
        #(#attributes)*
        #[doc = #documentation]
        #[must_use]
        #[allow(clippy::all, clippy::pedantic)]
        #visibility fn #ident #generics (#(#names: #types),*) -> #name #arguments #conditions {
            #name { #(#names,)* #marker }
        }
    }
}
