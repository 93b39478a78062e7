//! What the battery knows about a space: how to make points of it, and how to cover it.

use super::cubature::{MOST, Place};
use crate::mixed::Mixed;
use crate::point::{
    Direction, Embedded, EmbeddedMeasure, MeasureTable, Point, SurfaceId, SurfacePoint,
};
use crate::real::Scalar;
use crate::vec::{Vec2, Vec3};

/// How a space lies in the coordinates around it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// All of R^n, n up to 3: any finite coordinates are a point of the space.
    Flat,
    /// The unit sphere.
    Sphere,
    /// A manifold that only the sampler knows; densities check that a point belongs to it.
    Embedded,
    /// A manifold whose points carry its identity; densities do not check where a point lies.
    Identified,
    /// Several points at once.
    Joint,
}

/// A space that the battery can check samplers on. Implement it for a point type of your own.
pub trait Space<R: Scalar>: Point<R> {
    /// How the space lies in its coordinates.
    const KIND: Kind;

    /// The point with these coordinates, which may be NaN, infinite, or off the manifold, and
    /// otherwise like `self` (on the same surface).
    fn moved_to(&self, coordinates: &[f64]) -> Self;

    /// A point at the same place that belongs to another manifold, if points have an identity.
    fn elsewhere(&self) -> Option<Self> {
        None
    }

    /// Whether points may be on atoms, as those of [`Mixed`] are.
    const ATOMS: bool = false;

    /// The number of the atom that the point is on.
    fn atom(&self) -> Option<usize> {
        None
    }

    /// The atom with this number, at the place of this point; `None` in a space without atoms.
    fn on_atom(&self, number: usize) -> Option<Self> {
        let _ = number;
        None
    }
}

fn vec3<R: Scalar>(c: &[f64]) -> Vec3<R> {
    Vec3::new(R::of(c[0]), R::of(c[1]), R::of(c[2]))
}

impl<R: Scalar> Space<R> for R {
    const KIND: Kind = Kind::Flat;
    fn moved_to(&self, c: &[f64]) -> Self {
        R::of(c[0])
    }
}

impl<R: Scalar> Space<R> for Vec2<R> {
    const KIND: Kind = Kind::Flat;
    fn moved_to(&self, c: &[f64]) -> Self {
        Vec2::new(R::of(c[0]), R::of(c[1]))
    }
}

impl<R: Scalar> Space<R> for Vec3<R> {
    const KIND: Kind = Kind::Flat;
    fn moved_to(&self, c: &[f64]) -> Self {
        vec3(c)
    }
}

impl<R: Scalar> Space<R> for Direction<R> {
    const KIND: Kind = Kind::Sphere;
    fn moved_to(&self, c: &[f64]) -> Self {
        Direction::from_unit(vec3(c))
    }
}

impl<const K: usize, const N: usize, R: Scalar> Space<R> for Embedded<K, N, R>
where
    MeasureTable: EmbeddedMeasure<K>,
    [R; N]: AsRef<[R]> + AsMut<[R]>,
{
    const KIND: Kind = Kind::Embedded;
    fn moved_to(&self, c: &[f64]) -> Self {
        Embedded(core::array::from_fn(|i| R::of(c[i])))
    }
}

impl<R: Scalar> Space<R> for SurfacePoint<R> {
    const KIND: Kind = Kind::Identified;
    fn moved_to(&self, c: &[f64]) -> Self {
        SurfacePoint::new(vec3(c), self.surface)
    }
    fn elsewhere(&self) -> Option<Self> {
        let other = SurfaceId(self.surface.0.wrapping_add(1));
        Some(SurfacePoint::new(self.position, other))
    }
}

/// What is no atom is a point of the continuous part.
impl<R: Scalar, P: Space<R>> Space<R> for Mixed<P> {
    const KIND: Kind = P::KIND;
    fn moved_to(&self, c: &[f64]) -> Self {
        Mixed::Continuous(self.point().moved_to(c))
    }
    fn elsewhere(&self) -> Option<Self> {
        self.point().elsewhere().map(Mixed::Continuous)
    }
    const ATOMS: bool = true;
    fn atom(&self) -> Option<usize> {
        Mixed::atom(self)
    }
    fn on_atom(&self, number: usize) -> Option<Self> {
        Some(Mixed::Atom(number, self.point()))
    }
}

/// Points in special position are tried for a single manifold; a joint point is none.
impl<R: Scalar, A: Space<R>, B: Space<R>> Space<R> for (A, B) {
    const KIND: Kind = Kind::Joint;
    fn moved_to(&self, c: &[f64]) -> Self {
        let n = self.0.coordinates().as_ref().len();
        (self.0.moved_to(&c[..n]), self.1.moved_to(&c[n..]))
    }
}

impl<R: Scalar, A: Space<R>, B: Space<R>, C: Space<R>> Space<R> for (A, B, C) {
    const KIND: Kind = Kind::Joint;
    fn moved_to(&self, c: &[f64]) -> Self {
        let n = self.0.coordinates().as_ref().len();
        let m = n + self.1.coordinates().as_ref().len();
        (self.0.moved_to(&c[..n]), self.1.moved_to(&c[n..m]), self.2.moved_to(&c[m..]))
    }
}

/// A cover of a whole flat space or of the sphere by the cube [-1, 1]^dimension.
#[derive(Clone, Debug)]
pub(super) enum Chart {
    /// x = median + scale * t / (1 - t²) on each axis: t = ±1 is infinity.
    Flat(Vec<(f64, f64)>),
    /// t = (z, azimuth / pi): preserves area up to the factor pi (Archimedes).
    Sphere,
}

impl Chart {
    /// The chart of a space of this kind, centred on sample points; `None` for a manifold that
    /// nobody knows how to cover.
    pub(super) fn new(kind: Kind, samples: &[Vec<f64>]) -> Option<Self> {
        match kind {
            Kind::Sphere => Some(Chart::Sphere),
            Kind::Flat => {
                let axes = samples.first()?.len();
                (axes <= 3).then(|| Chart::Flat((0..axes).map(|k| location(samples, k)).collect()))
            }
            Kind::Embedded | Kind::Identified | Kind::Joint => None,
        }
    }

    /// Dimension of the cube.
    pub(super) fn dimension(&self) -> usize {
        match self {
            Chart::Flat(axes) => axes.len(),
            Chart::Sphere => 2,
        }
    }

    /// Where in the cube a point lies.
    pub(super) fn cube(&self, x: &[f64]) -> Place {
        let mut t = [0.0; MOST];
        match self {
            Chart::Flat(axes) => {
                for (axis, (t, x)) in t.iter_mut().zip(x).enumerate().take(axes.len()) {
                    *t = self.coordinate(axis, *x);
                }
            }
            Chart::Sphere => {
                t[0] = self.coordinate(0, x[2]);
                t[1] = self.coordinate(1, x[1].atan2(x[0]));
            }
        }
        t
    }

    /// Where along one axis of the cube a coordinate lies: z and azimuth on the sphere.
    pub(super) fn coordinate(&self, axis: usize, x: f64) -> f64 {
        match self {
            Chart::Flat(axes) => {
                let (median, scale) = axes[axis];
                let y = 2.0 * (x - median) / scale;
                y / (1.0 + y.hypot(1.0))
            }
            Chart::Sphere if axis == 0 => x,
            Chart::Sphere => x * core::f64::consts::FRAC_1_PI,
        }
    }

    /// The point of the space at a place in the cube, and the measure of the space per volume of
    /// the cube there.
    pub(super) fn point(&self, t: &Place) -> ([f64; 3], f64) {
        match self {
            Chart::Flat(axes) => {
                let (mut x, mut factor) = ([0.0; 3], 1.0);
                for (k, (median, scale)) in axes.iter().enumerate() {
                    let gap = (1.0 - t[k]) * (1.0 + t[k]);
                    x[k] = median + scale * t[k] / gap;
                    factor *= scale * (1.0 + t[k] * t[k]) / (gap * gap);
                }
                (x, factor)
            }
            Chart::Sphere => {
                let (sin, cos) = (core::f64::consts::PI * t[1]).sin_cos();
                let r = ((1.0 - t[0]) * (1.0 + t[0])).max(0.0).sqrt();
                ([r * cos, r * sin, t[0]], core::f64::consts::PI)
            }
        }
    }
}

/// Median and interquartile range of one coordinate of the samples.
fn location(samples: &[Vec<f64>], axis: usize) -> (f64, f64) {
    let mut values: Vec<f64> = samples.iter().map(|x| x[axis]).collect();
    values.sort_by(f64::total_cmp);
    let quantile = |q: f64| values[(q * values.len() as f64) as usize];
    let (median, range) = (quantile(0.5), quantile(0.75) - quantile(0.25));
    (median, if range > 0.0 { range } else { median.abs().max(1.0) })
}
