//! The implementation of `Legal`: parameters and their domains as data.

use proc_macro2::TokenStream;
use quote::quote;

use super::interface::{bound, given};
use crate::parse::{Options, Param, ParamKind, Signature, type_name};

/// Implements `Legal` for an item. `generic` is whether its struct has a number type, `fallible`
/// whether its constructor returns a `Result`.
pub fn legal(
    signature: &Signature,
    options: &Options,
    generic: bool,
    fallible: bool,
) -> TokenStream {
    let name = &signature.name;
    let (ty, text) = (type_name(name), name.to_string());
    let (bounds, args, real) = if generic {
        (quote!(<R: ::aether_core::Scalar>), quote!(<R>), quote!(R))
    } else {
        (quote!(), quote!(), quote!(f64))
    };
    let parameters = signature.params.iter().flat_map(|p| parameters(p, options));
    let of_names = options.of_names.iter().map(|d| &d.text);
    let relations = options.relations.iter().map(|r| &r.text).chain(of_names);
    let values = signature.params.iter().map(|p| value(&p.kind));
    let make = quote!(#name(#(#values),*));
    let made = if fallible { make } else { quote!(::core::result::Result::Ok(#make)) };
    quote! {
        #[automatically_derived]
        #[allow(clippy::approx_constant)]
        impl #bounds ::aether_core::Legal for #ty #args {
            type Real = #real;
            const ITEM: &'static str = #text;
            const PARAMETERS: &'static [::aether_core::legal::Parameter] = &[#(#parameters),*];
            const RELATIONS: &'static [&'static str] = &[#(#relations),*];
            fn from_parameters(
                numbers: &[#real],
            ) -> ::core::result::Result<Self, ::aether_core::DomainError> {
                #[allow(unused_mut, unused_variables)]
                let mut __numbers = ::aether_core::legal::Numbers::of::<Self>(numbers)?;
                #made
            }
        }
    }
}

/// A parameter as data; an array as as many.
fn parameters(p: &Param, options: &Options) -> Vec<TokenStream> {
    let ParamKind::Array(n) = p.kind else {
        return vec![parameter(p, options, p.name.to_string())];
    };
    (0..n).map(|i| parameter(p, options, format!("{}[{i}]", p.name))).collect()
}

fn parameter(p: &Param, options: &Options, name: String) -> TokenStream {
    let kind = match p.kind {
        ParamKind::Scalar if options.domain(&name).is_some_and(|d| d.whole) => quote!(Whole),
        ParamKind::Scalar | ParamKind::Array(_) => quote!(Number),
        ParamKind::Integer(_) | ParamKind::Flag => quote!(Whole),
        ParamKind::Vec2 => quote!(Vec2),
        ParamKind::Vec3 => quote!(Vec3),
        ParamKind::Mat3 => quote!(Mat3),
        ParamKind::Frame => quote!(Frame),
        ParamKind::Direction => quote!(Direction),
        ParamKind::Identity => quote!(SurfaceId),
    };
    let domain = match options.domain(&name) {
        None if p.kind == ParamKind::Flag => {
            quote!(::core::option::Option::Some(::aether_core::legal::Domain {
                low: 0.0,
                high: 1.0,
                closed: true
            }))
        }
        // What nothing is declared of is drawn from small numbers, which every type has.
        None if matches!(p.kind, ParamKind::Integer(_)) => {
            quote!(::core::option::Option::Some(::aether_core::legal::Domain {
                low: 0.0,
                high: 100.0,
                closed: true
            }))
        }
        None => quote!(::core::option::Option::None),
        Some(d) => {
            let (low, high, closed) = (bound(d.interval.lo), bound(d.interval.hi), d.closed);
            quote!(::core::option::Option::Some(::aether_core::legal::Domain {
                low: #low, high: #high, closed: #closed
            }))
        }
    };
    quote!(::aether_core::legal::Parameter {
        name: #name, kind: ::aether_core::legal::ParameterKind::#kind, domain: #domain
    })
}

/// The next parameter from the numbers.
fn value(kind: &ParamKind) -> TokenStream {
    match kind {
        ParamKind::Scalar => quote!(__numbers.number()),
        ParamKind::Integer(_) | ParamKind::Flag => {
            given(kind, quote!(::aether_core::Real::to_f64(__numbers.number())))
        }
        ParamKind::Array(n) => {
            let numbers = (0..*n).map(|_| quote!(__numbers.number()));
            quote!([#(#numbers),*])
        }
        ParamKind::Vec2 => quote!(__numbers.vec2()),
        ParamKind::Vec3 => quote!(__numbers.vec3()),
        ParamKind::Mat3 => quote!(__numbers.mat3()),
        ParamKind::Frame => quote!(__numbers.frame()?),
        ParamKind::Direction => quote!(__numbers.direction()?),
        ParamKind::Identity => quote!(__numbers.surface_id()?),
    }
}
