//! What is known of each pixel: the number of samples, their mean and their spread.

use std::io::{self, Read, Write};

use super::shares::{Expected, is_alone};
use crate::image::RgbImage;
use crate::scene::Filter;
use crate::stored::Stored;

/// The running mean and variance of the samples of one pixel (Welford's algorithm, in f64).
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct PixelEstimate {
    count: u32,
    mean: [f64; 3],
    /// Sum of squared distances from the mean.
    spread: [f64; 3],
    /// What samples of other pixels add to the mean, and to the variance of the mean.
    splats: [[f64; 3]; 2],
    /// Whether steps of a Markov chain contribute too, which depend on each other.
    chained: bool,
}

impl PixelEstimate {
    /// Adds a sample.
    pub fn add(&mut self, sample: [f32; 3]) {
        self.count += 1;
        let n = f64::from(self.count);
        for (c, value) in sample.into_iter().enumerate() {
            let before = f64::from(value) - self.mean[c];
            self.mean[c] += before / n;
            self.spread[c] += before * (f64::from(value) - self.mean[c]);
        }
    }

    /// Adds a sample beside which a Markov chain took a step, which splats what it contributes: nothing is known of
    /// the variance.
    pub fn add_chained(&mut self, sample: [f32; 3]) {
        self.add(sample);
        self.chained = true;
    }

    /// The number of samples.
    pub fn count(&self) -> u32 {
        self.count
    }

    /// The mean of the samples; 0 if there are none.
    pub fn mean(&self) -> [f64; 3] {
        std::array::from_fn(|c| self.mean[c] + self.splats[0][c])
    }

    /// Sets what samples of other pixels add to the mean, and to the variance of the mean.
    pub fn set_splats(&mut self, splats: [[f64; 3]; 2]) {
        self.splats = splats;
    }

    /// The estimated variance of the mean, if there are two samples at least.
    ///
    /// It takes samples as independent, so it overstates the variance of stratified ones.
    pub fn variance_of_mean(&self) -> Option<[f64; 3]> {
        let n = f64::from(self.count);
        let variance = |c: usize| self.spread[c] / (n * (n - 1.0)) + self.splats[1][c];
        (self.count >= 2 && !self.chained).then(|| std::array::from_fn(variance))
    }
}

/// Without what other pixels add, which is summed up elsewhere.
impl Stored for PixelEstimate {
    fn store(&self, to: &mut dyn Write) -> io::Result<()> {
        (self.count, self.mean, self.spread, self.chained).store(to)
    }

    fn load(from: &mut dyn Read) -> io::Result<Self> {
        let (count, mean, spread, chained) = Stored::load(from)?;
        Ok(PixelEstimate { count, mean, spread, splats: Default::default(), chained })
    }
}

/// The pixels of an image as far as they have been rendered.
#[derive(Clone, Debug, PartialEq)]
pub struct Film {
    width: u32,
    height: u32,
    pixels: Vec<PixelEstimate>,
    correlation: f64,
}

impl Film {
    /// A film of `size` (columns, rows) without samples.
    pub fn new(size: (u32, u32)) -> Self {
        let pixels = vec![PixelEstimate::default(); size.0 as usize * size.1 as usize];
        Self { width: size.0, height: size.1, pixels, correlation: 1.0 }
    }

    /// Columns and rows.
    pub fn size(&self) -> (u32, u32) {
        (self.width, self.height)
    }

    /// All pixels, row by row from the top.
    pub fn pixels(&self) -> &[PixelEstimate] {
        &self.pixels
    }

    /// The pixel in column `x` and row `y`.
    ///
    /// # Panics
    /// If the position is outside the film.
    pub fn pixel_mut(&mut self, x: u32, y: u32) -> &mut PixelEstimate {
        assert!(x < self.width, "column {x} of a film {} pixels wide", self.width);
        &mut self.pixels[y as usize * self.width as usize + x as usize]
    }

    /// Sets what samples of other pixels add to the mean and to the variance of the mean of each pixel,
    /// by its number.
    pub fn set_splats(&mut self, splats: impl Fn(usize) -> [[f64; 3]; 2]) {
        for (index, pixel) in self.pixels.iter_mut().enumerate() {
            pixel.set_splats(splats(index));
        }
    }

    /// The film of an image whose samples are shared among pixels by a filter, but for what they add up to; and how many samples
    /// that is of, for each pixel. The variance is that of the samples: each pixel has its share of it
    /// from every sample that counts for it, as if these differed as those in the middle of its own do. Beside a small lamp that is
    /// too much ([`Film::limit_variance`]).
    pub(super) fn shared(mut self, filter: Filter) -> (Self, Vec<f64>) {
        let [share, square] = [1, 2].map(|power| Expected::power(filter, power));
        let spread = |expected: &Expected, of: &dyn Fn(&PixelEstimate) -> [f64; 3]| {
            let values: Vec<_> = self.pixels.iter().map(of).collect();
            expected.spread(self.size(), &values)
        };
        let variances = spread(&square, &|pixel| pixel.variance_of_mean().unwrap_or_default());
        // Numbers differ where a render was cut short.
        let counts = spread(&share, &|pixel| [f64::from(pixel.count), 1.0, 0.0]);
        // All that samples add up to has their variance, however it is shared.
        self.correlation = share.total().powi(2) / square.total();
        let (size, mut samples) = (self.size(), Vec::new());
        for (index, pixel) in self.pixels.iter_mut().enumerate() {
            let n = f64::from(pixel.count);
            pixel.mean = [0.0; 3];
            let place = (index as u32 % size.0, index as u32 / size.0);
            if is_alone(filter, size, place) {
                samples.push(n);
            } else {
                let [count, all, _] = counts[index];
                samples.push(count / all);
                pixel.spread = variances[index].map(|v| v * n * (n - 1.0));
            }
        }
        (self, samples)
    }

    /// Has the variance of the mean of no pixel be more than something, by its number, what splats add aside.
    pub(super) fn limit_variance(&mut self, most: impl Fn(usize) -> [f64; 3]) {
        for (index, pixel) in self.pixels.iter_mut().enumerate() {
            let n = f64::from(pixel.count);
            for (spread, most) in pixel.spread.iter_mut().zip(most(index)) {
                *spread = spread.min(most * n * (n - 1.0));
            }
        }
    }

    /// The smallest and the largest number of samples of a pixel.
    pub fn samples(&self) -> (u32, u32) {
        let counts = || self.pixels.iter().map(PixelEstimate::count);
        (counts().min().unwrap_or(0), counts().max().unwrap_or(0))
    }

    /// By what the variance of the mean of many pixels is larger than that of pixels that know nothing of each other: 1, unless
    /// samples are shared among pixels ([`shares`](super::shares)).
    pub fn correlation(&self) -> f64 {
        self.correlation
    }

    /// The mean of each pixel; black where there is no sample yet.
    pub fn image(&self) -> RgbImage {
        self.map(PixelEstimate::mean)
    }

    /// The variance of the mean of each pixel, or `None` while a pixel has fewer than two samples, and if they
    /// come from Markov chains.
    pub fn variance(&self) -> Option<RgbImage> {
        let known = self.pixels.iter().all(|pixel| pixel.variance_of_mean().is_some());
        known.then(|| self.map(|pixel| pixel.variance_of_mean().unwrap_or_default()))
    }

    fn map(&self, value: impl Fn(&PixelEstimate) -> [f64; 3]) -> RgbImage {
        let mut image = RgbImage::filled(self.width as usize, self.height as usize, [0.0; 3]);
        for (target, pixel) in image.pixels_mut().iter_mut().zip(&self.pixels) {
            // A square may exceed the range of f32 although the sample did not.
            *target = value(pixel).map(|v| v.min(f64::from(f32::MAX)) as f32);
        }
        image
    }
}

/// The relative error of an image: root mean square of the standard errors of its pixels over the
/// mean of its pixels. `None` while it is unknown, too large to be told, or the image is black.
pub fn relative_error<'a>(pixels: impl Iterator<Item = &'a PixelEstimate>) -> Option<f64> {
    let (mut variance, mut mean, mut count) = (0.0, 0.0, 0.0);
    for pixel in pixels {
        variance += pixel.variance_of_mean()?.iter().sum::<f64>();
        mean += pixel.mean().iter().sum::<f64>();
        count += 3.0;
    }
    (mean > 0.0 && variance < f64::INFINITY).then(|| (variance / count).sqrt() / (mean / count))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn mean_and_variance_of_known_samples() {
        let mut pixel = PixelEstimate::default();
        assert_eq!((pixel.mean(), pixel.variance_of_mean()), ([0.0; 3], None));
        for value in [2.0, 4.0, 4.0, 6.0] {
            pixel.add([value, -value, 1e7]);
        }
        assert_eq!((pixel.count(), pixel.mean()), (4, [4.0, -4.0, 1e7]));
        // The sample variance is 8 / 3, that of the mean a quarter of it.
        let variance = pixel.variance_of_mean().unwrap();
        approx::assert_relative_eq!(variance[0], 2.0 / 3.0, max_relative = 1e-15);
        assert_eq!((variance[1], variance[2]), (variance[0], 0.0));
    }

    #[test]
    fn variance_needs_two_samples_everywhere() {
        let mut film = Film::new((2, 1));
        film.pixel_mut(0, 0).add([f32::MAX; 3]);
        film.pixel_mut(0, 0).add([-f32::MAX; 3]);
        film.pixel_mut(1, 0).add([1.0; 3]);
        assert_eq!((film.samples(), film.variance()), ((1, 2), None));
        film.pixel_mut(1, 0).add([3.0; 3]);
        let variance = film.variance().unwrap();
        assert_eq!((variance.pixel(0, 0), variance.pixel(1, 0)), ([f32::MAX; 3], [1.0; 3]));
        assert_eq!(film.image().pixel(1, 0), [2.0; 3]);
    }

    #[test]
    fn relative_error_of_known_pixels() {
        let mut film = Film::new((1, 1));
        assert_eq!(relative_error(film.pixels().iter()), None);
        film.pixel_mut(0, 0).add([1.0; 3]);
        film.pixel_mut(0, 0).add([3.0; 3]);
        // Mean 2, standard error of the mean 1.
        assert_eq!(relative_error(film.pixels().iter()), Some(0.5));
    }
}
