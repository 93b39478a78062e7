//! The signature of a sampler or a map: names, parameters, spaces.

use proc_macro2::Ident;
use syn::{FnArg, ItemFn, Pat, ReturnType, Type};

use super::param::{Param, param};
use super::space::{Space, argument_of, optional, space};
use crate::diagnostics::Diagnostics;

/// Where a point comes from.
#[derive(Clone, Debug)]
pub enum Source {
    /// A sampler: this many uniforms.
    Uniforms {
        /// Name of the array.
        name: String,
        /// Its length.
        count: usize,
    },
    /// A map: a point of a space.
    Point {
        /// Name of the argument.
        name: String,
        /// Its space.
        space: Space,
    },
}

/// The signature.
#[derive(Clone, Debug)]
pub struct Signature {
    /// The function's name.
    pub name: Ident,
    /// Uniforms or argument.
    pub source: Source,
    /// Everything else.
    pub params: Vec<Param>,
    /// Where the result lives.
    pub space: Space,
    /// Whether its distribution has atoms.
    pub mixed: bool,
}

/// The type that a function makes: cosine_hemisphere to CosineHemisphere.
pub fn type_name(name: &Ident) -> Ident {
    let text: String = name
        .to_string()
        .trim_start_matches("r#")
        .split('_')
        .map(|w| {
            let mut c = w.chars();
            c.next().map_or(String::new(), |f| f.to_uppercase().chain(c).collect())
        })
        .collect();
    // `_1` and `__` have nothing that a name can begin with.
    let is_name = text.starts_with(|first: char| first.is_alphabetic());
    let text = if is_name { text } else { format!("Item{text}") };
    Ident::new(&text, name.span())
}

/// Names that derived code uses without a path.
const TAKEN: [&str; 8] = ["R", "Real", "Mask", "Single", "Option", "Fn", "FnMut", "Self"];

/// The most numbers that parameters are, with what an item computes of them once.
pub const MOST_NUMBERS: u8 = 64;

/// Reads the signature; `sampler` tells which attribute it is. `None` if there were errors.
pub fn signature(item: &ItemFn, sampler: bool, errors: &mut Diagnostics) -> Option<Signature> {
    let before = errors.len();
    let sig = &item.sig;
    qualifiers(sig, errors);
    generics(sig, errors)?;
    let mut inputs = sig.inputs.iter();
    let source = first_input(item, inputs.next(), sampler, errors);
    if sig.receiver().is_some() {
        return None;
    }
    let mut params = Vec::new();
    for input in inputs {
        params.extend(param(input, errors));
    }
    let ty = type_name(&sig.ident).to_string();
    if TAKEN.contains(&ty.as_str()) {
        errors.error(
            &sig.ident,
            format!("`fn {}` makes a type `{ty}`, and derived code has something else of that name: call the function otherwise", sig.ident),
        );
        return None;
    }
    let numbers: usize = params.iter().map(|p| p.kind.numbers()).sum();
    if numbers > usize::from(MOST_NUMBERS) {
        errors.error(
            &sig.inputs,
            format!("these parameters are {numbers} numbers, and up to {MOST_NUMBERS} are possible: sample from a table, as `Cdf` and `EnvironmentMap` do, or pass what the formula needs of them"),
        );
    }
    let result = result(sig, sampler, errors);
    let (source, (space, mixed)) = source.zip(result)?;
    if let Source::Uniforms { count, .. } = &source {
        check_dimensions(item, *count, &space, errors);
    }
    (errors.len() == before).then(|| Signature {
        name: sig.ident.clone(),
        source,
        params,
        space,
        mixed,
    })
}

/// Refuses what is generic.
fn generics(sig: &syn::Signature, errors: &mut Diagnostics) -> Option<()> {
    if sig.generics.params.is_empty() {
        return Some(());
    }
    let lifetimes =
        sig.generics.type_params().next().is_none() && sig.generics.const_params().next().is_none();
    errors.error(&sig.generics, if lifetimes {
        "points and parameters are values, small ones, so there is nothing to borrow: leave the lifetimes and references away"
    } else {
        "a sampler or map is generic over its number type by itself: write `f64` and leave the generics away"
    });
    None
}

/// The space of the result, and whether its distribution has atoms.
fn result(sig: &syn::Signature, sampler: bool, errors: &mut Diagnostics) -> Option<(Space, bool)> {
    let ReturnType::Type(_, ty) = &sig.output else {
        errors.error(&sig.ident, "the return type names the space of the result: add one of `-> f64`, `-> Vec2`, `-> Vec3`, `-> Direction`, `-> Surface`, `-> Curve`, `-> SurfacePoint`");
        return None;
    };
    let ty = optional(ty).unwrap_or(ty);
    let mixed = last_segment(ty).is_some_and(|name| name == "Mixed");
    if mixed && !sampler {
        errors.error(
            ty,
            "a map takes points to points, and only a sampler draws atoms: return the space itself",
        );
    }
    let space = match argument_of(ty, "Mixed") {
        Some(inner) => space(inner, errors),
        // The line, as `Mixed` has it for a default.
        None if mixed => Some(Space::Line),
        None => space(ty, errors),
    };
    space.map(|space| (space, mixed))
}

/// Only a plain `fn` can be evaluated in all the ways that the compiler derives.
fn qualifiers(sig: &syn::Signature, errors: &mut Diagnostics) {
    let mut refuse = |tokens: proc_macro2::TokenStream, word: &str| {
        errors.error(tokens, format!("a sampler or map cannot be `{word}`: its body is read as mathematics, and the code that runs is derived from it. Write a plain `fn`"));
    };
    if let Some(token) = &sig.asyncness {
        refuse(quote::quote!(#token), "async");
    }
    if let Some(token) = &sig.constness {
        refuse(quote::quote!(#token), "const");
    }
    if let syn::Safety::Unsafe(token) = &sig.safety {
        refuse(quote::quote!(#token), "unsafe");
    }
    if let Some(abi) = &sig.abi {
        refuse(quote::quote!(#abi), "extern");
    }
}

fn check_dimensions(item: &ItemFn, count: usize, space: &Space, errors: &mut Diagnostics) {
    let (k, n) = space.dimensions();
    let output = &item.sig.output;
    let uniforms = if count == 1 { "one uniform".to_owned() } else { format!("{count} uniforms") };
    if count > k {
        errors.error(output, format!("{uniforms} for a space of dimension {k}: many choices of them lead to the same point, so that its density is a marginal, an integral over the surplus ones, and has no formula. Use {k} (a discrete choice can take what it needs from one of them, with a branch), or return what the others determine too, as a tuple"));
    }
    if count < k {
        let way = if n == 3 && count == 2 {
            "return `Surface` (a surface in space) or `Direction`"
        } else if count == 1 {
            "return `Curve` (a curve in space)"
        } else {
            "return a space of lower dimension"
        };
        errors.error(output, format!("{uniforms} cannot fill a space of dimension {k}: the rank of the Jacobian is below it and there is no density. To sample a lower-dimensional set, {way}. Single points are atoms, with a probability instead of a density: a `#[strategy]` chooses among them"));
    }
}

fn first_input(
    item: &ItemFn,
    input: Option<&FnArg>,
    sampler: bool,
    errors: &mut Diagnostics,
) -> Option<Source> {
    let expected = if sampler {
        "the first parameter of a sampler is its uniforms: `u: [Uniform; 2]`"
    } else {
        "the first parameter of a map is the point that it is applied to, such as `w: Direction`"
    };
    let p = match input {
        Some(FnArg::Typed(p)) => p,
        Some(FnArg::Receiver(own)) => {
            errors.error(own, "a sampler or map is a free function: it has no `self`. Take the numbers that it needs of `self` as parameters, and move it out of the `impl`");
            return None;
        }
        None => {
            errors.error(&item.sig.ident, expected);
            return None;
        }
    };
    let Pat::Ident(name) = &*p.pat else {
        errors.error(
            &p.pat,
            "give this parameter a plain name, and take it apart in the body: `let [a, b] = u;`",
        );
        return None;
    };
    let name = name.ident.to_string();
    if !sampler {
        let space = space(&p.ty, errors)?;
        if let Space::Joint(_) = space {
            errors.error(&p.ty, "a map takes one point to another, and several points together have no map yet: sample them together by one `#[sampler]` that returns a tuple, or map each by itself");
            return None;
        }
        if matches!(space, Space::SurfacePoint | Space::Embedded { .. }) {
            errors.error(&p.ty, "maps of surface points are not supported: a surface's tangent plane is not known from the point alone. Map from a `Direction`, `f64`, `Vec2` or `Vec3`");
            return None;
        }
        return Some(Source::Point { name, space });
    }
    match uniforms(&p.ty) {
        Some(count @ 1..=MAX_UNIFORMS) => Some(Source::Uniforms { name, count }),
        Some(_) => {
            errors.error(&p.ty, "a sampler takes one to sixteen uniforms");
            None
        }
        None => {
            let array = matches!(&*p.ty, Type::Array(_) | Type::Reference(_) | Type::Slice(_));
            let message = if array {
                "the number of uniforms is the number of unknowns, which must be known here: write it as a literal, `u: [Uniform; 2]`"
            } else {
                expected
            };
            errors.error(&p.ty, message);
            None
        }
    }
}

fn uniforms(ty: &Type) -> Option<usize> {
    array_of(ty, "Uniform")
}

/// The length of an array of a type, as a literal.
pub(super) fn array_of(ty: &Type, name: &str) -> Option<usize> {
    match ty {
        Type::Array(a) if last_segment(&a.elem).is_some_and(|s| s == name) => match &a.len {
            syn::Expr::Lit(l) => match &l.lit {
                syn::Lit::Int(i) => i.base10_parse().ok(),
                _ => None,
            },
            _ => None,
        },
        _ => None,
    }
}

/// The most uniforms: those of eight points on surfaces.
const MAX_UNIFORMS: usize = 16;

pub(super) fn last_segment(ty: &Type) -> Option<String> {
    match ty {
        Type::Path(p) => p.path.segments.last().map(|s| s.ident.to_string()),
        Type::Paren(p) => last_segment(&p.elem),
        Type::Group(p) => last_segment(&p.elem),
        _ => None,
    }
}
