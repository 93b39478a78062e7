//! The signature of a strategy, and the struct that holds its parameters.

use std::collections::BTreeSet;

use proc_macro2::Span;
use quote::{ToTokens, format_ident};
use syn::visit_mut::{self, VisitMut};
use syn::{
    Expr, FnArg, GenericParam, Generics, Ident, ItemFn, Lifetime, Lit, Pat, ReturnType, Safety,
    Type, TypeReference, parse_quote,
};

use super::misuse;
use super::names::{FORMS, each_ident};
use crate::diagnostics::Diagnostics;
use crate::parse::type_name;

/// The most vertices that one draw yields.
const MOST_VERTICES: usize = 8;

/// What the signature says.
pub struct Signature {
    /// The struct's name: the function's in camel case.
    pub name: Ident,
    /// The name of the path parameter.
    pub path: Ident,
    /// Whether the path is taken by reference.
    pub path_by_reference: bool,
    /// The type of the path's vertices.
    pub vertex: Type,
    /// What a draw yields: the vertex type, or an array of it.
    pub yields: Type,
    /// How many vertices that are.
    pub count: usize,
    /// Generics of the struct: those of the function, elided lifetimes named, `impl Trait` too.
    pub generics: Generics,
    /// Generics that only the path or the vertex mention.
    pub unused: Vec<GenericParam>,
    /// The parameters after the path.
    pub fields: Vec<Field>,
}

/// A parameter after the path.
pub struct Field {
    /// Its name.
    pub name: Ident,
    /// Whether the body may change its copy.
    pub mutable: bool,
    /// Its type, without elided lifetimes.
    pub ty: Type,
}

/// Reads a signature; `None` after errors that leave nothing to go on with.
pub fn signature(item: &ItemFn, diagnostics: &mut Diagnostics) -> Option<Signature> {
    qualifiers(item, diagnostics);
    let yields = match &item.sig.output {
        ReturnType::Type(_, ty) => yields(ty, diagnostics),
        ReturnType::Default => {
            diagnostics.error(
                &item.sig.ident,
                "a strategy yields the next vertex of a path: write its type, `-> Vertex` (or `-> \
                 [Vertex; 2]` for two vertices of one draw)",
            );
            None
        }
    };
    if let Some(receiver) = item.sig.receiver() {
        diagnostics.error(
            receiver,
            "a strategy is a function, not a method: take the path first, \
             `path: &PathView<Vertex>`, and what it needs of `self` as parameters after it",
        );
        return None;
    }
    let mut inputs = item.sig.inputs.iter();
    let path = inputs.next().and_then(path_parameter);
    let Some((path, path_by_reference)) = path else {
        let message = "a strategy takes the path so far as its first parameter, \
                       `path: &PathView<Vertex>`";
        match item.sig.inputs.first() {
            Some(first) => diagnostics.error(first, message),
            None => diagnostics.error(&item.sig.ident, message),
        }
        return None;
    };
    let mut generics = item.sig.generics.clone();
    let mut fields = Vec::new();
    for input in inputs {
        if let FnArg::Typed(input) = input {
            fields.extend(field(input, &mut generics, diagnostics));
        }
    }
    let unused = unused(&generics, &fields);
    let name = type_name(&item.sig.ident);
    let (vertex, yields, count) = yields?;
    Some(Signature {
        name,
        path,
        path_by_reference,
        vertex,
        yields,
        count,
        generics,
        unused,
        fields,
    })
}

/// The type of a vertex, that of the result, and how many vertices it holds.
fn yields(ty: &Type, diagnostics: &mut Diagnostics) -> Option<(Type, Type, usize)> {
    let message = match ty {
        Type::Array(array) => match literal(&array.len) {
            Some(count @ 2..=MOST_VERTICES) => {
                return Some(((*array.elem).clone(), ty.clone(), count));
            }
            _ => {
                "how many vertices one draw yields is written as a number: `[Vertex; 2]` to \
                  `[Vertex; 8]`, or `Vertex` for one"
            }
        },
        Type::Tuple(tuple) if !tuple.elems.is_empty() => {
            "the vertices of a path have one type: for several vertices of one draw return an array, \
             `-> [Vertex; 2]`"
        }
        _ => return Some((ty.clone(), ty.clone(), 1)),
    };
    diagnostics.error(ty, message);
    None
}

fn literal(expr: &Expr) -> Option<usize> {
    let Expr::Lit(literal) = expr else { return None };
    let Lit::Int(number) = &literal.lit else { return None };
    number.base10_parse().ok()
}

fn qualifiers(item: &ItemFn, diagnostics: &mut Diagnostics) {
    let sig = &item.sig;
    let why = "a strategy is sampled and evaluated by generated code: write a plain `fn`";
    if let Some(token) = &sig.asyncness {
        diagnostics.error(token, format!("`async` strategy: {why}"));
    }
    if let Some(token) = &sig.constness {
        diagnostics.error(token, format!("`const` strategy: {why}"));
    }
    if let Safety::Unsafe(token) = &sig.safety {
        diagnostics.error(token, format!("`unsafe` strategy: {why}"));
    }
    if let Some(abi) = &sig.abi {
        diagnostics.error(abi, format!("`extern` strategy: {why}"));
    }
    if let Some(variadic) = &sig.variadic {
        diagnostics.error(variadic, format!("variable number of arguments: {why}"));
    }
    for form in FORMS.iter().filter(|form| sig.ident == form) {
        diagnostics.error(
            &sig.ident,
            format!("`{form}` is a special form: give the strategy another name"),
        );
    }
}

/// The name of the path parameter, and whether it is a reference.
fn path_parameter(input: &FnArg) -> Option<(Ident, bool)> {
    let FnArg::Typed(input) = input else { return None };
    let Pat::Ident(name) = &*input.pat else { return None };
    let (ty, by_reference) = match &*input.ty {
        Type::Reference(reference) => (&*reference.elem, true),
        other => (other, false),
    };
    let Type::Path(ty) = ty else { return None };
    let is_path = ty.path.segments.last().is_some_and(|last| last.ident == "PathView");
    is_path.then(|| (name.ident.clone(), by_reference))
}

fn field(
    input: &syn::PatType,
    generics: &mut Generics,
    diagnostics: &mut Diagnostics,
) -> Option<Field> {
    misuse::check_pattern(&input.pat, diagnostics);
    let Pat::Ident(pat) = &*input.pat else {
        diagnostics.error(
            &input.pat,
            "a parameter of a strategy has a plain name: take it apart in the body, with `let`",
        );
        return None;
    };
    let mut ty = (*input.ty).clone();
    if let Type::Reference(reference) = &ty
        && reference.mutability.is_some()
    {
        diagnostics.error(
            &ty,
            "a strategy is a pure function of its parameters: take `&` instead of `&mut`",
        );
    }
    let mut names = Naming { parameter: &pat.ident, generics, count: 0 };
    names.visit_type_mut(&mut ty);
    Some(Field { name: pat.ident.clone(), mutable: pat.mutability.is_some(), ty })
}

/// Gives names to elided lifetimes and to `impl Trait` types.
struct Naming<'g> {
    parameter: &'g Ident,
    generics: &'g mut Generics,
    count: usize,
}

impl Naming<'_> {
    fn lifetime(&mut self) -> Lifetime {
        self.count += 1;
        let suffix = if self.count == 1 { String::new() } else { format!("_{}", self.count) };
        let mut name = format!("'{}{suffix}", plain(self.parameter));
        while self.generics.lifetimes().any(|known| known.lifetime.to_string() == name) {
            name.push('_');
        }
        let lifetime = Lifetime::new(&name, Span::mixed_site());
        // Lifetimes come before types.
        let declared = self.generics.lifetimes().count();
        self.generics.params.insert(declared, parse_quote!(#lifetime));
        lifetime
    }
}

impl VisitMut for Naming<'_> {
    fn visit_type_reference_mut(&mut self, reference: &mut TypeReference) {
        if reference.lifetime.is_none() {
            reference.lifetime = Some(self.lifetime());
        }
        visit_mut::visit_type_reference_mut(self, reference);
    }
    fn visit_lifetime_mut(&mut self, lifetime: &mut Lifetime) {
        if lifetime.ident == "_" {
            *lifetime = self.lifetime();
        }
    }
    fn visit_type_mut(&mut self, ty: &mut Type) {
        if let Type::ImplTrait(opaque) = ty {
            self.count += 1;
            let name = format_ident!("{}{}", type_name(self.parameter), self.count);
            let bounds = &opaque.bounds;
            self.generics.params.push(parse_quote!(#name: #bounds));
            *ty = parse_quote!(#name);
        } else {
            visit_mut::visit_type_mut(self, ty);
        }
    }
    // The lifetimes of a function type are its own.
    fn visit_type_fn_ptr_mut(&mut self, _: &mut syn::TypeFnPtr) {}
    fn visit_parenthesized_generic_arguments_mut(
        &mut self,
        _: &mut syn::ParenthesizedGenericArguments,
    ) {
    }
}

/// The generics that no field mentions; constants may go unmentioned.
fn unused(generics: &Generics, fields: &[Field]) -> Vec<GenericParam> {
    let mut mentioned = BTreeSet::new();
    for field in fields {
        each_ident(field.ty.to_token_stream(), &mut |name| {
            mentioned.insert(name.to_string());
        });
    }
    let missing = |name: &Ident| !mentioned.contains(&name.to_string());
    let unused = generics.params.iter().filter(|parameter| match parameter {
        GenericParam::Lifetime(parameter) => missing(&parameter.lifetime.ident),
        GenericParam::Type(parameter) => missing(&parameter.ident),
        _ => false,
    });
    unused.cloned().collect()
}

fn plain(name: &Ident) -> String {
    let text = name.to_string();
    text.strip_prefix("r#").map_or(text.clone(), str::to_owned)
}
