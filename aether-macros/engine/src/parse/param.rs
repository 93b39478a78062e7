//! Parameters: their names and types.

use proc_macro2::Ident;
use syn::{FnArg, Pat, Type};

use super::signature::{array_of, last_segment};
use super::whole::integer_type;
use crate::diagnostics::Diagnostics;

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

/// The types of parameters.
const PARAMETERS: [&str; 7] = ["f64", "Vec2", "Vec3", "Mat3", "Frame", "Direction", "SurfaceId"];

pub(super) fn param(input: &FnArg, errors: &mut Diagnostics) -> Option<Param> {
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
