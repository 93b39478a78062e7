//! The signature of a sampler or a map: names, parameters, spaces.

use proc_macro2::Ident;
use syn::{FnArg, GenericArgument, ItemFn, Pat, PathArguments, ReturnType, Type};

use super::whole::integer_type;
use crate::diagnostics::Diagnostics;
use crate::points::Kind;

/// The space of a result or of a map's argument.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Space {
    /// The real line.
    Line,
    /// The plane.
    Plane,
    /// Space, with volume.
    Volume,
    /// The unit sphere.
    Direction,
    /// A surface that the type identifies.
    SurfacePoint,
    /// A manifold of dimension `k` in R^`n` known only through the map.
    Embedded {
        /// Dimension of the manifold.
        k: usize,
        /// Dimension of the space around it.
        n: usize,
    },
    /// Several points at once, with the product of their measures.
    Joint(Vec<Space>),
}

impl Space {
    /// Dimension and number of coordinates.
    pub fn dimensions(&self) -> (usize, usize) {
        match self {
            Space::Line => (1, 1),
            Space::Plane => (2, 2),
            Space::Volume => (3, 3),
            Space::Direction | Space::SurfacePoint => (2, 3),
            Space::Embedded { k, n } => (*k, *n),
            Space::Joint(parts) => parts
                .iter()
                .map(Space::dimensions)
                .fold((0, 0), |(k, n), (dk, dn)| (k + dk, n + dn)),
        }
    }

    /// The points that make up a joint one; a space of single points is its own only part.
    pub fn parts(&self) -> Vec<Space> {
        if let Space::Joint(parts) = self { parts.clone() } else { vec![self.clone()] }
    }

    /// Coordinates and kind of a map's argument.
    pub fn argument(&self) -> (usize, Kind) {
        match self {
            Space::Line => (1, Kind::Vector(1)),
            Space::Plane => (2, Kind::Vector(2)),
            Space::Direction => (3, Kind::Direction),
            _ => (3, Kind::Vector(3)),
        }
    }

    /// The name of its measure.
    pub fn measure(&self) -> &'static str {
        match self {
            Space::Line | Space::Embedded { k: 1, .. } => "length",
            Space::Plane | Space::SurfacePoint | Space::Embedded { k: 2, .. } => "area",
            Space::Volume => "volume",
            Space::Direction => "solid angle",
            Space::Joint(_) => "product of the parts' measures",
            Space::Embedded { .. } => "Hausdorff measure",
        }
    }
}

/// What a parameter is.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum ParamKind {
    /// `f64`
    Scalar,
    /// `Vec2`
    Vec2,
    /// `Vec3`
    Vec3,
    /// `Mat3`
    Mat3,
    /// `Frame`
    Frame,
    /// `Direction`
    Direction,
    /// `SurfaceId`
    Identity,
    /// `u32` and other types of integers, by name.
    Integer(&'static str),
    /// `bool`
    Flag,
    /// `[f64; N]`
    Array(usize),
}

impl ParamKind {
    /// Whether it is made of numbers of the precision that whoever samples chooses.
    pub fn is_real(&self) -> bool {
        !matches!(self, ParamKind::Identity | ParamKind::Integer(_) | ParamKind::Flag)
    }

    /// Whether a domain may be declared of it.
    pub fn is_number(&self) -> bool {
        matches!(self, ParamKind::Scalar | ParamKind::Integer(_))
    }

    /// How many numbers it takes.
    pub fn numbers(&self) -> usize {
        match self {
            ParamKind::Scalar | ParamKind::Integer(_) | ParamKind::Flag => 1,
            ParamKind::Array(n) => *n,
            ParamKind::Vec2 => 2,
            ParamKind::Vec3 | ParamKind::Direction => 3,
            ParamKind::Mat3 | ParamKind::Frame => 9,
            ParamKind::Identity => 0,
        }
    }
}

/// A parameter.
#[derive(Clone, Debug)]
pub struct Param {
    /// Its name.
    pub name: Ident,
    /// Its type.
    pub kind: ParamKind,
}

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
    if !sig.generics.params.is_empty() {
        let lifetimes = sig.generics.type_params().next().is_none()
            && sig.generics.const_params().next().is_none();
        errors.error(&sig.generics, if lifetimes {
            "points and parameters are values, small ones, so there is nothing to borrow: leave the lifetimes and references away"
        } else {
            "a sampler or map is generic over its number type by itself: write `f64` and leave the generics away"
        });
        return None;
    }
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
    let mut mixed = false;
    let space = match &sig.output {
        ReturnType::Type(_, ty) => {
            let ty = optional(ty).unwrap_or(ty);
            mixed = last_segment(ty).is_some_and(|name| name == "Mixed");
            if mixed && !sampler {
                errors.error(ty, "a map takes points to points, and only a sampler draws atoms: return the space itself");
            }
            match argument_of(ty, "Mixed") {
                Some(inner) => space(inner, errors),
                // The line, as `Mixed` has it for a default.
                None if mixed => Some(Space::Line),
                None => space(ty, errors),
            }
        }
        ReturnType::Default => {
            errors.error(&sig.ident, "the return type names the space of the result: add one of `-> f64`, `-> Vec2`, `-> Vec3`, `-> Direction`, `-> Surface`, `-> Curve`, `-> SurfacePoint`");
            None
        }
    };
    let (Some(source), Some(space)) = (source, space) else { return None };
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
fn array_of(ty: &Type, name: &str) -> Option<usize> {
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

/// The types of parameters.
const PARAMETERS: [&str; 7] = ["f64", "Vec2", "Vec3", "Mat3", "Frame", "Direction", "SurfaceId"];

fn param(input: &FnArg, errors: &mut Diagnostics) -> Option<Param> {
    let FnArg::Typed(p) = input else {
        errors.error(input, "a sampler or map is a free function: it has no `self`");
        return None;
    };
    let Pat::Ident(name) = &*p.pat else {
        errors.error(&p.pat, "give this parameter a plain name: it is a field of the random variable. Several numbers are several parameters, or a `Vec2` or `Vec3`");
        return None;
    };
    if let Type::Reference(reference) = &*p.ty
        && PARAMETERS.iter().any(|t| last_segment(&reference.elem).is_some_and(|s| s == *t))
    {
        let ty = last_segment(&reference.elem).unwrap_or_default();
        errors.error(
            &p.ty,
            format!(
                "parameters are values, which the random variable keeps: write `{}: {ty}`",
                name.ident
            ),
        );
        return None;
    }
    if let Some(count) = array_of(&p.ty, "f64") {
        return Some(Param { name: name.ident.clone(), kind: ParamKind::Array(count) });
    }
    let ty = last_segment(&p.ty);
    if let Some(ty) = ty.as_deref().and_then(integer_type) {
        return Some(Param { name: name.ident.clone(), kind: ParamKind::Integer(ty) });
    }
    let kind = match ty.as_deref() {
        Some("bool") => ParamKind::Flag,
        Some("f64") => ParamKind::Scalar,
        Some("Vec2") => ParamKind::Vec2,
        Some("Vec3") => ParamKind::Vec3,
        Some("Mat3") => ParamKind::Mat3,
        Some("Frame") => ParamKind::Frame,
        Some("Direction") => ParamKind::Direction,
        Some("SurfaceId") => ParamKind::Identity,
        Some("f32") => {
            errors
                .error(&p.ty, "write `f64`: the emitted code is generic and runs in `f32` as well");
            return None;
        }
        Some("Uniform") => {
            errors.error(&p.ty, "uniforms come first and in one array: `u: [Uniform; 2]`");
            return None;
        }
        _ => {
            errors.error(&p.ty, "a parameter is one of `f64`, `[f64; N]` with a literal N, `Vec2`, `Vec3`, `Mat3`, `Frame`, `Direction`, `SurfaceId`, `bool`, `u32` and other integers; compute what you need from other types before, and pass the numbers");
            return None;
        }
    };
    Some(Param { name: name.ident.clone(), kind })
}

/// The most points of a tuple: as many as tuples are implemented for.
const MAX_POINTS: usize = 8;

/// The most coordinates of a result, for which there are bits in [`crate::expr::Deps`].
const MAX_COORDINATES: usize = 24;

/// The most dimensions of a manifold, for which the runtime has measures, and of the space that it lies in.
const MAX_EMBEDDED: usize = 4;
const MAX_AROUND: usize = 8;

/// The most uniforms: those of eight points on surfaces.
const MAX_UNIFORMS: usize = 16;

fn space(ty: &Type, errors: &mut Diagnostics) -> Option<Space> {
    if let Type::Tuple(tuple) = ty
        && (2..=MAX_POINTS).contains(&tuple.elems.len())
    {
        let parts: Vec<Option<Space>> = tuple.elems.iter().map(|t| space(t, errors)).collect();
        let joint = parts.into_iter().collect::<Option<Vec<Space>>>().map(Space::Joint)?;
        if joint.dimensions().1 > MAX_COORDINATES {
            errors.error(ty, format!("these points have more than {MAX_COORDINATES} coordinates together: sample fewer at once, each run given the one before, in a `#[strategy]`"));
            return None;
        }
        return Some(joint);
    }
    let found = match last_segment(ty).as_deref() {
        Some("f64") => Some(Space::Line),
        Some("Vec2") => Some(Space::Plane),
        Some("Vec3") => Some(Space::Volume),
        Some("Direction") => Some(Space::Direction),
        Some("SurfacePoint") => Some(Space::SurfacePoint),
        Some("Surface") => Some(Space::Embedded { k: 2, n: 3 }),
        Some("Curve") => Some(Space::Embedded { k: 1, n: 3 }),
        Some("Embedded") => {
            let found = embedded(ty);
            if found.is_none() {
                errors.error(ty, format!("the numbers of `Embedded<K, N>` are literals: a manifold of K dimensions, one to {MAX_EMBEDDED}, of points with N coordinates, K to {MAX_AROUND}. More numbers are several points, a tuple, or are sampled one given the others in a `#[strategy]`"));
            }
            return found;
        }
        _ => None,
    };
    if found.is_none() {
        errors.error(ty, "this type names no space: use one of `f64` (length), `Vec2` (area), `Vec3` (volume), `Direction` (solid angle), `Surface` and `SurfacePoint` (area), `Curve` (length), `Embedded<K, N>`");
    }
    found
}

/// `T` of `Option<T>`: a body that may yield no sample.
fn optional(ty: &Type) -> Option<&Type> {
    argument_of(ty, "Option")
}

/// `T` of `Name<T>`.
fn argument_of<'t>(ty: &'t Type, name: &str) -> Option<&'t Type> {
    let Type::Path(p) = ty else { return None };
    let last = p.path.segments.last().filter(|s| s.ident == name)?;
    let PathArguments::AngleBracketed(arguments) = &last.arguments else { return None };
    match arguments.args.first() {
        Some(GenericArgument::Type(inner)) => Some(inner),
        _ => None,
    }
}

fn embedded(ty: &Type) -> Option<Space> {
    let Type::Path(p) = ty else { return None };
    let PathArguments::AngleBracketed(a) = &p.path.segments.last()?.arguments else { return None };
    let numbers: Vec<usize> = a
        .args
        .iter()
        .filter_map(|a| match a {
            GenericArgument::Const(syn::Expr::Lit(l)) => match &l.lit {
                syn::Lit::Int(i) => i.base10_parse().ok(),
                _ => None,
            },
            _ => None,
        })
        .collect();
    match numbers[..] {
        [k, n] if (1..=MAX_EMBEDDED).contains(&k) && (k..=MAX_AROUND).contains(&n) => {
            Some(Space::Embedded { k, n })
        }
        _ => None,
    }
}

fn last_segment(ty: &Type) -> Option<String> {
    match ty {
        Type::Path(p) => p.path.segments.last().map(|s| s.ident.to_string()),
        Type::Paren(p) => last_segment(&p.elem),
        Type::Group(p) => last_segment(&p.elem),
        _ => None,
    }
}
