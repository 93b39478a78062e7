//! Step functions and polygons as densities on the line.

use super::cells::{Linear, Stretched, UniformInterval, linear, stretched, uniform_interval};
use super::piecewise::{Pieces, Piecewise};
use super::{Axis, TableError, at_least, expect};
use crate::discrete::Cdf;
use crate::discrete::weights::relative;
use crate::map::Then;
use crate::real::Scalar;
use crate::sampler::Sampler;

/// A density on an interval that is constant in each bin.
#[derive(Clone, Debug)]
pub struct PiecewiseConstant1D<R = f64> {
    axis: Axis<R>,
    cdf: Cdf<R>,
}

impl<R: Scalar> PiecewiseConstant1D<R> {
    /// The density on [0, 1) with these values, up to a factor, in equal bins.
    ///
    /// # Errors
    /// No values; one that is negative, NaN or infinite; none that is positive.
    pub fn new(values: &[R]) -> Result<Self, TableError> {
        relative(values)?;
        Self::on(Axis::even(R::ZERO, R::ONE, values.len())?, values)
    }

    /// The same in the bins of an axis, one value a bin.
    ///
    /// # Errors
    /// As [`Self::new`]; a different number of values and bins.
    pub fn on(axis: Axis<R>, values: &[R]) -> Result<Self, TableError> {
        expect("values", axis.bins(), values.len())?;
        let masses: Vec<f64> =
            relative(values)?.iter().enumerate().map(|(k, v)| v * axis.share(k)).collect();
        Ok(PiecewiseConstant1D { cdf: Cdf::from_relative(&masses)?, axis })
    }

    /// The same table in another precision, with the probabilities that are stored here: exactly, if `S` has
    /// the digits of `R`.
    ///
    /// # Errors
    /// As [`Axis::cast`].
    pub fn cast<S: Scalar>(&self) -> Result<PiecewiseConstant1D<S>, TableError> {
        Ok(PiecewiseConstant1D { axis: self.axis.cast()?, cdf: self.cdf.cast() })
    }

    /// The random variable.
    pub fn sampler(&self) -> Piecewise<&Self> {
        Piecewise(self)
    }
}

impl<R: Scalar> Pieces<R> for &PiecewiseConstant1D<R> {
    type Piece = UniformInterval<R>;
    const AXIS: usize = 0;

    fn choice(&self) -> &Cdf<R> {
        &self.cdf
    }
    fn piece(&self, index: usize) -> UniformInterval<R> {
        let (low, high) = self.axis.bin(index);
        uniform_interval(low, high)
    }
    fn locate(&self, x: &R) -> [Option<usize>; 2] {
        self.axis.locate(*x)
    }
    fn confine(&self, index: usize, x: &R) -> R {
        self.axis.confine(index, *x)
    }
}

/// A density on an interval that interpolates values at the knots linearly.
///
/// ```
/// use aether_core::prelude::*;
/// use aether_core::tables::PiecewiseLinear1D;
/// let hat = PiecewiseLinear1D::new(&[0.0, 1.0, 0.0])?;
/// assert_eq!(hat.sampler().pdf(&0.25).value(), 1.0);
/// assert_eq!(hat.sampler().sample([0.125]).value(), 0.25);
/// # Ok::<(), aether_core::tables::TableError>(())
/// ```
#[derive(Clone, Debug)]
pub struct PiecewiseLinear1D<R: Scalar = f64> {
    axis: Axis<R>,
    cdf: Cdf<R>,
    segments: Box<[Linear<R>]>,
}

impl<R: Scalar> PiecewiseLinear1D<R> {
    /// The density on [0, 1) with these values, up to a factor, at equidistant knots, the first at
    /// zero and the last at one.
    ///
    /// # Errors
    /// Fewer than two values; one that is negative, NaN or infinite; none that is positive.
    pub fn new(values: &[R]) -> Result<Self, TableError> {
        relative(values)?;
        at_least(2, "values", values.len())?;
        Self::on(Axis::even(R::ZERO, R::ONE, values.len() - 1)?, values)
    }

    /// The same with the values at the knots of an axis.
    ///
    /// # Errors
    /// As [`Self::new`]; a different number of values and knots.
    pub fn on(axis: Axis<R>, values: &[R]) -> Result<Self, TableError> {
        expect("values", axis.bins() + 1, values.len())?;
        let values = relative(values)?;
        let masses: Vec<f64> =
            values.windows(2).enumerate().map(|(k, v)| (v[0] + v[1]) * axis.share(k)).collect();
        let segment = |(piece, v): (usize, &[f64])| {
            // Relative to the larger one before they are rounded, so that neither vanishes for no reason.
            let scale = v[0].max(v[1]).max(f64::MIN_POSITIVE);
            linear(R::of(v[0] / scale), R::of(v[1] / scale))
                .map_err(|error| TableError::Domain { piece, error })
        };
        let segments = values.windows(2).enumerate().map(segment).collect::<Result<_, _>>()?;
        Ok(PiecewiseLinear1D { cdf: Cdf::from_relative(&masses)?, segments, axis })
    }

    /// The random variable.
    pub fn sampler(&self) -> Piecewise<&Self> {
        Piecewise(self)
    }
}

/// The density on [0, 1) that is proportional to the line from `a` to `b`, scaled so that the squares
/// of neither overflow nor vanish beside the other for no reason.
pub(super) fn line<R: Scalar>(a: R, b: R) -> Result<Linear<R>, crate::DomainError> {
    let scale = if a.max(b) > R::ZERO { a.max(b) } else { R::ONE };
    linear(a / scale, b / scale)
}

impl<R: Scalar> Pieces<R> for &PiecewiseLinear1D<R> {
    type Piece = Then<Linear<R>, Stretched<R>>;
    const AXIS: usize = 0;

    fn choice(&self) -> &Cdf<R> {
        &self.cdf
    }
    fn piece(&self, index: usize) -> Self::Piece {
        let (low, high) = self.axis.bin(index);
        self.segments[index].then(stretched(low, high))
    }
    fn locate(&self, x: &R) -> [Option<usize>; 2] {
        self.axis.locate(*x)
    }
    fn confine(&self, index: usize, x: &R) -> R {
        self.axis.confine(index, *x)
    }
}
