//! The estimated error of parts of an image, which tells when it is good enough.

use std::io::{self, Read, Write};

use super::film::{Film, PixelEstimate};
use crate::image::compare::RELATIVE_OFFSET;
use crate::stored::Stored;

/// The side of a window in pixels; windows at the right and lower border may be smaller.
///
/// The relative error of a window is the root of the mean, over its pixels and channels, of the estimated
/// variance of the pixel's mean over `m² + 0.01`, where `m` is the mean of the channel in the window. That is
/// the root of the expected relMSE ([`compare`](crate::image::compare)), with the reference replaced by what
/// the window knows. A single pixel knows its variance too badly to be asked.
pub const WINDOW: u32 = 16;

/// From how many samples on a window is judged.
const FEWEST: u32 = 16;
/// Windows are judged at powers of two up to this number of samples, and then at its multiples.
const PERIOD: u32 = 64;

/// The number of samples at which windows are judged next, after `done`.
pub(super) fn next_decision(done: u32) -> u32 {
    if done < PERIOD {
        (done + 1).next_power_of_two()
    } else {
        (done / PERIOD).saturating_add(1).saturating_mul(PERIOD)
    }
}

/// Whether windows are judged at a number of samples.
pub(super) fn decides_at(done: u32) -> bool {
    done >= FEWEST && (done.is_power_of_two() && done <= PERIOD || done.is_multiple_of(PERIOD))
}

/// The relative error of each window, row by row; `None` while the variance of a pixel is unknown.
pub(super) fn window_errors(
    film: &Film,
    variance: impl Fn(usize, &PixelEstimate) -> Option<[f64; 3]>,
) -> Option<Vec<f64>> {
    let (width, height) = film.size();
    let mut errors = Vec::new();
    for y in (0..height).step_by(WINDOW as usize) {
        for x in (0..width).step_by(WINDOW as usize) {
            let (mut sum, mut spread, mut pixels) = ([0.0; 3], [0.0; 3], 0.0);
            for row in y..height.min(y + WINDOW) {
                for column in x..width.min(x + WINDOW) {
                    let index = row as usize * width as usize + column as usize;
                    let pixel = &film.pixels()[index];
                    let (mean, variance) = (pixel.mean(), variance(index, pixel)?);
                    for c in 0..3 {
                        sum[c] += mean[c];
                        spread[c] += variance[c];
                    }
                    pixels += 1.0;
                }
            }
            let relative = |c: usize| {
                let mean = sum[c] / pixels;
                spread[c] / pixels / (mean * mean + RELATIVE_OFFSET)
            };
            errors.push(((0..3).map(relative).sum::<f64>() / 3.0).sqrt());
        }
    }
    Some(errors)
}

/// The variance of an image whose samples depend on each other, as those of Markov chains, from batches of them:
/// what the samples between two looks at the image add up to is one draw, with a variance that is the smaller
/// the more they are (the method of batch means). Chains that mix slowly correlate batches too, and then the
/// variance is underestimated.
#[derive(Clone, Debug, Default)]
pub(super) struct Batches {
    count: u32,
    samples: f64,
    mean: Vec<[f64; 3]>,
    /// Weighted squares of distances from the mean.
    spread: Vec<[f64; 3]>,
}

/// How many batches are needed before their spread is trusted.
const FEWEST_BATCHES: u32 = 5;

impl Batches {
    /// Takes the image after `samples` samples of each pixel; what came since the last call is a batch.
    pub fn take(&mut self, film: &Film, samples: u32) {
        let pixels = film.pixels();
        self.mean.resize(pixels.len(), [0.0; 3]);
        self.spread.resize(pixels.len(), [0.0; 3]);
        let (before, now) = (self.samples, f64::from(samples));
        let new = now - before;
        for ((mean, spread), pixel) in self.mean.iter_mut().zip(&mut self.spread).zip(pixels) {
            let image = pixel.mean();
            for c in 0..3 {
                let batch = (image[c] * now - mean[c] * before) / new;
                spread[c] += (batch - mean[c]).powi(2) * new * before / now;
            }
            *mean = image;
        }
        (self.count, self.samples) = (self.count + 1, now);
    }

    /// The estimated variance of the mean of a pixel; `None` before there are enough batches.
    pub fn variance(&self, pixel: usize) -> Option<[f64; 3]> {
        let scale = 1.0 / (f64::from(self.count) - 1.0) / self.samples;
        (self.count >= FEWEST_BATCHES).then(|| self.spread[pixel].map(|s| s * scale))
    }
}

impl Stored for Batches {
    fn store(&self, to: &mut dyn Write) -> io::Result<()> {
        (self.count, self.samples).store(to)?;
        self.mean.store(to)?;
        self.spread.store(to)
    }

    fn load(from: &mut dyn Read) -> io::Result<Self> {
        let (count, samples, mean, spread) = Stored::load(from)?;
        Ok(Batches { count, samples, mean, spread })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn decisions_are_reached_one_after_another() {
        let mut done = 0;
        let all: Vec<u32> = std::iter::from_fn(|| {
            done = next_decision(done);
            Some(done)
        })
        .take(10)
        .collect();
        assert_eq!(all, [1, 2, 4, 8, 16, 32, 64, 128, 192, 256]);
        assert!(all[4..].iter().all(|n| decides_at(*n)));
        assert!([1, 8, 17, 63, 96].iter().all(|n| !decides_at(*n)));
    }

    #[test]
    fn errors_are_those_of_windows() {
        let mut film = Film::new((20, 3));
        for y in 0..3 {
            for x in 0..20 {
                let half = if x < 16 { 0.5 } else { 0.0 };
                film.pixel_mut(x, y).add([1.0 - half; 3]);
                film.pixel_mut(x, y).add([1.0 + half; 3]);
            }
        }
        let errors = window_errors(&film, |_, pixel| pixel.variance_of_mean()).unwrap();
        // Samples 0.5 and 1.5: the variance of their mean is a quarter.
        approx::assert_relative_eq!(errors[0], (0.25f64 / 1.01).sqrt(), max_relative = 1e-12);
        assert_eq!((errors[1], errors.len()), (0.0, 2));
        film.pixel_mut(0, 0).add_chained([1.0; 3]);
        assert_eq!(window_errors(&film, |_, pixel| pixel.variance_of_mean()), None);
    }

    #[test]
    fn batches_know_the_variance_of_independent_samples() {
        let mut uniforms = aether_core::Pcg32::new(7, 0, 0);
        let (mut film, mut batches) = (Film::new((2000, 1)), Batches::default());
        let mut done = 0;
        while done < 256 {
            let next = next_decision(done);
            for x in 0..2000 {
                for _ in done..next {
                    let value: f32 = aether_core::UniformSource::next(&mut uniforms);
                    film.pixel_mut(x, 0).add([value, 2.0 * value, 0.0]);
                }
            }
            done = next;
            batches.take(&film, done);
        }
        // Uniform numbers: 1/12 and 4/12, over 256. The mean over 2000 pixels with 9 degrees of freedom
        // each has a relative standard deviation of 1.1 %; five of them are one alarm in two million.
        let mean = |c: usize| {
            (0..2000).map(|p| batches.variance(p).unwrap()[c]).sum::<f64>() / 2000.0 * 256.0
        };
        approx::assert_relative_eq!(mean(0), 1.0 / 12.0, max_relative = 0.055);
        approx::assert_relative_eq!(mean(1), 4.0 / 12.0, max_relative = 0.055);
        assert_eq!(mean(2), 0.0);
    }
}
