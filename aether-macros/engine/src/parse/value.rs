//! What a name or an expression in a body stands for.

use proc_macro2::TokenStream;

use crate::expr::Id;
use crate::parse::{Mark, Space};

/// The value of an expression while a body is read.
#[derive(Clone, Debug)]
pub enum Value {
    /// A number.
    Scalar(Id),
    /// Two or three numbers.
    Vector(Vec<Id>),
    /// Three columns of three numbers.
    Matrix([Vec<Id>; 3]),
    /// The array of uniforms.
    Uniforms(Vec<Id>),
    /// A tuple.
    Tuple(Vec<Value>),
    /// A point of a space, by its constructor.
    Point(Space, Vec<Id>, Option<TokenStream>),
    /// A point of a distribution with atoms, and whether it lies on one.
    Mixed(Mark, Box<Value>),
    /// A truth value, on the way through the body that is being read.
    Bool(bool),
    /// No value: a branch without `else`.
    Unit,
    /// No sample: `None`.
    Nothing,
    /// Something that could not be read; an error has been reported.
    Unknown,
    /// Something that is only passed on, such as a surface's identity.
    Opaque(TokenStream),
}

impl Value {
    /// What to call it in an error text.
    pub fn describe(&self) -> &'static str {
        match self {
            Value::Scalar(_) => "a number",
            Value::Vector(_) => "a vector",
            Value::Matrix(_) => "a matrix",
            Value::Uniforms(_) => "the array of uniforms",
            Value::Tuple(_) => "a tuple",
            Value::Point(..) => "a point",
            Value::Mixed(..) => "a `Mixed` point",
            Value::Bool(_) => "a truth value",
            Value::Unit => "no value at all",
            Value::Nothing => "`None`",
            Value::Opaque(_) | Value::Unknown => "an opaque value",
        }
    }

    /// The coordinates of a vector or of a point that dereferences to one.
    pub fn vector(&self) -> Option<&[Id]> {
        match self {
            Value::Vector(v) | Value::Point(_, v, _) => Some(v),
            _ => None,
        }
    }
}
