//! What a sample means to the pixels around it, where the reconstruction filter is wider than a pixel.
//!
//! Each pixel has its own samples, whose film points x follow the absolute value of its filter. A sample of pixel k
//! with the value v_k adds w_q(x) v_k to each pixel q that its film point reaches, where
//! w_q(x) = f_q(x) / Σ_j |f_j(x)| over all pixels j of an image without end: samples of all pixels are combined by the balance
//! heuristic (Veach 1995), for the integrand of each. So an image has as little noise as one whose samples are
//! filtered, and is not biased as one that divides by the sum of weights.
//!
//! If samples with the same number lie at the same place of their pixels, they are a lattice. Of a lattice the weights of a
//! pixel add up to one wherever it lies: what is alike everywhere has no noise. That holds for filters without negative
//! lobes ([`Filter::is_shared`]). Next to the border of an image the lattice has an end; pixels that samples from beyond it would
//! reach have their own samples alone.

use std::ops::Range;

use aether_core::prelude::Vec2;

use crate::film_filter::drawn_radius;
use crate::scene::{Film, Filter};
use crate::strategies::Pixel;

/// What lies further from an image than so many pixels is as far away.
const MOST_PIXELS: f32 = 1e9;

/// The pixels whose filters reach a point of the film: a rectangle of them.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Reached {
    first: Pixel,
    columns: u32,
    rows: u32,
}

impl Reached {
    /// Those that reach a film point, in pixels, of an image of this size (columns, rows).
    pub fn by(filter: Filter, (width, height): (u32, u32), [x, y]: [f32; 2]) -> Self {
        let along = |x: f32, size: u32| {
            let (first, count) = reached_along(filter.radius(), x);
            let [first, end] =
                [first, first + count as i32].map(|k| k.clamp(0, size as i32) as u32);
            (first, end - first)
        };
        let ((x, columns), (y, rows)) = (along(x, width), along(y, height));
        Reached { first: (x, y), columns, rows }
    }

    /// How many there are.
    pub fn count(&self) -> u32 {
        self.columns * self.rows
    }

    /// One of them by its number, row by row.
    pub fn pixel(&self, k: u32) -> Pixel {
        (self.first.0 + k % self.columns, self.first.1 + k / self.columns)
    }

    /// All of them, row by row.
    pub fn pixels(self) -> impl Iterator<Item = Pixel> {
        (0..self.count()).map(move |k| self.pixel(k))
    }
}

/// The pixels along one axis, of an image without end, whose filters reach a point of it, so many pixels far: the first, and
/// how many there are.
#[inline]
fn reached_along(reach: f32, x: f32) -> (i32, u32) {
    let x = x.clamp(-MOST_PIXELS, MOST_PIXELS);
    // Not every machine rounds down in one instruction.
    let floor = |x: f32| x as i32 - i32::from(x < x as i32 as f32);
    let first = -floor(-(x - reach - 0.5));
    let last = floor(x + reach - 0.5);
    (first, (last + 1 - first).max(0) as u32)
}

/// Along an axis with so many pixels, those that have not their own samples alone: none if samples are not shared, and
/// otherwise those that samples from beyond the border would not reach.
fn inner(filter: Filter, size: u32) -> Range<u32> {
    // As far as filters of two pixels overlap.
    let margin = if filter.radius() <= 0.5 { 0 } else { Expected::reach(filter) - 1 };
    let end = if filter.is_signed() { 0 } else { size.saturating_sub(margin) };
    margin.min(end)..end
}

/// Whether a pixel has its own samples alone, in an image of this size.
pub fn is_alone(filter: Filter, (width, height): (u32, u32), (x, y): Pixel) -> bool {
    !(inner(filter, width).contains(&x) && inner(filter, height).contains(&y))
}

/// The weights of a sample, for the pixels that have shares of it.
#[derive(Clone, Debug, Default)]
pub struct Shares {
    first: Pixel,
    /// Filters are products: factors of the weights of each column and each row.
    across: Vec<f32>,
    down: Vec<f32>,
    total: f32,
    /// The sample's own pixel, if that has its own samples alone, and what they count.
    own: Option<(Pixel, f32)>,
}

impl Shares {
    /// Becomes the weights of a sample of a pixel at a point of the film. It counts one for its own pixel if that has no other
    /// samples.
    pub fn move_to(&mut self, film: &Film, pixel: Pixel, point: Vec2<f32>) {
        let Film { width, height, filter } = *film;
        let along = |weights: &mut Vec<f32>, x: f32, size: u32| {
            let (first, count) = reached_along(filter.radius(), x);
            let (inner, mut total) = (inner(filter, size), 0.0);
            weights.clear();
            for pixel in first..first + count as i32 {
                let value = filter.profile(x - pixel as f32 - 0.5);
                total += value.abs();
                if (inner.start as i32..inner.end as i32).contains(&pixel) {
                    weights.push(value);
                }
            }
            if total > 0.0 {
                weights.iter_mut().for_each(|weight| *weight /= total);
            }
            (first.max(inner.start as i32) as u32, total)
        };
        let (x, columns) = along(&mut self.across, point.x, width);
        let (y, rows) = along(&mut self.down, point.y, height);
        (self.first, self.total) = ((x, y), columns * rows);
        self.own = is_alone(filter, (width, height), pixel).then_some((pixel, 1.0));
    }

    /// Has the sample count so much for its own pixel, if that has no other samples, in place of one.
    pub fn count_own(&mut self, counts: impl FnOnce() -> f32) {
        if let Some((_, own)) = &mut self.own {
            *own = counts();
        }
    }

    /// Σ_j |f_j(x)|.
    pub fn total(&self) -> f32 {
        self.total
    }

    /// Each pixel, and its weight.
    pub fn each(&self) -> impl Iterator<Item = (Pixel, f32)> {
        let rows = self.down.iter().zip(self.first.1..);
        let shared = rows.flat_map(|(down, y)| {
            let row = self.across.iter().zip(self.first.0..);
            row.map(move |(across, x)| ((x, y), across * down))
        });
        shared.chain(self.own)
    }

    /// The first pixel, and the factors of columns and rows.
    pub(super) fn parts(&self) -> (Pixel, [&[f32]; 2]) {
        (self.first, [&self.across, &self.down])
    }

    /// What counts for its own pixel alone.
    pub(super) fn own(&self) -> Option<(Pixel, f32)> {
        self.own
    }
}

/// What is expected of the weight that a sample of one pixel has in another, by how far that is away: of the weight itself
/// or of its square.
#[derive(Clone, Debug)]
pub(super) struct Expected {
    /// The factor for each distance along one axis, from -[`Expected::reach`] on.
    along: Vec<f64>,
}

impl Expected {
    /// The weight to some power.
    pub fn power(filter: Filter, power: i32) -> Self {
        const STEPS: usize = 1024;
        let radius = filter.radius();
        let reach = Self::reach(filter) as i32;
        let weight = |x: f32| filter.profile(x).abs();
        let (mut along, mut all) = (vec![0.0; 2 * reach as usize + 1], 0.0);
        for k in 0..STEPS {
            let x = radius * (2.0 * (k as f32 + 0.5) / STEPS as f32 - 1.0);
            let total: f32 = (-reach..=reach).map(|d| weight(x - d as f32)).sum();
            all += f64::from(weight(x));
            for (d, expected) in (-reach..=reach).zip(&mut along) {
                let share = f64::from(filter.profile(x - d as f32) / total);
                *expected += f64::from(weight(x)) * share.powi(power);
            }
        }
        along.iter_mut().for_each(|expected| *expected /= all);
        Expected { along }
    }

    /// The sum over all pixels.
    pub fn total(&self) -> f64 {
        self.along.iter().sum::<f64>().powi(2)
    }

    /// How many pixels away what a sample of a pixel reaches is at most.
    pub fn reach(filter: Filter) -> u32 {
        (filter.radius() + drawn_radius(filter)).ceil() as u32
    }

    /// For each pixel of an image the sum over all pixels of what they have times what is expected.
    pub fn spread<const N: usize>(
        &self,
        (width, height): (u32, u32),
        pixels: &[[f64; N]],
    ) -> Vec<[f64; N]> {
        let rows = self.along_one_axis(pixels, width as usize, height as usize);
        self.along_one_axis(&rows, height as usize, width as usize)
    }

    /// Sums along rows; the image is turned so that these are columns afterwards.
    fn along_one_axis<const N: usize>(
        &self,
        pixels: &[[f64; N]],
        width: usize,
        height: usize,
    ) -> Vec<[f64; N]> {
        let reach = self.along.len() / 2;
        let mut sums = vec![[0.0; N]; pixels.len()];
        for (y, x) in (0..height).flat_map(|y| (0..width).map(move |x| (y, x))) {
            let sum = &mut sums[x * height + y];
            for from in x.saturating_sub(reach)..width.min(x + reach + 1) {
                let expected = self.along[x + reach - from];
                for (sum, value) in sum.iter_mut().zip(&pixels[y * width + from]) {
                    *sum += expected * value;
                }
            }
        }
        sums
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const FILTERS: [Filter; 7] = [
        Filter::Box,
        Filter::Tent { radius: 1.0 },
        Filter::Tent { radius: 2.7 },
        Filter::Gaussian { stddev: 0.5 },
        Filter::Cubic { b: 1.0 / 3.0, c: 1.0 / 3.0 },
        Filter::Cubic { b: 0.0, c: 0.5 },
        Filter::Lanczos { lobes: 3 },
    ];

    fn shares(filter: Filter, size: (u32, u32), pixel: Pixel, [x, y]: [f32; 2]) -> Shares {
        let mut shares = Shares::default();
        let film = Film { width: size.0, height: size.1, filter };
        shares.move_to(&film, pixel, Vec2::new(x, y));
        shares
    }

    #[test]
    fn shares_are_filters_over_what_all_filters_add_up_to() {
        for filter in FILTERS {
            for film in [[9.3f32, 8.1], [0.01, 14.99], [-0.3, 4.0], [15.99, 9.2], [30.0, 1.0]] {
                let size = (16, 15);
                let own = (film[0].clamp(0.0, 15.0) as u32, film[1].clamp(0.0, 14.0) as u32);
                let shares = shares(filter, size, own, film);
                let value = |(x, y): (i32, i32)| {
                    filter.profile(film[0] - x as f32 - 0.5)
                        * filter.profile(film[1] - y as f32 - 0.5)
                };
                let all = || (-9..40).flat_map(|y| (-9..40).map(move |x| (x, y)));
                let total: f32 = all().map(|pixel| value(pixel).abs()).sum();
                approx::assert_relative_eq!(shares.total(), total, max_relative = 1e-5);
                let found: Vec<_> = shares.each().collect();
                let is_inside = |(x, y): (i32, i32)| {
                    (0..16).contains(&x)
                        && (0..15).contains(&y)
                        && !is_alone(filter, size, (x as u32, y as u32))
                };
                for (x, y) in all().filter(|pixel| is_inside(*pixel) && value(*pixel) != 0.0) {
                    let share = found.iter().find(|(pixel, _)| *pixel == (x as u32, y as u32));
                    let expected = value((x, y)) / total;
                    approx::assert_relative_eq!(share.unwrap().1, expected, max_relative = 1e-4);
                }
                let is_alone = |(x, y): Pixel| !is_inside((x as i32, y as i32));
                let alone: Vec<_> = found.iter().filter(|(pixel, _)| is_alone(*pixel)).collect();
                let expected = is_alone(own).then_some((own, 1.0));
                assert_eq!(alone, expected.iter().collect::<Vec<_>>(), "{filter:?}, {film:?}");
            }
        }
    }

    #[test]
    fn of_a_lattice_the_weights_of_a_pixel_add_up_to_one() {
        for filter in FILTERS.into_iter().filter(|filter| filter.is_shared()) {
            let reach = filter.radius();
            for place in [(0.5, 0.5), (0.1, 0.9), (0.77, 0.02), (0.999, 0.4)] {
                let place = [place.0, place.1].map(|x: f32| 0.5 + reach * (2.0 * x - 1.0));
                let mut sums = [0.0; 21 * 17];
                for pixel in (0..17).flat_map(|y| (0..21).map(move |x| (x, y))) {
                    let film = [pixel.0 as f32 + place[0], pixel.1 as f32 + place[1]];
                    for ((x, y), share) in shares(filter, (21, 17), pixel, film).each() {
                        sums[(y * 21 + x) as usize] += share;
                    }
                }
                for sum in sums {
                    approx::assert_relative_eq!(sum, 1.0, max_relative = 1e-5);
                }
            }
        }
    }

    #[test]
    fn weights_are_those_expected() {
        for filter in FILTERS.into_iter().filter(|filter| filter.is_shared()) {
            let [share, square] = [1, 2].map(|power| Expected::power(filter, power));
            let reach = Expected::reach(filter);
            let size = (2 * reach + 1, 2 * reach + 1);
            // Film points of the pixel in the middle, as its filter weighs them.
            let (steps, middle) = (300, f64::from(reach) + 0.5);
            let at =
                |k: u32| f64::from(filter.radius()) * (2.0 * (f64::from(k) + 0.5) / 300.0 - 1.0);
            let (mut sums, mut all) = (vec![[0.0; 2]; (size.0 * size.1) as usize], 0.0);
            for (i, j) in (0..steps).flat_map(|i| (0..steps).map(move |j| (i, j))) {
                let weight =
                    f64::from((filter.profile(at(i) as f32) * filter.profile(at(j) as f32)).abs());
                all += weight;
                let film = [at(i) + middle, at(j) + middle].map(|x| x as f32);
                // The image is larger than what is looked at: its border is not met.
                let (wide, pixel) = ((3 * size.0, 3 * size.1), (3 * reach + 1, 3 * reach + 1));
                let wide = shares(filter, wide, pixel, film.map(|x| x + size.0 as f32));
                for ((x, y), share) in wide.each() {
                    let index = (y - size.1) * size.0 + x - size.0;
                    sums[index as usize][0] += weight * f64::from(share);
                    sums[index as usize][1] += weight * f64::from(share).powi(2);
                }
            }
            let mut only = vec![[0.0; 1]; sums.len()];
            only[(reach * size.0 + reach) as usize] = [1.0];
            for (power, expected) in [share, square].into_iter().enumerate() {
                let spread = expected.spread(size, &only);
                for (spread, sum) in spread.iter().zip(&sums) {
                    let sum = sum[power] / all;
                    assert!(
                        (spread[0] - sum).abs() < 2e-4,
                        "{filter:?}, {power}: {spread:?} {sum}"
                    );
                }
                let total: f64 = spread.iter().map(|spread| spread[0]).sum();
                approx::assert_relative_eq!(total, expected.total(), max_relative = 1e-9);
            }
        }
    }
}
