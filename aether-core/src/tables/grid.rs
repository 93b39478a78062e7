//! The cells of a grid: a row by its probability, then a column given the row.

use super::piecewise::{Pieces, Piecewise};
use super::{Axis, TableError};
use crate::discrete::weights::sum;
use crate::discrete::{Cdf, WeightError};
use crate::real::Scalar;
use crate::sampler::Sampler;
use crate::vec::Vec2;

/// A rectangle cut into cells with probabilities. The second uniform chooses the row (y), the first
/// the column (x), so each keeps its order.
#[derive(Clone, Debug)]
pub struct Grid<R = f64> {
    x: Axis<R>,
    y: Axis<R>,
    rows: Cdf<R>,
    columns: Box<[Cdf<R>]>,
}

impl<R: Scalar> Grid<R> {
    /// A grid with these masses of its cells, row by row, which are not negative.
    pub(super) fn new(x: Axis<R>, y: Axis<R>, masses: &[f64]) -> Result<Self, TableError> {
        let rows: Vec<f64> = masses.chunks(x.bins()).map(|row| sum(row.iter().copied())).collect();
        let column = |row: &[f64]| match Cdf::from_relative(row) {
            // A row that is never chosen needs no right choice within it.
            Err(WeightError::AllZero) => Cdf::from_relative(&vec![1.0; row.len()]),
            choice => choice,
        };
        let columns = masses.chunks(x.bins()).map(column).collect::<Result<_, _>>()?;
        Ok(Grid { rows: Cdf::from_relative(&rows)?, columns, x, y })
    }

    /// The same cells in another precision, with the probabilities that are stored here.
    ///
    /// # Errors
    /// As [`Axis::cast`].
    pub fn cast<S: Scalar>(&self) -> Result<Grid<S>, TableError> {
        let columns = self.columns.iter().map(Cdf::cast).collect();
        Ok(Grid { x: self.x.cast()?, y: self.y.cast()?, rows: self.rows.cast(), columns })
    }

    /// The columns.
    pub fn x(&self) -> &Axis<R> {
        &self.x
    }

    /// The rows.
    pub fn y(&self) -> &Axis<R> {
        &self.y
    }

    /// The lower and the upper corner of a cell.
    ///
    /// # Panics
    /// If there is no such cell.
    #[inline]
    pub fn cell(&self, column: usize, row: usize) -> (Vec2<R>, Vec2<R>) {
        let ((x0, x1), (y0, y1)) = (self.x.bin(column), self.y.bin(row));
        (Vec2::new(x0, y0), Vec2::new(x1, y1))
    }

    /// The probability of a cell; zero if there is no such cell.
    #[inline]
    pub fn probability(&self, column: usize, row: usize) -> R {
        let inner = self.columns.get(row).map_or(R::ZERO, |choice| choice.probability(column));
        self.rows.probability(row) * inner
    }
}

/// A table whose cells each have a sampler.
pub trait CellTable<R: Scalar> {
    /// The sampler inside a cell.
    type Cell: Sampler<R, Uniforms = [R; 2], Point = Vec2<R>>;
    /// The cells and their probabilities.
    fn grid(&self) -> &Grid<R>;
    /// The sampler inside a cell that has a probability.
    fn cell(&self, column: usize, row: usize) -> Self::Cell;
}

/// The rows of a table, as pieces of the plane.
#[derive(Debug)]
pub struct Rows<'t, T>(pub &'t T);

/// The cells of one row of a table, as pieces of the row.
#[derive(Debug)]
pub struct Columns<'t, T> {
    table: &'t T,
    row: usize,
}

// References are `Copy` whatever they refer to.
impl<T> Clone for Rows<'_, T> {
    fn clone(&self) -> Self {
        *self
    }
}
impl<T> Copy for Rows<'_, T> {}
impl<T> Clone for Columns<'_, T> {
    fn clone(&self) -> Self {
        *self
    }
}
impl<T> Copy for Columns<'_, T> {}

impl<'t, R: Scalar, T: CellTable<R>> Pieces<R> for Rows<'t, T> {
    type Piece = Piecewise<Columns<'t, T>>;
    const AXIS: usize = 1;

    fn choice(&self) -> &Cdf<R> {
        &self.0.grid().rows
    }
    fn piece(&self, row: usize) -> Self::Piece {
        Piecewise(Columns { table: self.0, row })
    }
    fn locate(&self, p: &Vec2<R>) -> [Option<usize>; 2] {
        self.0.grid().y.locate(p.y)
    }
    fn confine(&self, row: usize, p: &Vec2<R>) -> Vec2<R> {
        Vec2::new(p.x, self.0.grid().y.confine(row, p.y))
    }
}

impl<R: Scalar, T: CellTable<R>> Pieces<R> for Columns<'_, T> {
    type Piece = T::Cell;
    const AXIS: usize = 0;

    fn choice(&self) -> &Cdf<R> {
        &self.table.grid().columns[self.row]
    }
    fn piece(&self, column: usize) -> T::Cell {
        self.table.cell(column, self.row)
    }
    fn locate(&self, p: &Vec2<R>) -> [Option<usize>; 2] {
        self.table.grid().x.locate(p.x)
    }
    fn confine(&self, column: usize, p: &Vec2<R>) -> Vec2<R> {
        Vec2::new(self.table.grid().x.confine(column, p.x), p.y)
    }
}
