//! Points of a space from their coordinates, and some that samplers are tested with.

use aether_core::battery::Space;
use aether_core::{Direction, Embedded, Scalar, SurfaceId, SurfacePoint, Uniforms, Vec2, Vec3};

use crate::catalogue::{BilinearPatch, bilinear_patch};

/// The corners of a tetrahedron, of which the first three are those of a triangle.
pub fn corners<R: Scalar>() -> [Vec3<R>; 4] {
    let v = |x, y, z| Vec3::new(R::of(x), R::of(y), R::of(z));
    [v(0.0, 0.0, 1.0), v(2.0, 0.0, 1.5), v(0.25, 1.75, 0.25), v(0.5, 0.5, 3.0)]
}

/// A patch that is not flat.
pub fn patch<R: Scalar>() -> BilinearPatch<R> {
    let v = |x, y, z| Vec3::new(R::of(x), R::of(y), R::of(z));
    let [a, b] = [v(0.0, 0.0, 0.0), v(2.0, 0.25, 0.5)];
    bilinear_patch(a, b, v(2.5, 1.75, -0.25), v(-0.25, 1.0, 0.75))
}

/// Uniforms with these numbers: one function for all samplers that have so many.
pub fn uniforms<R: Scalar, U: Uniforms<R>>(u: &[R]) -> U {
    U::from_fn(|i| u[i])
}

/// Numbers in the precision of `R`.
pub fn rounded<R: Scalar, C: FromIterator<R>>(x: &[f64]) -> C {
    x.iter().map(|x| R::of(*x)).collect()
}

/// The same the other way.
pub fn plain<R: Scalar, C: FromIterator<f64>>(x: &[R]) -> C {
    x.iter().map(|x| x.to_f64()).collect()
}

/// A point of a space that can be made of coordinates as they stand.
pub trait FromCoordinates<R: Scalar>: Space<R> {
    /// The point; `None` if the space has no point with these coordinates.
    fn from_coordinates(x: &[R]) -> Option<Self>;

    /// The point that anybody can make of these coordinates: directions are normalised.
    fn made_of(x: &[R]) -> Self {
        Self::from_coordinates(x).expect("a space that takes any coordinates")
    }
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
    fn made_of(x: &[R]) -> Self {
        Direction::try_new(x[0], x[1], x[2]).unwrap_or(Direction::new(x[0], x[1], x[2]))
    }
}

impl<R: Scalar> FromCoordinates<R> for Vec3<R> {
    fn from_coordinates(x: &[R]) -> Option<Self> {
        Some(Vec3::new(x[0], x[1], x[2]))
    }
}

/// The point of the surface number zero, on which all items of the registry lie.
impl<R: Scalar> FromCoordinates<R> for SurfacePoint<R> {
    fn from_coordinates(x: &[R]) -> Option<Self> {
        Some(SurfacePoint::new(Vec3::new(x[0], x[1], x[2]), SurfaceId(0)))
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
    fn made_of(x: &[R]) -> Self {
        (Direction::made_of(&x[..3]), Direction::made_of(&x[3..]))
    }
}

impl<R: Scalar> FromCoordinates<R> for (Embedded<2, 3, R>, Embedded<2, 3, R>) {
    fn from_coordinates(x: &[R]) -> Option<Self> {
        Some((Embedded::from_coordinates(&x[..3])?, Embedded::from_coordinates(&x[3..])?))
    }
}

impl<R: Scalar> FromCoordinates<R> for (Vec2<R>, Direction<R>) {
    fn from_coordinates(x: &[R]) -> Option<Self> {
        Some((Vec2::from_coordinates(&x[..2])?, Direction::from_coordinates(&x[2..])?))
    }
    fn made_of(x: &[R]) -> Self {
        (Vec2::made_of(&x[..2]), Direction::made_of(&x[2..]))
    }
}
