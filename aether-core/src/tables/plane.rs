//! Tables in the plane, and on the sphere by way of the plane.

use super::cells::{
    LatitudeLongitude, Linear, StretchedSquare, UniformRectangle, latitude_longitude,
    stretched_square, uniform_rectangle,
};
use super::grid::{CellTable, Grid, Rows};
use super::line::line;
use super::piecewise::Piecewise;
use super::{Axis, Dependent, Family, TableError, Warp, at_least, expect};
use crate::discrete::weights::relative;
use crate::map::Then;
use crate::real::Scalar;
use crate::sampler::Sampler;

/// A density on a rectangle that is constant in each cell of a grid.
#[derive(Clone, Debug)]
pub struct PiecewiseConstant2D<R = f64> {
    grid: Grid<R>,
}

/// A table as a density of directions.
pub type Directions<'t, R = f64> =
    Then<Piecewise<Rows<'t, PiecewiseConstant2D<R>>>, Warp<LatitudeLongitude>>;

/// A bilinear table as a density of directions.
pub type BilinearDirections<'t, R = f64> =
    Then<Piecewise<Rows<'t, PiecewiseLinear2D<R>>>, Warp<LatitudeLongitude>>;

impl<R: Scalar> PiecewiseConstant2D<R> {
    /// The density on the unit square with these values, up to a factor, in equal cells: row by row,
    /// with `columns` in each, the first row at y = 0.
    ///
    /// # Errors
    /// No values, or not a multiple of `columns`; one that is negative, NaN or infinite; none that is
    /// positive.
    pub fn new(values: &[R], columns: usize) -> Result<Self, TableError> {
        relative(values)?;
        at_least(1, "values in a row", columns)?;
        let (x, y) = unit_axes(columns, values.len() / columns)?;
        Self::on(x, y, values)
    }

    /// The same in the cells of two axes.
    ///
    /// # Errors
    /// As [`Self::new`]; a different number of values and cells.
    pub fn on(x: Axis<R>, y: Axis<R>, values: &[R]) -> Result<Self, TableError> {
        expect("values", x.bins() * y.bins(), values.len())?;
        let columns = x.bins();
        let mass = |(k, v): (usize, &f64)| v * x.share(k % columns) * y.share(k / columns);
        let masses: Vec<f64> = relative(values)?.iter().enumerate().map(mass).collect();
        Ok(PiecewiseConstant2D { grid: Grid::new(x, y, &masses)? })
    }

    /// The table whose [`Self::directions`] have a density that in the mean over each texel of an
    /// image by latitude and longitude is proportional to its value: values weighted with the solid
    /// angle of the texels. The first row is at the pole +z.
    ///
    /// # Errors
    /// As [`Self::new`].
    pub fn latitude_longitude(values: &[R], columns: usize) -> Result<Self, TableError> {
        let values: Vec<f64> = relative(values)?;
        at_least(1, "values in a row", columns)?;
        let rows = values.len() / columns;
        let (x, y) = unit_axes(columns, rows)?;
        expect("values", columns * rows, values.len())?;
        let step = core::f64::consts::PI / rows as f64;
        // The difference of the cosines at both ends, as a product.
        let band = |row: usize| (step * (row as f64 + 0.5)).sin();
        let masses: Vec<f64> =
            values.iter().enumerate().map(|(k, v)| v * band(k / columns)).collect();
        Ok(PiecewiseConstant2D { grid: Grid::new(x, y, &masses)? })
    }

    /// The same table in another precision, with the probabilities that are stored here: exactly, if `S` has
    /// the digits of `R`.
    ///
    /// # Errors
    /// As [`Axis::cast`].
    pub fn cast<S: Scalar>(&self) -> Result<PiecewiseConstant2D<S>, TableError> {
        Ok(PiecewiseConstant2D { grid: self.grid.cast()? })
    }

    /// The random variable.
    pub fn sampler(&self) -> Piecewise<Rows<'_, Self>> {
        Piecewise(Rows(self))
    }

    /// The direction with polar angle πy and azimuth 2πx of the point (x, y) that [`Self::sampler`]
    /// draws: an environment map. Its density per solid angle is derived by composition. The axes have
    /// to lie in the unit square; there is no direction of a point outside.
    pub fn directions(&self) -> Directions<'_, R> {
        self.sampler().then(Warp(latitude_longitude()))
    }

    /// The cells.
    pub fn grid(&self) -> &Grid<R> {
        &self.grid
    }
}

impl<R: Scalar> CellTable<R> for PiecewiseConstant2D<R> {
    type Cell = UniformRectangle<R>;

    fn grid(&self) -> &Grid<R> {
        &self.grid
    }
    fn cell(&self, column: usize, row: usize) -> UniformRectangle<R> {
        let (low, high) = self.grid.cell(column, row);
        uniform_rectangle(low, high)
    }
}

/// A density on a rectangle that interpolates values at the nodes of a grid bilinearly.
#[derive(Clone, Debug)]
pub struct PiecewiseLinear2D<R: Scalar = f64> {
    grid: Grid<R>,
    cells: Box<[Bilinear<R>]>,
}

/// A density on the unit square that is bilinear: y by the sums of both corners, then x.
type Bilinear<R> = Dependent<Linear<R>, BilinearColumns<R>>;

impl<R: Scalar> PiecewiseLinear2D<R> {
    /// The density on the unit square with these values, up to a factor, at the nodes of an even
    /// grid: row by row, with `nodes` in each, the first row at y = 0.
    ///
    /// # Errors
    /// Fewer than two rows or columns of nodes; values not a multiple of `nodes`; one that is
    /// negative, NaN or infinite; none that is positive.
    pub fn new(values: &[R], nodes: usize) -> Result<Self, TableError> {
        relative(values)?;
        at_least(2, "nodes in a row", nodes)?;
        let rows = values.len() / nodes;
        at_least(2, "rows of nodes", rows)?;
        let (x, y) = unit_axes(nodes - 1, rows - 1)?;
        Self::on(x, y, values)
    }

    /// The same with the values at the crossings of the knots of two axes.
    ///
    /// # Errors
    /// As [`Self::new`]; a different number of values and nodes.
    pub fn on(x: Axis<R>, y: Axis<R>, values: &[R]) -> Result<Self, TableError> {
        let (columns, rows) = (x.bins(), y.bins());
        expect("values", (columns + 1) * (rows + 1), values.len())?;
        let values = relative(values)?;
        let (mut masses, mut cells) = (Vec::new(), Vec::new());
        for (row, column) in (0..rows).flat_map(|r| (0..columns).map(move |c| (r, c))) {
            let at = row * (columns + 1) + column;
            let corners =
                [values[at], values[at + 1], values[at + columns + 1], values[at + columns + 2]];
            masses.push(corners.iter().sum::<f64>() * x.share(column) * y.share(row));
            let piece = cells.len();
            cells.push(bilinear(corners).map_err(|error| TableError::Domain { piece, error })?);
        }
        Ok(PiecewiseLinear2D { grid: Grid::new(x, y, &masses)?, cells: cells.into() })
    }

    /// The same table in another precision, with the corners and the probabilities that are stored here: exactly,
    /// if `S` has the digits of `R`.
    ///
    /// # Errors
    /// As [`Axis::cast`].
    pub fn cast<S: Scalar>(&self) -> Result<PiecewiseLinear2D<S>, TableError> {
        let corners = self.cells.iter().map(|cell| cell.family().corners.map(R::to_f64));
        let cells = corners.enumerate().map(|(piece, corners)| {
            bilinear(corners).map_err(|error| TableError::Domain { piece, error })
        });
        Ok(PiecewiseLinear2D { grid: self.grid.cast()?, cells: cells.collect::<Result<_, _>>()? })
    }

    /// The random variable.
    pub fn sampler(&self) -> Piecewise<Rows<'_, Self>> {
        Piecewise(Rows(self))
    }

    /// The direction with polar angle πy and azimuth 2πx of the point (x, y) that [`Self::sampler`]
    /// draws: an environment map between whose nodes radiance is interpolated. Values are per area of the
    /// table, so that radiance has to be multiplied by the sine of the polar angle. The axes have to lie in
    /// the unit square; there is no direction of a point outside.
    pub fn directions(&self) -> BilinearDirections<'_, R> {
        self.sampler().then(Warp(latitude_longitude()))
    }

    /// The cells.
    pub fn grid(&self) -> &Grid<R> {
        &self.grid
    }
}

impl<R: Scalar> CellTable<R> for PiecewiseLinear2D<R> {
    type Cell = Then<Bilinear<R>, StretchedSquare<R>>;

    fn grid(&self) -> &Grid<R> {
        &self.grid
    }
    fn cell(&self, column: usize, row: usize) -> Self::Cell {
        let (low, high) = self.grid.cell(column, row);
        self.cells[row * self.grid.x().bins() + column].then(stretched_square(low, high))
    }
}

/// The density on the unit square with these values at (0, 0), (1, 0), (0, 1), (1, 1).
fn bilinear<R: Scalar>(corners: [f64; 4]) -> Result<Bilinear<R>, crate::DomainError> {
    let largest = corners.iter().copied().fold(0.0, f64::max);
    let scale = if largest > 0.0 { largest } else { 1.0 };
    let corners = corners.map(|w| R::of(w / scale));
    let [a, b, c, d] = corners;
    Ok(Dependent::new(line(a + b, c + d)?, BilinearColumns { corners }))
}

/// The densities of x given y in a bilinear cell: lines whose ends are interpolated in y.
#[derive(Clone, Copy, Debug)]
pub struct BilinearColumns<R = f64> {
    /// At (0, 0), (1, 0), (0, 1), (1, 1), relative to the largest.
    corners: [R; 4],
}

impl<R: Scalar> Family<R> for BilinearColumns<R> {
    type Member = Linear<R>;

    #[inline]
    fn given(&self, y: R) -> Option<Linear<R>> {
        let [a, b, c, d] = self.corners;
        let (left, right) = ((R::ONE - y) * a + y * c, (R::ONE - y) * b + y * d);
        // On a side of the cell where the density is zero, the shape of the lines next to it.
        let zero = left == R::ZERO && right == R::ZERO;
        let (left, right) = if zero { (a + c, b + d) } else { (left, right) };
        line(left, right).ok()
    }
}

/// The axes of the unit square.
fn unit_axes<R: Scalar>(columns: usize, rows: usize) -> Result<(Axis<R>, Axis<R>), TableError> {
    Ok((Axis::even(R::ZERO, R::ONE, columns)?, Axis::even(R::ZERO, R::ONE, rows)?))
}
