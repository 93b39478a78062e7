//! A monotone spline of a uniform (Durkan et al., Neural Spline Flows, 2019).

use super::cells::{RationalQuadratic, Stretched, rational_quadratic, stretched};
use super::piecewise::{Pieces, Piecewise};
use super::{Axis, TableError, expect};
use crate::discrete::{Cdf, Discrete};
use crate::map::Then;
use crate::real::Scalar;
use crate::sampler::Sampler;

/// The random variable f(u), where f is an increasing spline through given points with given slopes,
/// a rational function with quadratics above and below in each bin (Gregory and Delbourgo 1982). Its
/// density is smooth where slopes are, and learns well.
#[derive(Clone, Debug)]
pub struct RationalQuadraticSpline<R: Scalar = f64> {
    axis: Axis<R>,
    cdf: Cdf<R>,
    pieces: Box<[RationalQuadratic<R>]>,
}

impl<R: Scalar> RationalQuadraticSpline<R> {
    /// The spline whose bins have these widths in u, up to a factor, and the bins of `axis` as values,
    /// with the slopes df/du at the knots, one more than bins. Slopes are given relative to the spline
    /// that goes straight through the whole: one is the slope of the chord from first to last knot.
    ///
    /// # Errors
    /// Different numbers of widths and bins, or not one slope more; widths that are not positive;
    /// slopes that differ from the mean slope of a bin beside them by a factor above 1000.
    pub fn new(widths: &[R], axis: Axis<R>, slopes: &[R]) -> Result<Self, TableError> {
        expect("widths", axis.bins(), widths.len())?;
        expect("slopes", axis.bins() + 1, slopes.len())?;
        let cdf = Cdf::new(widths)?;
        let piece = |index: usize| {
            // Slopes in units of the mean slope of the bin.
            let unit = cdf.probability(index) / R::of(axis.share(index));
            rational_quadratic(slopes[index] * unit, slopes[index + 1] * unit)
                .map_err(|error| TableError::Domain { piece: index, error })
        };
        let pieces = (0..cdf.len()).map(piece).collect::<Result<_, _>>()?;
        Ok(RationalQuadraticSpline { axis, pieces, cdf })
    }

    /// The random variable.
    pub fn sampler(&self) -> Piecewise<&Self> {
        Piecewise(self)
    }
}

impl<R: Scalar> Pieces<R> for &RationalQuadraticSpline<R> {
    type Piece = Then<RationalQuadratic<R>, Stretched<R>>;
    const AXIS: usize = 0;

    fn choice(&self) -> &Cdf<R> {
        &self.cdf
    }
    fn piece(&self, index: usize) -> Self::Piece {
        let (low, high) = self.axis.bin(index);
        self.pieces[index].then(stretched(low, high))
    }
    fn locate(&self, x: &R) -> [Option<usize>; 2] {
        self.axis.locate(*x)
    }
    fn confine(&self, index: usize, x: &R) -> R {
        self.axis.confine(index, *x)
    }
}
