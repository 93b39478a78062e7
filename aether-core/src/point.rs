//! The spaces that samples live in. A point type names its space, and the space its measure.

use core::ops::Deref;

use crate::density::{Area, Hausdorff, Length, Measure, SolidAngle, Volume};
use crate::real::{Mask, Real, Scalar};
use crate::vec::{Vec2, Vec3};

/// A point of a space that carries a reference measure.
pub trait Point<R: Real>: Copy + core::fmt::Debug {
    /// The measure that densities on this space are taken with respect to.
    type Measure: Measure;
    /// Coordinates, `[R; N]`.
    type Coordinates: Copy + AsRef<[R]> + AsMut<[R]>;
    /// Dimension of the manifold (2 for a direction), not of the space around it.
    const DIMENSION: usize;
    /// The coordinates in the space around the manifold.
    fn coordinates(&self) -> Self::Coordinates;
    /// Whether every coordinate is finite.
    fn finite(&self) -> R::Mask {
        let mut all = R::Mask::TRUE;
        for c in self.coordinates().as_ref() {
            all = all.and(Real::finite(*c));
        }
        all
    }
}

/// A space of which the points of `P` are a part: a disjoint union of several spaces, each with a
/// measure of its own, such as the surfaces and the media of a scene. Every space is a part of itself.
///
/// It lets a path have vertices of several kinds: where a vertex is drawn from a sampler of one part,
/// its density is taken with respect to the measure of that part, and is zero on all others.
///
/// ```
/// use aether_core::prelude::*;
/// use aether_core::Includes;
///
/// #[derive(Clone, Copy, Debug)]
/// enum Place {
///     Surface(SurfacePoint),
///     Medium(Vec3),
/// }
///
/// impl Includes<SurfacePoint> for Place {
///     fn part(&self) -> Option<SurfacePoint> {
///         if let Place::Surface(x) = self { Some(*x) } else { None }
///     }
/// }
///
/// impl Includes<Vec3> for Place {
///     fn part(&self) -> Option<Vec3> {
///         if let Place::Medium(x) = self { Some(*x) } else { None }
///     }
/// }
/// ```
#[diagnostic::on_unimplemented(
    message = "a vertex that lives in `{Self}` cannot be made from a point of `{P}`",
    label = "made from a point of `{P}`",
    note = "bring the point to the vertex's space with a #[map], or, if `{Self}` is a union of \
            spaces of which this is one, implement `Includes<{P}>` for it"
)]
pub trait Includes<P>: Copy {
    /// The point as one of that part; `None` if it lies in another one.
    fn part(&self) -> Option<P>;
}

impl<P: Copy> Includes<P> for P {
    #[inline(always)]
    fn part(&self) -> Option<P> {
        Some(*self)
    }
}

macro_rules! runs {
    ($($n:literal: $($part:ident $i:tt),+;)*) => {
        $(/// Points of one space, each of which lies in a part of it.
        impl<P: $(Includes<$part> +)+ Copy, $($part: Copy),+> Includes<($($part,)+)> for [P; $n] {
            #[inline(always)]
            fn part(&self) -> Option<($($part,)+)> {
                Some(($(Includes::<$part>::part(&self[$i])?,)+))
            }
        })*
    };
}
runs! {
    2: A 0, B 1;
    3: A 0, B 1, C 2;
    4: A 0, B 1, C 2, D 3;
    5: A 0, B 1, C 2, D 3, E 4;
    6: A 0, B 1, C 2, D 3, E 4, F 5;
    7: A 0, B 1, C 2, D 3, E 4, F 5, G 6;
    8: A 0, B 1, C 2, D 3, E 4, F 5, G 6, H 7;
}

/// A point of the real line; densities are per unit length.
impl<R: Real> Point<R> for R {
    type Measure = Length;
    type Coordinates = [R; 1];
    const DIMENSION: usize = 1;
    #[inline(always)]
    fn coordinates(&self) -> [R; 1] {
        [*self]
    }
}

/// A point of the plane; densities are per unit area.
impl<R: Real> Point<R> for Vec2<R> {
    type Measure = Area;
    type Coordinates = [R; 2];
    const DIMENSION: usize = 2;
    #[inline(always)]
    fn coordinates(&self) -> [R; 2] {
        self.to_array()
    }
}

/// A point of space; densities are per unit volume.
impl<R: Real> Point<R> for Vec3<R> {
    type Measure = Volume;
    type Coordinates = [R; 3];
    const DIMENSION: usize = 3;
    #[inline(always)]
    fn coordinates(&self) -> [R; 3] {
        self.to_array()
    }
}

/// A direction: a point of the unit sphere. Densities are per steradian.
///
/// Unit length is guaranteed by the type, so no density ever has to test for it: raw coordinates
/// enter through [`Direction::try_new`] (which checks) or [`Direction::new`] (which normalises).
/// It dereferences to its vector, so `w.x` and `w.dot(n)` work.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Direction<R = f64>(Vec3<R>);

impl<R: Real> Direction<R> {
    /// The direction of the vector (x, y, z), which need not have unit length.
    ///
    /// In the body of a sampler or a map the coordinates are taken as they stand, and the compiler
    /// checks that their squares add up to one.
    #[inline(always)]
    pub fn new(x: R, y: R, z: R) -> Self {
        Direction(Vec3::new(x, y, z).normalize())
    }

    /// [`Direction::new`] for a vector.
    #[inline(always)]
    pub fn from_vec(v: Vec3<R>) -> Self {
        Direction(v.normalize())
    }

    /// A direction from a vector that is known to have unit length; emitted code uses it.
    #[inline(always)]
    pub fn from_unit(v: Vec3<R>) -> Self {
        Direction(v)
    }

    /// The vector.
    #[inline(always)]
    pub fn vec(self) -> Vec3<R> {
        self.0
    }
}

impl<R: Scalar> Direction<R> {
    /// The direction (x, y, z) if its length is one to within rounding (eight units in the last
    /// place), `None` otherwise; NaN and infinity are refused.
    pub fn try_new(x: R, y: R, z: R) -> Option<Self> {
        let v = Vec3::new(x, y, z);
        let deviation = (v.length_squared() - R::ONE).abs();
        (deviation <= R::of(16.0) * R::EPSILON).then_some(Direction(v))
    }
}

impl<R> Deref for Direction<R> {
    type Target = Vec3<R>;
    #[inline(always)]
    fn deref(&self) -> &Vec3<R> {
        &self.0
    }
}

impl<R: Real> Point<R> for Direction<R> {
    type Measure = SolidAngle;
    type Coordinates = [R; 3];
    const DIMENSION: usize = 2;
    #[inline(always)]
    fn coordinates(&self) -> [R; 3] {
        self.0.to_array()
    }
}

/// A manifold of dimension `K` in R^`N` that is known only through its sampler: a curve, a sphere
/// around some centre, a plane somewhere in space.
///
/// Nothing in the type says which manifold a point belongs to, so every density checks it, with a
/// tolerance that follows from the rounding of the coordinates and of the sampler's parameters.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Embedded<const K: usize, const N: usize, R = f64>(pub [R; N]);

/// A point of some surface in space; densities are per unit area.
pub type Surface<R = f64> = Embedded<2, 3, R>;
/// A point of some curve in space; densities are per unit length.
pub type Curve<R = f64> = Embedded<1, 3, R>;

impl<const K: usize, R: Real> Embedded<K, 3, R> {
    /// The point (x, y, z).
    #[inline(always)]
    pub fn new(x: R, y: R, z: R) -> Self {
        Embedded([x, y, z])
    }
    /// The point at a position.
    #[inline(always)]
    pub fn from_vec(v: Vec3<R>) -> Self {
        Embedded(v.to_array())
    }
    /// The position.
    #[inline(always)]
    pub fn vec(self) -> Vec3<R> {
        Vec3::from_array(self.0)
    }
}

/// Names the measure of each dimension: length, area, volume, then Hausdorff.
pub trait EmbeddedMeasure<const K: usize> {
    /// The measure.
    type Measure: Measure;
}
/// Carrier of the [`EmbeddedMeasure`] table.
#[derive(Clone, Copy, Debug)]
pub struct MeasureTable;
impl EmbeddedMeasure<1> for MeasureTable {
    type Measure = Length;
}
impl EmbeddedMeasure<2> for MeasureTable {
    type Measure = Area;
}
impl EmbeddedMeasure<3> for MeasureTable {
    type Measure = Hausdorff<3>;
}
impl EmbeddedMeasure<4> for MeasureTable {
    type Measure = Hausdorff<4>;
}

impl<const K: usize, const N: usize, R: Real> Point<R> for Embedded<K, N, R>
where
    MeasureTable: EmbeddedMeasure<K>,
    [R; N]: AsRef<[R]> + AsMut<[R]>,
{
    type Measure = <MeasureTable as EmbeddedMeasure<K>>::Measure;
    type Coordinates = [R; N];
    const DIMENSION: usize = K;
    #[inline(always)]
    fn coordinates(&self) -> [R; N] {
        self.0
    }
}

/// The identity of a surface: which triangle, sphere or disk of a scene a point lies on.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Default, PartialOrd, Ord)]
pub struct SurfaceId(pub u32);

/// A point of a surface that knows which surface it lies on. Densities are per unit area.
///
/// The identity guarantees membership: a density compares identities and never the distance of the
/// point from a plane. The one who makes the point (a sampler, a ray caster) vouches for it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SurfacePoint<R = f64> {
    /// Where the point is.
    pub position: Vec3<R>,
    /// Which surface it is a point of.
    pub surface: SurfaceId,
}

impl<R: Real> SurfacePoint<R> {
    /// The point of `surface` at `position`.
    #[inline(always)]
    pub fn new(position: Vec3<R>, surface: SurfaceId) -> Self {
        SurfacePoint { position, surface }
    }
}

impl<R> Deref for SurfacePoint<R> {
    type Target = Vec3<R>;
    #[inline(always)]
    fn deref(&self) -> &Vec3<R> {
        &self.position
    }
}

impl<R: Real> Point<R> for SurfacePoint<R> {
    type Measure = Area;
    type Coordinates = [R; 3];
    const DIMENSION: usize = 2;
    #[inline(always)]
    fn coordinates(&self) -> [R; 3] {
        self.position.to_array()
    }
}
