//! Which parameters an item takes, as plain data, so that generators of tests can draw legal ones.

use crate::point::{Direction, SurfaceId};
use crate::real::Scalar;
use crate::sampler::DomainError;
use crate::vec::{Frame, Mat3, Vec2, Vec3};

/// What a parameter is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ParameterKind {
    /// A number.
    Number,
    /// A whole number.
    Whole,
    /// A vector of the plane.
    Vec2,
    /// A vector of space.
    Vec3,
    /// A unit vector.
    Direction,
    /// A matrix, by columns.
    Mat3,
    /// An orthonormal matrix, by columns.
    Frame,
    /// The identity of a surface, a whole number.
    SurfaceId,
}

impl ParameterKind {
    /// How many numbers it takes to write one down.
    pub const fn numbers(self) -> usize {
        match self {
            ParameterKind::Number | ParameterKind::Whole | ParameterKind::SurfaceId => 1,
            ParameterKind::Vec2 => 2,
            ParameterKind::Vec3 | ParameterKind::Direction => 3,
            ParameterKind::Mat3 | ParameterKind::Frame => 9,
        }
    }
}

/// The declared domain of a number: `low..=high`, or `low..high` if it is not closed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Domain {
    /// The lower end, which belongs to the domain; minus infinity if there is none.
    pub low: f64,
    /// The upper end; infinity if there is none.
    pub high: f64,
    /// Whether the upper end belongs to the domain.
    pub closed: bool,
}

impl Domain {
    /// Whether `x` lies in the domain; never for NaN.
    pub fn contains(&self, x: f64) -> bool {
        x >= self.low && if self.closed { x <= self.high } else { x < self.high }
    }
}

/// A parameter of an item.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Parameter {
    /// Its name.
    pub name: &'static str,
    /// What it is.
    pub kind: ParameterKind,
    /// Its domain, if one is declared.
    pub domain: Option<Domain>,
}

/// A sampler or map that can be made from numbers, and says which ones are legal. The attributes
/// `#[sampler]` and `#[map]` implement it.
///
/// ```
/// use aether_core::prelude::*;
/// use aether_core::Legal;
///
/// #[sampler(a in 0.0..=1.0, where a < b)]
/// fn between(u: [Uniform; 1], a: f64, b: f64) -> f64 {
///     a + (b - a) * u[0]
/// }
///
/// let [a, b] = Between::<f64>::PARAMETERS else { panic!("there are two") };
/// assert!(a.domain.unwrap().contains(1.0) && b.domain.is_none());
/// assert_eq!(Between::<f64>::RELATIONS, ["a < b"]);
/// assert!(Between::from_parameters(&[0.5, 2.0]).is_ok());
/// assert!(Between::from_parameters(&[0.5, 0.2]).is_err());
/// ```
pub trait Legal: Sized {
    /// The precision of the parameters; `f64` for items without any number among them.
    type Real: Scalar;
    /// The name of the function that was written.
    const ITEM: &'static str;
    /// The parameters, in order.
    const PARAMETERS: &'static [Parameter];
    /// The declared relations between them and the domains of what the body makes of them, as written.
    const RELATIONS: &'static [&'static str];

    /// The item with the numbers of its parameters, one after the other, vectors by coordinates and
    /// matrices by columns.
    ///
    /// # Errors
    /// If the numbers are not as many as the parameters have, a unit vector or a frame is none, or a
    /// domain or relation is violated.
    fn from_parameters(numbers: &[Self::Real]) -> Result<Self, DomainError>;
}

/// Takes parameters from a list of numbers; emitted code uses it.
#[doc(hidden)]
#[derive(Debug)]
pub struct Numbers<'a, R> {
    item: &'static str,
    rest: &'a [R],
}

impl<'a, R: Scalar> Numbers<'a, R> {
    /// The numbers of the parameters of `S`.
    pub fn of<S: Legal>(numbers: &'a [R]) -> Result<Self, DomainError> {
        let needed: usize = S::PARAMETERS.iter().map(|p| p.kind.numbers()).sum();
        let numbers = Numbers { item: S::ITEM, rest: numbers };
        if numbers.rest.len() == needed {
            Ok(numbers)
        } else {
            let value = numbers.rest.len() as f64;
            Err(numbers.refuse("as many numbers as the parameters have", value))
        }
    }

    fn refuse(&self, requirement: &'static str, value: f64) -> DomainError {
        DomainError { item: self.item, requirement, value }
    }

    /// The next number. Their count has been checked.
    pub fn number(&mut self) -> R {
        let Some((first, rest)) = self.rest.split_first() else { return R::ZERO };
        self.rest = rest;
        *first
    }

    /// The next two as a vector.
    pub fn vec2(&mut self) -> Vec2<R> {
        Vec2::new(self.number(), self.number())
    }

    /// The next three as a vector.
    pub fn vec3(&mut self) -> Vec3<R> {
        Vec3::new(self.number(), self.number(), self.number())
    }

    /// The next three as a unit vector.
    pub fn direction(&mut self) -> Result<Direction<R>, DomainError> {
        let v = self.vec3();
        Direction::try_new(v.x, v.y, v.z)
            .ok_or_else(|| self.refuse("a direction has length one", v.length().to_f64()))
    }

    /// The next nine as a matrix.
    pub fn mat3(&mut self) -> Mat3<R> {
        Mat3::from_cols(self.vec3(), self.vec3(), self.vec3())
    }

    /// The next nine as a frame.
    pub fn frame(&mut self) -> Result<Frame<R>, DomainError> {
        let m = self.mat3();
        Frame::try_from_axes(m.x, m.y, m.z).ok_or_else(|| {
            self.refuse("the axes of a frame are orthonormal", m.x.dot(m.y).to_f64())
        })
    }

    /// The next number as the identity of a surface.
    pub fn surface_id(&mut self) -> Result<SurfaceId, DomainError> {
        let value = self.number().to_f64();
        let id = value as u32;
        if f64::from(id) == value {
            Ok(SurfaceId(id))
        } else {
            Err(self.refuse("the identity of a surface is a whole number", value))
        }
    }
}
