//! Tabulated densities: on a line, in the plane, on the sphere.
//!
//! | table | density | space |
//! | --- | --- | --- |
//! | [`PiecewiseConstant1D`] | a step function | the line |
//! | [`PiecewiseLinear1D`] | a polygon | the line |
//! | [`RationalQuadraticSpline`] | that of a monotone spline of a uniform | the line |
//! | [`PiecewiseConstant2D`] | constant in each cell of a grid | the plane |
//! | [`PiecewiseLinear2D`] | bilinear in each cell of a grid | the plane |
//! | [`PiecewiseConstant2D::directions`] | constant in each texel, per angle | the sphere |
//! | [`PiecewiseLinear2D::directions`] | bilinear in each texel, per angle | the sphere |
//!
//! No density is written here. All tables are [`Piecewise`]: a uniform chooses a piece by its
//! probability ([`Cdf`](crate::discrete::Cdf)), what is left of the uniform is spent inside it, by a
//! sampler whose density is derived ([`cells`]); the density of a point is the probability of the
//! piece that it lies in times the density there. Tables in two dimensions are pieces of pieces.
//!
//! ```
//! use aether_core::prelude::*;
//! use aether_core::tables::PiecewiseConstant1D;
//!
//! let table = PiecewiseConstant1D::new(&[1.0, 0.0, 3.0])?;
//! let x = table.sampler().sample([0.625]);
//! assert!((x.value() - 2.5 / 3.0).abs() < 1e-15);
//! assert!((x.pdf().value() - 3.0 * 0.75).abs() < 1e-15);
//! assert_eq!(table.sampler().pdf(&0.5).value(), 0.0);
//! # Ok::<(), aether_core::tables::TableError>(())
//! ```

mod axis;
pub mod cells;
mod dependent;
mod grid;
mod line;
mod piecewise;
mod plane;
mod spline;
mod warp;

pub use axis::Axis;
pub use dependent::{Dependent, Family};
pub use grid::{CellTable, Columns, Grid, Rows};
pub use line::{PiecewiseConstant1D, PiecewiseLinear1D};
pub use piecewise::{Pieces, Piecewise};
pub use plane::{
    BilinearColumns, BilinearDirections, Directions, PiecewiseConstant2D, PiecewiseLinear2D,
};
pub use spline::RationalQuadraticSpline;
pub use warp::Warp;

use core::fmt;

use crate::discrete::WeightError;
use crate::sampler::DomainError;

/// Why there is no table.
#[derive(Clone, Debug, PartialEq)]
pub enum TableError {
    /// The values, by their index; those of a grid are numbered row by row.
    Weights(WeightError),
    /// Not as many numbers as the table needs.
    Count {
        /// Which numbers.
        what: &'static str,
        /// How many there must be.
        expected: usize,
        /// How many there are.
        found: usize,
    },
    /// Fewer numbers than any table has.
    TooFew {
        /// Which numbers.
        what: &'static str,
        /// How many there must be at least.
        least: usize,
        /// How many there are.
        found: usize,
    },
    /// A knot is not finite, not above the one before, or too far from it for the number type.
    Knot {
        /// Which knot, counted from zero.
        index: usize,
        /// The knot.
        value: f64,
    },
    /// A number outside the domain of the sampler inside a piece.
    Domain {
        /// Which piece, counted from zero.
        piece: usize,
        /// What the sampler says.
        error: DomainError,
    },
}

impl fmt::Display for TableError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            TableError::Weights(error) => write!(f, "values of a table: {error}"),
            TableError::Count { what, expected, found } => {
                write!(f, "{found} {what} where the table needs {expected}")
            }
            TableError::TooFew { what, least, found } => {
                write!(f, "{found} {what} where the table needs {least} or more")
            }
            TableError::Knot { index, value } => write!(
                f,
                "knot {index} is {value}: knots are finite, two or more, and each lies above the one \
                 before"
            ),
            TableError::Domain { piece, error } => write!(f, "piece {piece} of a table: {error}"),
        }
    }
}

impl std::error::Error for TableError {}

impl From<WeightError> for TableError {
    fn from(error: WeightError) -> Self {
        TableError::Weights(error)
    }
}

/// That there are so many numbers at least.
fn at_least(least: usize, what: &'static str, found: usize) -> Result<(), TableError> {
    if found >= least { Ok(()) } else { Err(TableError::TooFew { what, least, found }) }
}

/// That there are as many numbers as there must be.
fn expect(what: &'static str, expected: usize, found: usize) -> Result<(), TableError> {
    if expected == found { Ok(()) } else { Err(TableError::Count { what, expected, found }) }
}
