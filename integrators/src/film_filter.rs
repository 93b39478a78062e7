//! Sampling film points by a table of the reconstruction filter: of filters with negative lobes, and of samples that count for
//! all pixels that see them.

use aether_core::prelude::*;
use aether_core::tables::cells::{StretchedSquare, stretched_square};
use aether_core::tables::{Axis, Piecewise, PiecewiseLinear1D, PiecewiseLinear2D, Rows};
use aether_core::{PdfOf, Then};

use crate::samplers::{FilmBox, film_box};
use crate::scene::Filter;
use crate::strategies::Pixel;

/// Cells of the table for each pixel.
const CELLS: u32 = 16;

/// Cells of the table of a profile for each pixel.
const PERIOD: usize = 32;

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

/// The density of one coordinate of film points about the centre of a pixel, which follows the absolute value of the profile of
/// its filter and reaches as far: of samples that count for all pixels that see them.
#[derive(Clone, Debug)]
pub struct FilmProfile {
    table: PiecewiseLinear1D<f32>,
    radius: f32,
    /// The sum over all pixels, between the ends of the densities of two that are next to each other.
    period: PiecewiseLinear1D<f32>,
}

/// How far from the centre of a pixel, along either axis, a film point of one of its samples lies at most that counts for all
/// pixels which see it: as far as the filter, up to whole cells of a table.
pub fn drawn_radius(filter: Filter) -> f32 {
    (PERIOD as f32 * filter.radius()).ceil() / PERIOD as f32
}

impl FilmProfile {
    /// That of a filter; `None` for a box, which needs no table.
    pub fn new(filter: Filter) -> Option<Self> {
        if filter == Filter::Box {
            return None;
        }
        // A pixel is a whole number of cells. Of filters that reach over whole pixels the middle, the ends of pieces and
        // the zeros are nodes.
        let radius = drawn_radius(filter);
        let half = (PERIOD as f32 * radius) as usize;
        let at = |node: usize| node as f32 / PERIOD as f32 - radius;
        let values: Vec<f32> = (0..=2 * half).map(|k| filter.profile(at(k)).abs()).collect();
        let axis = Axis::even(-radius, radius, 2 * half).ok()?;
        let table = PiecewiseLinear1D::on(axis, &values).ok()?;
        // Sums of polygons with nodes at the same places are such polygons.
        let sum = |node: usize| values.iter().skip(node % PERIOD).step_by(PERIOD).sum();
        let sums: Vec<f32> = (0..=PERIOD).map(sum).collect();
        let period = PiecewiseLinear1D::new(&sums).ok()?;
        Some(FilmProfile { table, radius, period })
    }

    /// [`drawn_radius`] of the filter.
    #[inline]
    pub fn radius(&self) -> f32 {
        self.radius
    }

    #[inline]
    fn density(&self, x: f32) -> f32 {
        self.table.sampler().pdf(&x).value()
    }

    /// The sum of the densities about the centres of all pixels.
    #[inline]
    fn density_of_all(&self, x: f32) -> f32 {
        let x = x - 0.5 + self.radius;
        self.period.sampler().pdf(&(x - x.floor())).value()
    }
}

/// The film points of one pixel, which may lie beside the image, by the profile of its filter; without one that is a box.
#[derive(Clone, Copy, Debug)]
pub struct PixelPoints<'t> {
    profile: Option<&'t FilmProfile>,
    centre: Vec2<f32>,
}

impl<'t> PixelPoints<'t> {
    /// Those of a pixel.
    #[inline]
    pub fn new(profile: Option<&'t FilmProfile>, pixel: Pixel) -> Self {
        PixelPoints { profile, centre: Vec2::new(pixel.0 as f32 + 0.5, pixel.1 as f32 + 0.5) }
    }

    fn square(&self) -> FilmBox<f32> {
        film_box(self.centre.x, self.centre.y)
    }
}

impl Sampler<f32> for PixelPoints<'_> {
    type Uniforms = [f32; 2];
    type Point = Vec2<f32>;

    #[inline]
    fn forward(&self, u: [f32; 2]) -> (Vec2<f32>, bool) {
        let Some(profile) = self.profile else { return self.square().forward(u) };
        let [(x, has_x), (y, has_y)] = u.map(|u| profile.table.sampler().forward([u]));
        (Vec2::new(self.centre.x + x, self.centre.y + y), has_x && has_y)
    }

    #[inline]
    fn pdf(&self, point: &Vec2<f32>) -> PdfOf<Self, f32> {
        let Some(profile) = self.profile else { return self.square().pdf(point) };
        let across = profile.density(point.x - self.centre.x);
        Density::new(across * profile.density(point.y - self.centre.y))
    }

    #[inline]
    fn pdf_of_uniforms(&self, u: [f32; 2]) -> PdfOf<Self, f32> {
        let Some(profile) = self.profile else { return self.square().pdf_of_uniforms(u) };
        let [across, down] = u.map(|u| profile.table.sampler().pdf_of_uniforms([u]).value());
        Density::new(across * down)
    }

    fn preimages(&self, point: &Vec2<f32>, mut visit: impl FnMut([f32; 2], bool)) {
        let Some(profile) = self.profile else { return self.square().preimages(point, visit) };
        let along = profile.table.sampler();
        along.preimages(&(point.x - self.centre.x), |u, has_x| {
            along.preimages(&(point.y - self.centre.y), |v, has_y| {
                visit([u[0], v[0]], has_x && has_y);
            });
        });
    }
}

/// The film points of one of the pixels of an image without end, each of which has one, with the density of all: samples of
/// all pixels estimate an integral together, weighed by the balance heuristic (Veach 1995), if each counts over the sum of all
/// densities. That is no probability density: it integrates to one for each pixel.
#[derive(Clone, Copy, Debug)]
pub struct ImagePoints<'t>(PixelPoints<'t>);

impl<'t> ImagePoints<'t> {
    /// Those of a pixel, by the profile of its filter; without one that is a box.
    #[inline]
    pub fn new(profile: Option<&'t FilmProfile>, own: Pixel) -> Self {
        ImagePoints(PixelPoints::new(profile, own))
    }

    /// Those of the pixel with its own density.
    pub fn own(&self) -> PixelPoints<'t> {
        self.0
    }
}

impl Sampler<f32> for ImagePoints<'_> {
    type Uniforms = [f32; 2];
    type Point = Vec2<f32>;

    #[inline]
    fn forward(&self, u: [f32; 2]) -> (Vec2<f32>, bool) {
        self.0.forward(u)
    }

    /// As each density is a product of one along either axis, their sum is a product of sums.
    #[inline]
    fn pdf(&self, point: &Vec2<f32>) -> PdfOf<Self, f32> {
        // Wherever a point lies, it is in the square of one pixel.
        let Some(profile) = self.0.profile else { return Density::new(1.0) };
        Density::new(profile.density_of_all(point.x) * profile.density_of_all(point.y))
    }

    #[inline]
    fn pdf_of_uniforms(&self, u: [f32; 2]) -> PdfOf<Self, f32> {
        self.forward_with_pdf(u).2
    }

    #[inline]
    fn forward_with_pdf(&self, u: [f32; 2]) -> (Vec2<f32>, bool, PdfOf<Self, f32>) {
        let (point, exists) = self.forward(u);
        (point, exists, if exists { self.pdf(&point) } else { Density::ZERO })
    }

    fn preimages(&self, point: &Vec2<f32>, visit: impl FnMut([f32; 2], bool)) {
        self.0.preimages(point, visit);
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

    #[test]
    fn film_points_of_a_pixel_pass_the_battery() {
        for filter in [Filter::Box, Filter::Tent { radius: 2.3 }, Filter::Gaussian { stddev: 0.5 }]
        {
            let profile = FilmProfile::new(filter);
            Battery::new(&PixelPoints::new(profile.as_ref(), (7, 3))).run().assert_ok();
        }
    }

    #[test]
    fn all_film_points_have_the_density_of_one_from_each_pixel() {
        let filters = [
            Filter::Box,
            Filter::Tent { radius: 1.0 },
            Filter::Tent { radius: 2.3 },
            Filter::Gaussian { stddev: 0.5 },
            Filter::Cubic { b: 1.0 / 3.0, c: 1.0 / 3.0 },
        ];
        for filter in filters {
            let profile = FilmProfile::new(filter);
            let at = |pixel| ImagePoints::new(profile.as_ref(), pixel);
            // How many points fall on each part of the pixel (4, 4), and what the density says of that.
            const PARTS: usize = 4;
            let (mut counts, steps) = ([[0.0; PARTS]; PARTS], [512, 512]);
            for pixel in (2..7).flat_map(|y| (2..7).map(move |x| (x, y))) {
                let own = at(pixel);
                for (i, j) in (0..steps[0]).flat_map(|i| (0..steps[1]).map(move |j| (i, j))) {
                    let u =
                        [(i, steps[0]), (j, steps[1])].map(|(k, n)| (k as f32 + 0.5) / n as f32);
                    let sample = own.sample(u);
                    let [i, j] = [sample.x, sample.y].map(|x| (x - 4.0) * PARTS as f32);
                    let inside = 0.0..PARTS as f32;
                    if sample.is_valid() && inside.contains(&i) && inside.contains(&j) {
                        counts[j as usize][i as usize] += 1.0 / f64::from(steps[0] * steps[1]);
                    }
                }
            }
            for (j, i) in (0..PARTS).flat_map(|j| (0..PARTS).map(move |i| (j, i))) {
                let at_part = |k: usize, part: u32| {
                    4.0 + (k as f32 + (part as f32 + 0.5) / 16.0) / PARTS as f32
                };
                let densities = (0..256).map(|k| {
                    let point = Vec2::new(at_part(i, k % 16), at_part(j, k / 16));
                    // Whose point it is does not matter.
                    f64::from(at((k % 9, 4)).pdf(&point).value())
                });
                let expected = densities.sum::<f64>() / 256.0 / (PARTS * PARTS) as f64;
                // Borders of a part run through cells of the grid.
                assert!(
                    (counts[j][i] - expected).abs() < 1e-3,
                    "{filter:?}: {counts:?}, {expected}"
                );
            }
        }
    }
}
