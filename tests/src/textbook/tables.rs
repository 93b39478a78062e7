//! Tables: the value of the bin or the cell over the mean.

use aether_core::Real;

use crate::catalogue::tables::{CELLS, POLYGON, STEPS};
use crate::registry::Which;

/// The number of the bin of `n` even ones, and the place within it.
fn bin<R: Real>(x: R, n: usize) -> (usize, R) {
    let k = ((x.to_f64() * n as f64) as usize).min(n - 1);
    (k, x * R::of(n as f64) - R::of(k as f64))
}

/// The density of a table on the unit interval.
pub fn on_line<R: Real>(which: Which, x: R) -> Option<R> {
    match which {
        Which::Steps => {
            let mean = STEPS.iter().sum::<f64>() / STEPS.len() as f64;
            Some(R::of(STEPS[bin(x, STEPS.len()).0] / mean))
        }
        Which::Polygon => {
            let (k, t) = bin(x, POLYGON.len() - 1);
            let mean = POLYGON.windows(2).map(|v| 0.5 * (v[0] + v[1])).sum::<f64>()
                / (POLYGON.len() - 1) as f64;
            let [low, high] = [k, k + 1].map(|k| R::of(POLYGON[k] / mean));
            Some((R::ONE - t) * low + t * high)
        }
        _ => None,
    }
}

/// The density of a table on the unit square.
pub fn on_square<R: Real>(which: Which, x: R, y: R) -> Option<R> {
    let mean = CELLS.iter().sum::<f64>() / CELLS.len() as f64;
    (which == Which::Cells).then(|| R::of(CELLS[4 * bin(y, 3).0 + bin(x, 4).0] / mean))
}

/// The density of a table of directions: that of the square, over 2 pi^2 times the sine of the polar angle.
pub fn on_sphere<R: Real>(which: Which, w: &[R]) -> Option<R> {
    if which != Which::CellsOfTheSky {
        return None;
    }
    let (x, y, z) = (w[0], w[1], w[2]);
    let turn = y.atan2(x) * R::of(0.5 / core::f64::consts::PI);
    let turn = R::select(turn.lt(R::ZERO), turn + R::ONE, turn);
    let polar = z.acos() * R::of(1.0 / core::f64::consts::PI);
    let sine = (R::ONE - z * z).sqrt();
    let square = on_square(Which::Cells, turn, polar)?;
    Some(square / (R::of(2.0 * core::f64::consts::PI * core::f64::consts::PI) * sine))
}
