//! Tables: those of the catalogue with probabilities that all precisions have exactly, and those of the renderer as it
//! stores them, in single precision.

use std::any::Any;
use std::sync::{LazyLock, Mutex, PoisonError};

use aether_core::Scalar;
use aether_core::tables::{
    PiecewiseConstant1D, PiecewiseConstant2D, PiecewiseLinear1D, PiecewiseLinear2D, TableError,
};
use integrators::envmap::EnvironmentTable;
use integrators::film_filter::FilterTable;
use integrators::image::RgbImage;
use integrators::scene::Filter;
use integrators::scene::envmap::EnvironmentMap;

/// Values of steps: one bin is empty, and others have a millionth of the whole. Their sum is 2^21.
pub const STEPS: [f64; 5] = [3.0, 0.0, 1048576.0, 1.0, 1048572.0];

/// Values at the knots of a polygon: a segment is empty. The sums of neighbours add up to 2^12.
pub const POLYGON: [f64; 9] = [0.0, 1.0, 0.0, 0.0, 3.0, 1024.0, 0.0, 1020.0, 0.0];

/// Values of cells, four in a row: the first row is empty, the others add up to 2^20 each.
pub const CELLS: [f64; 12] =
    [0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 1048574.0, 1.0, 262144.0, 262144.0, 524288.0, 0.0];

/// The step function, on the unit interval.
pub fn steps<R: Scalar>() -> PiecewiseConstant1D<R> {
    PiecewiseConstant1D::new(&STEPS.map(R::of)).expect("some values are positive")
}

/// The polygon, on the unit interval.
pub fn polygon<R: Scalar>() -> PiecewiseLinear1D<R> {
    PiecewiseLinear1D::new(&POLYGON.map(R::of)).expect("some values are positive")
}

/// The cells, on the unit square.
pub fn cells<R: Scalar>() -> PiecewiseConstant2D<R> {
    PiecewiseConstant2D::new(&CELLS.map(R::of), 4).expect("some values are positive")
}

/// Tables of the renderer in one precision, made once: they are large.
struct Stored<R: Scalar> {
    mitchell: PiecewiseLinear2D<R>,
    lanczos: PiecewiseLinear2D<R>,
    sky: PiecewiseLinear2D<R>,
}

impl Stored<f32> {
    /// As the renderer makes them. The sky has a sun in a single texel with a million times the radiance of most
    /// others, and darkness below.
    fn new() -> Option<Self> {
        let film = |filter| FilterTable::new(filter).map(|points| points.table().clone());
        let texel = |x: usize, y: usize| match (x, y) {
            (5, 2) => [1e6, 9e5, 8e5],
            (_, 0..5) => [0.5 + ((3 * x + 5 * y) % 7) as f32, 1.0, 2.0],
            _ => [0.0; 3],
        };
        let image = RgbImage::from_fn(16, 9, texel);
        let map = EnvironmentMap::new(image, 1.0, &glam::DMat4::IDENTITY).ok()?;
        Some(Stored {
            mitchell: film(Filter::Cubic { b: 1.0 / 3.0, c: 1.0 / 3.0 })?,
            lanczos: film(Filter::Lanczos { lobes: 3 })?,
            sky: EnvironmentTable::new(&map)?.table().clone(),
        })
    }

    /// The same with the digits of another precision.
    fn cast<R: Scalar>(&self) -> Result<Stored<R>, TableError> {
        let Stored { mitchell, lanczos, sky } = self;
        Ok(Stored { mitchell: mitchell.cast()?, lanczos: lanczos.cast()?, sky: sky.cast()? })
    }
}

/// Those of the precision `R`.
fn stored<R: Scalar>() -> &'static Stored<R> {
    static SINGLE: LazyLock<Option<Stored<f32>>> = LazyLock::new(Stored::new);
    static KNOWN: Mutex<Vec<&'static (dyn Any + Send + Sync)>> = Mutex::new(Vec::new());
    let mut known = KNOWN.lock().unwrap_or_else(PoisonError::into_inner);
    if let Some(found) = known.iter().find_map(|any| any.downcast_ref()) {
        return found;
    }
    let single = SINGLE.as_ref().expect("the filters have negative lobes, and the sky is bright");
    let made = single.cast().expect("the knots of `f32` differ in every precision");
    let made: &'static Stored<R> = Box::leak(Box::new(made));
    known.push(made);
    made
}

/// Film points by the absolute value of Mitchell and Netravali's filter, on the unit square.
pub fn mitchell<R: Scalar>() -> &'static PiecewiseLinear2D<R> {
    &stored().mitchell
}

/// Film points by the absolute value of Lanczos' filter with three lobes, on the unit square.
pub fn lanczos<R: Scalar>() -> &'static PiecewiseLinear2D<R> {
    &stored().lanczos
}

/// A sky with a sun.
pub fn sky<R: Scalar>() -> &'static PiecewiseLinear2D<R> {
    &stored().sky
}
