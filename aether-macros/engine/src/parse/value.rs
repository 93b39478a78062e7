//! What a name or an expression in a body stands for.

use std::rc::Rc;

use proc_macro2::TokenStream;

use crate::expr::Id;
use crate::parse::{Callable, Mark, Space};

/// The value of an expression while a body is read.
#[derive(Clone, Debug)]
pub enum Value {
    /// A number.
    Scalar(Id),
    /// A number of an integer type.
    Integer(Id),
    /// Two or three numbers.
    Vector(Vec<Id>),
    /// Three columns of three numbers.
    Matrix([Vec<Id>; 3]),
    /// The array of uniforms.
    Uniforms(Vec<Id>),
    /// A tuple.
    Tuple(Vec<Value>),
    /// An array, or what goes through one or through a range of integers.
    List(Vec<Value>),
    /// A closure, or a function within the body.
    Callable(Rc<Callable>),
    /// A point of a space, by its constructor.
    Point(Space, Vec<Id>, Option<TokenStream>),
    /// A point of a distribution with atoms, and whether it lies on one.
    Mixed(Mark, Box<Value>),
    /// A parameter that is a truth value: one if it is true, zero if not.
    Flag(Id),
    /// A truth value, on the way through the body that is being read.
    Bool(bool),
    /// No value: a branch without `else`, or a name that has none yet.
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
            Value::Integer(_) => "an integer",
            Value::Vector(_) => "a vector",
            Value::Matrix(_) => "a matrix",
            Value::Uniforms(_) => "the array of uniforms",
            Value::Tuple(_) => "a tuple",
            Value::List(_) => "an array",
            Value::Callable(_) => "a function",
            Value::Point(..) => "a point",
            Value::Mixed(..) => "a `Mixed` point",
            Value::Bool(_) | Value::Flag(_) => "a truth value",
            Value::Unit => "no value at all",
            Value::Nothing => "`None`",
            Value::Opaque(_) | Value::Unknown => "an opaque value",
        }
    }

    /// The same, with an integer as any number.
    pub fn real(self) -> Value {
        match self {
            Value::Integer(id) => Value::Scalar(id),
            other => other,
        }
    }

    /// The elements of an array.
    pub fn elements(&self) -> Option<Vec<Value>> {
        match self {
            Value::List(values) => Some(values.clone()),
            Value::Uniforms(ids) => Some(ids.iter().map(|id| Value::Scalar(*id)).collect()),
            _ => None,
        }
    }

    /// The coordinates of a vector or of a point that dereferences to one.
    pub fn vector(&self) -> Option<&[Id]> {
        match self {
            Value::Vector(v) | Value::Point(_, v, _) => Some(v),
            _ => None,
        }
    }

    /// The number, or the coordinates of what has such.
    pub fn numbers(&self) -> Option<&[Id]> {
        match self {
            Value::Scalar(id) | Value::Integer(id) => Some(std::slice::from_ref(id)),
            other => other.vector(),
        }
    }
}
