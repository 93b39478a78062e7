//! Sampling film points by a reconstruction filter that has negative lobes.

use aether_core::Then;
use aether_core::prelude::*;
use aether_core::tables::cells::{StretchedSquare, stretched_square};
use aether_core::tables::{Piecewise, PiecewiseLinear2D, Rows};

use crate::scene::Filter;

/// Cells of the table for each pixel.
const CELLS: u32 = 16;

/// The density of film points that follows the absolute value of a filter, about the centre of a pixel.
/// A sample then counts with the sign of the filter, and nearly always with the same weight.
#[derive(Clone, Debug)]
pub struct FilterTable {
    table: PiecewiseLinear2D<f32>,
    radius: f32,
}

/// Film points about a pixel.
pub type FilmPoints<'t> = Then<Piecewise<Rows<'t, PiecewiseLinear2D<f32>>>, StretchedSquare<f32>>;

impl FilterTable {
    /// The table of a filter; `None` if it has no negative lobes, and so a sampler of its own.
    pub fn new(filter: Filter) -> Option<Self> {
        let radius = filter.radius();
        // Whole pixels: the ends of pieces and the zeros of the filter are nodes.
        let cells = filter.is_signed().then_some(2 * CELLS * radius as u32)?;
        let at = |node: u32| 2.0 * radius * node as f32 / cells as f32 - radius;
        let profile: Vec<f32> = (0..=cells).map(|k| filter.profile(at(k)).abs()).collect();
        let values: Vec<f32> =
            profile.iter().flat_map(|y| profile.iter().map(move |x| x * y)).collect();
        let table = PiecewiseLinear2D::new(&values, profile.len()).ok()?;
        Some(FilterTable { table, radius })
    }

    /// The table, on the unit square.
    pub fn table(&self) -> &PiecewiseLinear2D<f32> {
        &self.table
    }

    /// The random variable, about a point of the film in pixels.
    pub fn about(&self, x: f32, y: f32) -> FilmPoints<'_> {
        let r = self.radius;
        let square = stretched_square(Vec2::new(x - r, y - r), Vec2::new(x + r, y + r));
        self.table.sampler().then(square)
    }
}

#[cfg(test)]
mod tests {
    use aether_core::battery::Battery;

    use super::*;

    #[test]
    fn the_density_passes_the_battery() {
        let table = FilterTable::new(Filter::Cubic { b: 1.0 / 3.0, c: 1.0 / 3.0 }).unwrap();
        Battery::new(&table.about(7.5, 3.5)).run().assert_ok();
    }

    #[test]
    fn the_density_covers_the_filter_and_follows_it() {
        let filters = [
            Filter::Cubic { b: 1.0 / 3.0, c: 1.0 / 3.0 },
            Filter::Cubic { b: 0.0, c: 0.5 },
            Filter::Lanczos { lobes: 1 },
            Filter::Lanczos { lobes: 3 },
        ];
        for filter in filters {
            let table = FilterTable::new(filter).unwrap();
            let points = table.about(0.0, 0.0);
            let value = |p: Vec2<f32>| filter.profile(p.x) * filter.profile(p.y);
            let (mut signed, mut absolute, mut squared, count) = (0.0, 0.0, 0.0, 400);
            for (k, j) in (0..count).flat_map(|k| (0..count).map(move |j| (k, j))) {
                let [u, v] = [k, j].map(|k| (k as f32 + 0.5) / count as f32);
                let sample = points.sample([u, v]);
                let weight = f64::from(value(sample.value()) / sample.pdf().value());
                signed += weight;
                absolute += weight.abs();
                squared += weight * weight;
            }
            let all = f64::from(count * count);
            let (signed, absolute, squared) = (signed / all, absolute / all, squared / all);
            // The integral of the filter, to the error of the midpoint rule.
            let one = f64::from(crate::world::profile_integral(filter)).powi(2);
            assert!((signed - one).abs() < 0.02, "{filter:?}: {signed} for {one}");
            // Weights are all but alike.
            let spread = squared / (absolute * absolute) - 1.0;
            assert!(spread < 0.02, "{filter:?}: {spread}");
        }
        assert!(FilterTable::new(Filter::Box).is_none());
    }
}
