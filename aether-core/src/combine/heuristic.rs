//! How weights follow from densities.

use crate::path_density::PathDensity;
use crate::real::Scalar;

/// A rule for the weights of multiple importance sampling. The weights of one point over all
/// techniques that can make it must sum to one.
pub trait Heuristic<R> {
    /// The weight of a sample that technique `own` made. `ratios[j]` is n_j p_j / (n_own p_own), how
    /// much likelier technique j with its n_j samples makes that point: 0 if it cannot, infinite at a
    /// pole, 1 for `own` itself.
    fn weight(&self, ratios: &[R], own: usize) -> R;
}

impl<R, F: Fn(&[R], usize) -> R> Heuristic<R> for F {
    fn weight(&self, ratios: &[R], own: usize) -> R {
        self(ratios, own)
    }
}

/// A heuristic whose weights are term(n_j p_j) / Σ term(n_k p_k), where term(a b) = term(a) term(b): sums of terms
/// over many techniques follow from each other.
pub trait Separable<R: Scalar>: Heuristic<R> {
    /// The term of a ratio of densities.
    fn term(&self, ratio: PathDensity<R>) -> PathDensity<R>;

    /// The same in plain numbers, where the ratio and the term are in their range: never more than `term` costs.
    #[inline]
    fn plain_term(&self, ratio: R) -> R {
        self.term(PathDensity::new(ratio)).value()
    }
}

/// Weights proportional to n_j p_j (Veach and Guibas 1995, balance heuristic).
#[derive(Clone, Copy, Debug, Default)]
pub struct BalanceHeuristic;

impl<R: Scalar> Heuristic<R> for BalanceHeuristic {
    fn weight(&self, ratios: &[R], _own: usize) -> R {
        R::ONE / ratios.iter().copied().sum()
    }
}

impl<R: Scalar> Separable<R> for BalanceHeuristic {
    #[inline]
    fn term(&self, ratio: PathDensity<R>) -> PathDensity<R> {
        ratio
    }

    #[inline]
    fn plain_term(&self, ratio: R) -> R {
        ratio
    }
}

/// Weights proportional to (n_j p_j)² (Veach and Guibas 1995, power heuristic with β = 2).
#[derive(Clone, Copy, Debug, Default)]
pub struct PowerHeuristic;

impl<R: Scalar> Heuristic<R> for PowerHeuristic {
    fn weight(&self, ratios: &[R], _own: usize) -> R {
        R::ONE / ratios.iter().map(|ratio| *ratio * *ratio).sum()
    }
}

impl<R: Scalar> Separable<R> for PowerHeuristic {
    #[inline]
    fn term(&self, ratio: PathDensity<R>) -> PathDensity<R> {
        ratio * ratio
    }

    #[inline]
    fn plain_term(&self, ratio: R) -> R {
        ratio * ratio
    }
}

/// All weight to the technique with the largest n_j p_j (Veach and Guibas 1995, maximum heuristic);
/// techniques that tie share it.
///
/// Densities that agree to half the digits of `R` tie, so that rounding cannot make each of two
/// equal techniques believe that the other one is likelier.
#[derive(Clone, Copy, Debug, Default)]
pub struct MaximumHeuristic;

impl<R: Scalar> Heuristic<R> for MaximumHeuristic {
    fn weight(&self, ratios: &[R], _own: usize) -> R {
        let tolerance = R::EPSILON.sqrt();
        let most = ratios.iter().fold(R::ONE, |most, ratio| most.max(*ratio));
        let ties = |ratio: R| ratio * (R::ONE + tolerance) >= most;
        if !ties(R::ONE) {
            return R::ZERO;
        }
        // All that tie with the largest one, so that each of them counts the same.
        let tied = ratios.iter().filter(|ratio| ties(**ratio)).count();
        R::ONE / R::of(tied as f64)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn weights_of_nearly_equal_techniques_add_up_to_one() {
        let tolerance = f64::EPSILON.sqrt();
        for steps in [[0.0, 0.8, 1.6], [0.0, 0.5, 0.9], [0.0, 3.0, 3.5], [0.0, 0.0, 9.0]] {
            let densities = steps.map(|step| 1.0 + step * tolerance);
            let weight = |own: usize| {
                let ratios = densities.map(|p| p / densities[own]);
                MaximumHeuristic.weight(&ratios, own)
            };
            assert_eq!((0..3).map(weight).sum::<f64>(), 1.0, "{steps:?}");
        }
    }
}
