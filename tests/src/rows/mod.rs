//! From a row of the reference data to the sampler of the catalogue, in either precision.

mod branched;

use aether_core::battery::Space;
use aether_core::{Direction, Embedded, Sampler, Scalar, Vec2, Vec3};

use crate::catalogue::*;
use crate::reference::Inputs;

/// The numbers of the easy rows.
pub const ROWS: [u64; 17] = [1, 2, 3, 4, 5, 18, 19, 23, 42, 57, 60, 61, 62, 63, 64, 93, 107];

/// A point of a space that can be made of coordinates as they stand.
pub trait FromCoordinates<R: Scalar>: Space<R> {
    /// The point; `None` if the space has no point with these coordinates.
    fn from_coordinates(x: &[R]) -> Option<Self>;
}

impl<R: Scalar> FromCoordinates<R> for R {
    fn from_coordinates(x: &[R]) -> Option<Self> {
        Some(x[0])
    }
}

impl<R: Scalar> FromCoordinates<R> for Vec2<R> {
    fn from_coordinates(x: &[R]) -> Option<Self> {
        Some(Vec2::new(x[0], x[1]))
    }
}

impl<R: Scalar> FromCoordinates<R> for Direction<R> {
    fn from_coordinates(x: &[R]) -> Option<Self> {
        Direction::try_new(x[0], x[1], x[2])
    }
}

impl<R: Scalar> FromCoordinates<R> for Vec3<R> {
    fn from_coordinates(x: &[R]) -> Option<Self> {
        Some(Vec3::new(x[0], x[1], x[2]))
    }
}

impl<const K: usize, const N: usize, R: Scalar> FromCoordinates<R> for Embedded<K, N, R>
where
    Embedded<K, N, R>: Space<R>,
{
    fn from_coordinates(x: &[R]) -> Option<Self> {
        Some(Embedded(core::array::from_fn(|i| x[i])))
    }
}

impl<R: Scalar> FromCoordinates<R> for (Direction<R>, Direction<R>) {
    fn from_coordinates(x: &[R]) -> Option<Self> {
        Some((Direction::from_coordinates(&x[..3])?, Direction::from_coordinates(&x[3..])?))
    }
}

/// Something to be done with a sampler of any space.
pub trait Visitor<R: Scalar> {
    /// What comes out.
    type Output;
    /// Does it.
    fn visit<S: Sampler<R>>(self, sampler: S) -> Self::Output
    where
        S::Point: FromCoordinates<R>;
}

/// Visits the sampler that an entry of the reference data is about.
///
/// # Panics
/// If the catalogue has no such row, or the sampler refuses the parameters.
pub fn visit<R: Scalar, V: Visitor<R>>(entry: &Inputs, visitor: V) -> V::Output {
    let p = |name: &str| entry.scalar::<R>(name);
    match entry.row {
        1 => visitor.visit(affine(p("a"), p("b"))),
        2 => visitor.visit(power(p("k"))),
        3 => visitor.visit(exponential(p("s"))),
        4 => visitor.visit(truncated_exponential(p("s"), p("D"))),
        5 => visitor.visit(linear(p("a"), p("b")).expect("ends of the line are not negative")),
        18 => visitor.visit(weibull(p("l"), p("k"))),
        19 => visitor.visit(gumbel(p("m"), p("b"))),
        23 => visitor.visit(softplus_logistic()),
        42 => visitor.visit(polar_disk(p("R"))),
        57 => {
            let (a, b, c, d) = (p("a"), p("b"), p("c"), p("d"));
            visitor.visit(affine_logistics(a, b, c, d, p("t0"), p("t1")))
        }
        60 => visitor.visit(uniform_sphere()),
        61 => visitor.visit(equirectangular()),
        62 => visitor.visit(uniform_hemisphere()),
        63 => visitor.visit(cosine_hemisphere()),
        64 => visitor.visit(power_cosine(p("n"))),
        93 => visitor.visit(sphere_surface(Vec3::from_array(entry.vector("c")), p("R"))),
        107 => visitor.visit(height_field(p("h"))),
        _ => branched::visit(entry, visitor),
    }
}
