//! Weights of samples that belong to no path.

use core::ops::Deref;

use crate::combine::{Combine, Heuristic};
use crate::path_density::PathDensity;
use crate::point::Point;
use crate::real::Scalar;
use crate::sampler::{Sample, Sampler};

/// A sample together with the technique that made it. `&Sample` is one, and so is
/// `(&Sample, count)` where the technique takes `count` samples.
pub trait LooseTechnique {
    /// The precision.
    type Real: Scalar;
    /// The space of the samples.
    type Point: Point<Self::Real>;
    /// How many samples the technique takes.
    fn count(&self) -> usize {
        1
    }
    /// The sample.
    fn point(&self) -> Self::Point;
    /// The density of the sample under its technique; zero if there is no sample.
    fn own_density(&self) -> Self::Real;
    /// The density of any point under this technique.
    fn density(&self, x: &Self::Point) -> Self::Real;
}

impl<S: Sampler<R>, R: Scalar> LooseTechnique for &Sample<S, R> {
    type Real = R;
    type Point = S::Point;
    fn point(&self) -> S::Point {
        self.value()
    }
    fn own_density(&self) -> R {
        self.pdf().value()
    }
    fn density(&self, x: &S::Point) -> R {
        self.sampler().pdf(x).value()
    }
}

impl<T: LooseTechnique> LooseTechnique for (T, usize) {
    type Real = T::Real;
    type Point = T::Point;
    fn count(&self) -> usize {
        self.1
    }
    fn point(&self) -> T::Point {
        self.0.point()
    }
    fn own_density(&self) -> T::Real {
        self.0.own_density()
    }
    fn density(&self, x: &T::Point) -> T::Real {
        self.0.density(x)
    }
}

/// A sample with its weight among several techniques. Dereferences to the point.
#[derive(Clone, Copy, Debug)]
pub struct WeightedSample<P, R> {
    /// The sampled point.
    pub value: P,
    /// Its density under the technique that made it; zero if there is no sample.
    pub pdf: R,
    /// The heuristic's weight over the number of samples that the technique takes.
    pub weight: R,
}

impl<P, R> Deref for WeightedSample<P, R> {
    type Target = P;
    fn deref(&self) -> &P {
        &self.value
    }
}

/// n_j p_j / (n_i p_i), without NaN.
#[inline]
pub(crate) fn weighted_ratio<R: Scalar>(ratio: R, other: R, own: R) -> R {
    if other == R::ZERO || ratio == R::ZERO {
        R::ZERO
    } else if own == R::ZERO {
        R::INFINITY
    } else {
        ratio * (other / own)
    }
}

fn weigh<P: Copy, R: Scalar, const N: usize>(
    samples: [(P, R, usize); N],
    density: impl Fn(usize, &P) -> R,
    heuristic: &impl Heuristic<R>,
) -> [WeightedSample<P, R>; N] {
    let count = |i: usize| R::of(samples[i].2 as f64);
    core::array::from_fn(|i| {
        let (value, pdf, _) = samples[i];
        let own = PathDensity::new(pdf);
        let ratios: [R; N] = core::array::from_fn(|j| {
            if j == i {
                return R::ONE;
            }
            let ratio = PathDensity::new(density(j, &value)).ratio(own);
            weighted_ratio(ratio, count(j), count(i))
        });
        let weight = if samples[i].2 == 0 || own.is_zero() {
            R::ZERO
        } else {
            heuristic.weight(&ratios, i) / count(i)
        };
        WeightedSample { value, pdf, weight }
    })
}

impl<H: Heuristic<T::Real>, T: LooseTechnique, const N: usize> Combine<H> for [T; N] {
    type Output = [WeightedSample<T::Point, T::Real>; N];
    fn combine_with(self, heuristic: H) -> Self::Output {
        let samples = core::array::from_fn(|i| {
            let t: &T = &self[i];
            (t.point(), t.own_density(), t.count())
        });
        weigh(samples, |j, x| self[j].density(x), &heuristic)
    }
}

macro_rules! tuples {
    ($($n:literal: $($t:ident $i:tt),+;)*) => {
        $(impl<Heur, R, P, $($t),+> Combine<Heur> for ($($t,)+)
        where
            R: Scalar,
            P: Point<R>,
            Heur: Heuristic<R>,
            $($t: LooseTechnique<Real = R, Point = P>),+
        {
            type Output = [WeightedSample<P, R>; $n];
            fn combine_with(self, heuristic: Heur) -> Self::Output {
                let samples =
                    [$((self.$i.point(), self.$i.own_density(), self.$i.count())),+];
                let density = |j: usize, x: &P| match j {
                    $($i => self.$i.density(x),)+
                    _ => R::ZERO,
                };
                weigh(samples, density, &heuristic)
            }
        })*
    };
}
tuples! {
    2: A 0, B 1;
    3: A 0, B 1, C 2;
    4: A 0, B 1, C 2, D 3;
    5: A 0, B 1, C 2, D 3, E 4;
    6: A 0, B 1, C 2, D 3, E 4, F 5;
    7: A 0, B 1, C 2, D 3, E 4, F 5, G 6;
    8: A 0, B 1, C 2, D 3, E 4, F 5, G 6, H 7;
}
