//! Estimates of integrals: the integrand over the density (Aether 2017, section 5.1).

use core::cell::RefCell;
use core::fmt;

use crate::combine::{Combined, Heuristic, WeightedSample};
use crate::point::Point;
use crate::real::{Real, Scalar};
use crate::sampler::{Sample, Sampler};
use crate::sequence::{PathView, RandomSequence};
use crate::strategy::{Strategy, Vertex};

mod connections;
mod differences;
mod endings;
mod factors;
mod joints;
mod last;
mod made_pairs;
mod quotient;
mod range;
mod sides;
mod steps;
mod techniques;
mod value;

pub use connections::{Connected, Connections};
pub use differences::Shifts;
pub use endings::{Ending, Endings};
pub use factors::Factors;
pub(crate) use joints::Joints;
use range::is_regular;
pub use steps::Steps;
pub use techniques::Techniques;
pub use value::Value;

/// The precision of an integrand.
type RealOf<I> = <<I as PathIntegrand>::Vertex as Vertex>::Real;

/// An integrand over paths as a product of factors, one a vertex, so that an estimator can divide
/// factor by factor: the integrand and the density of a long path may each leave the range of a
/// float, their quotients do not.
///
/// All visibility and all scattering is the user's. Where a vertex was found by a ray cast, the view
/// says so ([`PathView::visible`]) and no shadow ray is needed.
pub trait PathIntegrand {
    /// The vertices of the paths.
    type Vertex: Vertex;
    /// What is integrated: a number, a spectrum.
    type Value: Value<<Self::Vertex as Vertex>::Real>;

    /// Everything that the integrand gains when the last vertex of `path` is added to the ones
    /// before: the emission or importance or scattering at the vertex before (towards the new one),
    /// and the geometry term and visibility of the edge between them. At a Dirac factor
    /// ([`PathView::carries`]) its coefficient, stated as the strategies state its probability.
    ///
    /// The path shows the last [`PathIntegrand::reads`] vertices. An integrand is a function of them: it adds
    /// no paths to the arena that they live in.
    fn extend(&self, path: PathView<'_, Self::Vertex>) -> Self::Value;

    /// The factor that closes the path: emission (or importance) of the last vertex towards the one
    /// before. The path shows as many vertices as for [`PathIntegrand::extend`].
    fn end(&self, path: PathView<'_, Self::Vertex>) -> Self::Value;

    /// How many vertices, the new one included, [`PathIntegrand::extend`] depends on; three for
    /// scattering. Factors are remembered by them.
    fn reads(&self) -> usize {
        3
    }
}

/// Something with a point and a density: what a loose estimate is made of.
pub trait Drawing {
    /// The precision.
    type Real: Scalar;
    /// The space.
    type Point: Point<Self::Real>;
    /// The point.
    fn drawn_point(&self) -> Self::Point;
    /// Its density; zero if there is no point.
    fn drawn_density(&self) -> Self::Real;
}

impl<S: Sampler<R>, R: Scalar> Drawing for Sample<S, R> {
    type Real = R;
    type Point = S::Point;
    fn drawn_point(&self) -> S::Point {
        self.value()
    }
    fn drawn_density(&self) -> R {
        self.pdf().value()
    }
}

impl<P: Point<R>, R: Scalar> Drawing for WeightedSample<P, R> {
    type Real = R;
    type Point = P;
    fn drawn_point(&self) -> P {
        self.value
    }
    fn drawn_density(&self) -> R {
        self.pdf
    }
}

/// A Monte Carlo estimator of the integral of an integrand.
///
/// `Estimator::new(|x: &Direction| ...)` estimates from samples, `Estimator::paths(integrand)` from
/// paths. Where the density is zero (no sample) or infinite (a pole, which has no mass), the estimate
/// is zero.
pub struct Estimator<I, F = ()> {
    integrand: I,
    factors: RefCell<F>,
}

impl<I: fmt::Debug, F> fmt::Debug for Estimator<I, F> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_tuple("Estimator").field(&self.integrand).finish()
    }
}

impl<I, F> Estimator<I, F> {
    /// The integrand.
    pub fn integrand(&self) -> &I {
        &self.integrand
    }
}

impl<I> Estimator<I> {
    /// An estimator from samples of a function of a point.
    pub fn new(integrand: I) -> Self {
        Estimator { integrand, factors: RefCell::new(()) }
    }

    /// f / p of one sample, not weighted.
    pub fn of<D: Drawing, T: Value<D::Real>>(&self, sample: &D) -> T
    where
        I: Fn(&D::Point) -> T,
    {
        let p = sample.drawn_density();
        if is_regular(p) { (self.integrand)(&sample.drawn_point()).over(p) } else { T::zero() }
    }

    /// The combined estimate of several techniques: the sum of weight × f / p.
    pub fn sum<P: Point<R>, R: Scalar, T: Value<R>>(
        &self,
        samples: impl IntoIterator<Item = WeightedSample<P, R>>,
    ) -> T
    where
        I: Fn(&P) -> T,
    {
        let estimates = samples.into_iter().map(|sample| self.of(&sample).times(sample.weight));
        estimates.fold(T::zero(), |sum, estimate| sum.plus(estimate))
    }
}

/// What a path contributes to the estimate of several techniques.
#[derive(Clone, Copy, Debug)]
pub struct Contribution<'a, V: Vertex, S, T> {
    /// The path.
    pub path: RandomSequence<'a, V, S>,
    /// The number of its technique in the list of techniques.
    pub technique: usize,
    /// Its share of the combined estimate: weight × f / p.
    pub value: T,
    /// f / p over the number of samples that its technique takes: what it would contribute if there were no
    /// other technique.
    pub alone: T,
}

impl<I: PathIntegrand> Estimator<I, Factors<I::Value>> {
    /// An estimator from paths. It remembers factors of the integrand until the arena is cleared.
    pub fn paths(integrand: I) -> Self {
        Estimator { integrand, factors: RefCell::new(Factors::new()) }
    }

    /// The integrand, to be changed: what is remembered of it is forgotten.
    pub fn integrand_mut(&mut self) -> &mut I {
        self.factors.get_mut().forget();
        &mut self.integrand
    }

    /// The paths with their weighted contributions, weight × f / p. Paths that contribute nothing, those of
    /// techniques that take no samples among them, are left out, and their weights are not computed.
    pub fn each<'a, S, H>(
        &self,
        mut combined: Combined<'a, I::Vertex, S, H>,
    ) -> impl Iterator<Item = Contribution<'a, I::Vertex, S, I::Value>>
    where
        I::Vertex: 'a,
        S: Strategy<I::Vertex> + 'a,
        H: Heuristic<<I::Vertex as Vertex>::Real>,
    {
        core::iter::from_fn(move || {
            while let Some((technique, path)) = combined.next_sample() {
                let estimate = self.of(&path);
                if estimate.is_zero() {
                    continue;
                }
                let samples = combined.samples_of(technique);
                if samples > RealOf::<I>::ZERO {
                    let value = estimate.times(combined.weight_of(technique));
                    let alone = estimate.over(samples);
                    return Some(Contribution { path, technique, value, alone });
                }
            }
            None
        })
    }

    /// The combined estimate of several techniques: the sum of weight × f / p.
    pub fn sum<'a, S, H>(&self, combined: Combined<'a, I::Vertex, S, H>) -> I::Value
    where
        I::Vertex: 'a,
        S: Strategy<I::Vertex> + 'a,
        H: Heuristic<<I::Vertex as Vertex>::Real>,
    {
        self.each(combined).fold(I::Value::zero(), |sum, path| sum.plus(path.value))
    }
}
