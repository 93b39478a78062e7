//! What a user sees of an item: the struct and its constructor, and his own function, hidden.

use proc_macro2::{Ident, Literal, TokenStream};
use quote::{ToTokens, quote, quote_spanned};
use syn::{Attribute, FnArg, ItemFn};

use super::legal::legal;
use crate::parse::{
    Constant, Constants, Domain, Options, Param, ParamKind, Signature, is_number,
    is_of_the_language, type_name,
};
use crate::points::Kind;
use crate::walk::{self, Bound, Look};

/// The struct and its constructor, which computes the constants and moves some parameters beside zero.
pub fn interface(
    item: &ItemFn,
    signature: &Signature,
    options: &Options,
    (constants, moved): (&Constants, &[&Ident]),
    docs: &TokenStream,
) -> TokenStream {
    let vis = &item.vis;
    let name = &signature.name;
    let ty = type_name(name);
    let user_docs: Vec<&Attribute> =
        item.attrs.iter().filter(|a| a.path().is_ident("doc")).collect();
    let other: Vec<&Attribute> = item.attrs.iter().filter(|a| !a.path().is_ident("doc")).collect();
    let names: Vec<&Ident> = signature.params.iter().map(|p| &p.name).collect();
    let types: Vec<TokenStream> =
        signature.params.iter().map(|p| param_type(p.kind.clone())).collect();
    let kept_types = signature.params.iter().map(|p| field_type(&p.kind));
    let kept: Vec<TokenStream> = signature.params.iter().filter_map(kept).collect();
    let generic = signature.params.iter().any(|p| p.kind.is_real()) || !constants.all.is_empty();
    let (bounds, default, args) = if generic {
        (quote!(<R: ::aether_core::Real>), quote!(<R: ::aether_core::Real = f64>), quote!(<R>))
    } else {
        (quote!(), quote!(), quote!())
    };
    let hidden: Vec<&Ident> = constants.fields().collect();
    let plain: Vec<TokenStream> = signature.params.iter().filter_map(in_double).collect();
    let compute = compute(constants, &plain);
    let asked = constants.all.iter().filter_map(|c| Some((c.domain.as_ref()?, &c.fields[0])));
    let lanes = if generic { quote!(R) } else { quote!(f64) };
    let asked: Vec<TokenStream> =
        asked.map(|(d, field)| in_domain(d, field, (name, &lanes))).collect();
    let is_integer = |d: &Domain| {
        let is_it = |p: &Param| p.name == d.name && matches!(p.kind, ParamKind::Integer(_));
        signature.params.iter().any(is_it)
    };
    let double = quote!(f64);
    let checks: Vec<TokenStream> = options
        .domains
        .iter()
        .map(|d| in_domain(d, &d.name, (name, if is_integer(d) { &double } else { &lanes })))
        .chain(options.relations.iter().map(|r| {
            let (comparison, text, item_name) = (&r.comparison, &r.text, name.to_string());
            let left = &comparison.left;
            let whole = signature.params.iter().any(|p| matches!(p.kind, ParamKind::Integer(_)));
            let left = if whole { quote!((#left) as f64) } else { quote!(#left) };
            quote! {
                #[allow(unused)]
                for lane in 0..<#lanes as ::aether_core::Real>::LANES {
                    use ::aether_core::Real as _;
                    #(#plain)*
                    if !(#comparison) {
                        return ::core::result::Result::Err(::aether_core::DomainError { item: #item_name, requirement: #text, value: #left });
                    }
                }
            }
        }))
        .collect();
    let make = quote!(#ty { #(#names,)* #(#hidden),* });
    let total = checks.is_empty() && asked.is_empty();
    let (returns, result) = if total {
        (quote!(#ty #args), make)
    } else {
        (
            quote!(::core::result::Result<#ty #args, ::aether_core::DomainError>),
            quote!(::core::result::Result::Ok(#make)),
        )
    };
    let errors = if total {
        quote!()
    } else {
        quote!(#[doc = "\n# Errors\n\nIf a parameter lies outside its declared domain."])
    };
    let legal = legal(signature, options, generic, !total);
    let struct_doc = format!("The random variable or map that [`{name}`] constructs.");
    quote! {
        #[doc = #struct_doc]
        #[derive(Clone, Copy, Debug)]
        #vis struct #ty #default { #(#names: #kept_types,)* #(#hidden: R),* }

        #(#user_docs)*
        #docs
        #errors
        #(#other)*
        #[allow(clippy::too_many_arguments, clippy::manual_range_contains, clippy::approx_constant)]
        #vis fn #name #bounds (#(#names: #types),*) -> #returns {
            #(#kept)*
            #(#checks)*
            #compute
            #(#asked)*
            #(let #moved = ::aether_core::support::beside_zero(#moved);)*
            #result
        }

        #legal
    }
}

/// Computes the constants, from parameters in `f64` (`plain`) by the body's own bindings.
fn compute(constants: &Constants, plain: &[TokenStream]) -> TokenStream {
    if constants.all.is_empty() {
        return quote!();
    }
    let (fields, lets) = (constants.fields(), &constants.lets);
    let kept = constants.all.iter().filter(|constant| !constant.fields.is_empty());
    let numbers = kept.map(|Constant { code, kind, .. }| match kind {
        Kind::Vector(2) => quote!({ let v = #code; [v.x, v.y] }),
        Kind::Vector(_) | Kind::Direction => quote!({ let v = #code; [v.x, v.y, v.z] }),
        _ => quote!([#code]),
    });
    let count = constants.fields().count();
    quote! {
        let mut __constants = [R::ZERO; #count];
        for lane in 0..<R as ::aether_core::Real>::LANES {
            // The names of the body are its own.
            #[allow(unused, clippy::all)]
            let numbers = {
                use ::aether_core::{Real as _, forms::precomputed, prelude::*};
                #(#plain)*
                #(#lets)*
                let each: [&[f64]; _] = [#(&#numbers),*];
                let mut all = [0.0_f64; #count];
                all.iter_mut().zip(each.into_iter().flatten()).for_each(|(to, from)| *to = *from);
                all
            };
            for (all, number) in __constants.iter_mut().zip(numbers) {
                *all = ::aether_core::Real::with_lane(*all, lane, R::Lane::of(number));
            }
        }
        let [#(#fields),*] = __constants;
    }
}

/// Asks for a number to lie in the domain that is declared of it.
fn in_domain(d: &Domain, field: &Ident, (item, lanes): (&Ident, &TokenStream)) -> TokenStream {
    let (text, item) = (&d.text, item.to_string());
    let (lo, hi) = (bound(d.interval.lo), bound(d.interval.hi));
    let upper = if d.closed { quote!(<=) } else { quote!(<) };
    let whole = d.whole.then(|| quote!(&&value % 1.0 == 0.0));
    let error = quote! {
        return ::core::result::Result::Err(::aether_core::DomainError { item: #item, requirement: #text, value });
    };
    // 0.99 in single precision is larger than 0.99: what is an end but for rounding is within.
    let rounded = |end: f64| end.is_finite() && f64::from(end as f32) != end;
    let mends = !d.whole && (rounded(d.interval.lo) || d.closed && rounded(d.interval.hi));
    let (given, outside) = if mends {
        let highest = if d.closed { hi.clone() } else { quote!(f64::NAN) };
        let inner = quote! {
            let own = ::aether_core::Real::lane(#field, lane);
            match ::aether_core::support::rounded_end(own, [#lo, #highest]) {
                ::core::option::Option::Some(inner) => {
                    #field = ::aether_core::Real::with_lane(#field, lane, inner);
                }
                ::core::option::Option::None => { #error }
            }
        };
        (quote!(let mut #field = #field;), inner)
    } else {
        (quote!(), error)
    };
    quote! {
        #given
        for lane in 0..<#lanes as ::aether_core::Real>::LANES {
            let value = ::aether_core::Real::to_f64(::aether_core::Real::lane(#field, lane));
            if !(value >= #lo && value #upper #hi #whole) {
                #outside
            }
        }
    }
}

/// A lane of a parameter in `f64` under its own name, for expressions in plain Rust.
fn in_double(p: &Param) -> Option<TokenStream> {
    let name = &p.name;
    let double = |v: TokenStream| quote!(#v.lane(lane).to_f64());
    let vector = |v: TokenStream| {
        let [x, y, z] = [quote!(x), quote!(y), quote!(z)].map(|c| double(quote!(#v.#c)));
        quote!(::aether_core::Vec3::new(#x, #y, #z))
    };
    let value = match p.kind {
        ParamKind::Scalar => double(quote!(#name)),
        ParamKind::Vec2 => {
            let [x, y] = [quote!(x), quote!(y)].map(|c| double(quote!(#name.#c)));
            quote!(::aether_core::Vec2::new(#x, #y))
        }
        ParamKind::Vec3 => vector(quote!(#name)),
        ParamKind::Direction => {
            let v = vector(quote!(#name));
            quote!(::aether_core::Direction::from_unit(#v))
        }
        ParamKind::Mat3 => {
            let columns = [quote!(#name.x), quote!(#name.y), quote!(#name.z)].map(vector);
            quote!(::aether_core::Mat3::from_cols(#(#columns),*))
        }
        ParamKind::Frame => {
            let columns = [quote!(#name.x), quote!(#name.y), quote!(#name.z)].map(vector);
            quote!(::aether_core::Frame::from_unit_axes(#(#columns),*))
        }
        ParamKind::Integer(_) | ParamKind::Flag => given(&p.kind, quote!(#name)),
        ParamKind::Array(_) => quote!(#name.map(|number| number.lane(lane).to_f64())),
        ParamKind::Identity => return None,
    };
    Some(quote!(let #name = #value;))
}

pub(super) fn bound(x: f64) -> TokenStream {
    if x == f64::INFINITY {
        quote!(f64::INFINITY)
    } else if x == f64::NEG_INFINITY {
        quote!(f64::NEG_INFINITY)
    } else if x < 0.0 {
        let l = Literal::f64_suffixed(-x);
        quote!(-#l)
    } else {
        let l = Literal::f64_suffixed(x);
        quote!(#l)
    }
}

/// The type of a field.
fn field_type(kind: &ParamKind) -> TokenStream {
    match kind {
        ParamKind::Integer(_) | ParamKind::Flag => quote!(f64),
        kind => param_type(kind.clone()),
    }
}

/// What a parameter is kept as, under its own name.
fn kept(p: &Param) -> Option<TokenStream> {
    let name = &p.name;
    match p.kind {
        ParamKind::Integer(_) => Some(quote!(let #name = #name as f64;)),
        ParamKind::Flag => Some(quote!(let #name = f64::from(#name);)),
        _ => None,
    }
}

/// What a field was given as.
pub(super) fn given(kind: &ParamKind, field: TokenStream) -> TokenStream {
    match kind {
        ParamKind::Integer(ty) => {
            let ty = Ident::new(ty, proc_macro2::Span::call_site());
            quote!((#field as #ty))
        }
        ParamKind::Flag => quote!((#field != 0.0)),
        _ => field,
    }
}

fn param_type(kind: ParamKind) -> TokenStream {
    match kind {
        ParamKind::Integer(ty) => {
            let ty = Ident::new(ty, proc_macro2::Span::call_site());
            quote!(#ty)
        }
        ParamKind::Flag => quote!(bool),
        ParamKind::Array(n) => quote!([R; #n]),
        ParamKind::Scalar => quote!(R),
        ParamKind::Vec2 => quote!(::aether_core::Vec2<R>),
        ParamKind::Vec3 => quote!(::aether_core::Vec3<R>),
        ParamKind::Mat3 => quote!(::aether_core::Mat3<R>),
        ParamKind::Frame => quote!(::aether_core::Frame<R>),
        ParamKind::Direction => quote!(::aether_core::Direction<R>),
        ParamKind::Identity => quote!(::aether_core::SurfaceId),
    }
}

/// The user's function under another name: rustc checks its types, and editors complete in it.
pub fn hidden_body(item: &ItemFn) -> TokenStream {
    hidden_body_with(item, &item.block.to_token_stream())
}

/// [`hidden_body`] with the tokens of a body that need not be Rust yet.
pub fn hidden_body_with(item: &ItemFn, block: &TokenStream) -> TokenStream {
    let inputs = &item.sig.inputs;
    let output = &item.sig.output;
    let (generics, conditions) = (&item.sig.generics, &item.sig.generics.where_clause);
    let own = own_names(item);
    quote! {
        #own

        #[allow(unused, clippy::all)]
        fn body #generics (#inputs) #output #conditions {
            #[allow(unused_imports)]
            use ::aether_core::prelude::*;
            #[allow(unused_imports)]
            use ::aether_core::forms::{precomputed, require};
            #block
        }
    }
}

/// Looks whether the names of numbers and functions that the language knows and a body mentions mean something else around the
/// item: a `const PI` of the user's would otherwise be the language's within the body, and nobody would know.
///
/// Numbers are compared, as they may be of another precision there. A function is ambiguous unless it is the same.
fn own_names(item: &ItemFn) -> TokenStream {
    let mut names = Names::default();
    walk::block(&mut names, &item.block);
    let mut bound = Bound::default();
    walk::block(&mut bound, &item.block);
    for input in &item.sig.inputs {
        if let FnArg::Typed(input) = input {
            walk::pat(&mut bound, &input.pat);
        }
    }
    names.0.retain(|name| !bound.0.iter().any(|bound| name == bound));
    let (numbers, functions): (Vec<_>, Vec<_>) =
        names.0.into_iter().partition(|name| is_number(&name.to_string()));
    let functions = (!functions.is_empty()).then(|| {
        quote! {
            #[allow(unused_imports)]
            #[deny(ambiguous_glob_imports)]
            mod functions_of_the_language {
                use super::*;
                use ::aether_core::{forms::{precomputed, require}, prelude::*};
                use self::{#(#functions as _),*};
            }
        }
    });
    let comparisons = numbers.iter().map(|name| {
        let message = format!(
            "`{name}` is another number around this item than in its body, where it is that of \
             `std::f64::consts`: give yours another name, or pass it as a parameter"
        );
        let at = name.span();
        quote_spanned! {at=>
            ::core::assert!(
                ::aether_core::support::is_about(#name as f64, ::core::f64::consts::#name),
                #message
            );
        }
    });
    let compared = (!numbers.is_empty()).then(|| {
        quote! {
            #[allow(unused_imports, clippy::all)]
            mod numbers_of_the_language {
                use ::core::f64::consts::*;
                const _: () = {
                    // What is not found here is that of the module.
                    use super::*;
                    #(#comparisons)*
                };
            }
        }
    });
    quote!(#functions #compared)
}

/// Names of the language that stand alone, each once.
#[derive(Default)]
struct Names(Vec<Ident>);

impl Look for Names {
    fn path(&mut self, path: &syn::ExprPath) -> bool {
        if let Some(name) = path.path.get_ident()
            && is_of_the_language(&name.to_string())
            && !self.0.contains(name)
        {
            self.0.push(name.clone());
        }
        false
    }
}
