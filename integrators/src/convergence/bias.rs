//! What the images of several seeds say together: the variance of an image, and its bias.

use crate::image::RgbImage;
use crate::image::compare::RELATIVE_OFFSET;

use super::reference::Reference;
use super::statistics::{Interval, jackknife};

/// The side of the blocks in which a smooth bias shows although pixels are noisy.
const BLOCK: usize = 8;
/// The relative rounding of images that is no bias.
const ROUNDING: f64 = 1e-5;

/// Variance and bias of an integrator.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Spread {
    /// Relative variance of an image, in the units of relMSE, with its interval.
    pub variance: Interval,
    /// Relative squared bias against the reference, with its interval. The reference's own error is part of it.
    pub bias: Interval,
    /// Whether pixels or blocks of them differ from the reference by more than its error explains.
    pub biased: bool,
}

/// Compares the images of several seeds, all with the same number of samples, with each other and with the
/// reference. `None` for fewer than three.
///
/// For two seeds i and j, the expected value of (xᵢ - r)(xⱼ - r) is the square of the bias, whatever the noise,
/// since the seeds are independent; that of (xᵢ - xⱼ)² / 2 is the variance. Both are averaged over pixels,
/// channels and pairs, over r² + 0.01 as in relMSE. The interval is that of the jackknife over seeds, so that it
/// does not matter how pixels depend on each other. The error of the reference adds its square, the *floor*, to the
/// bias: what counts as bias exceeds twice the floor at the lower end of its interval, be it in pixels or in
/// means of 8x8 pixels.
pub fn spread(images: &[&RgbImage], reference: &Reference) -> Option<Spread> {
    let pixels = Level::pixels(images, reference);
    let blocks = Level::blocks(images, reference);
    let variance = jackknife(images.len(), |seeds| pixels.variance(seeds))?;
    let bias = jackknife(images.len(), |seeds| pixels.bias(seeds))?;
    let coarse = jackknife(images.len(), |seeds| blocks.bias(seeds))?;
    let exceeds = |bias: Interval, floor: f64| bias.low > 2.0 * floor + ROUNDING * ROUNDING;
    let biased = exceeds(bias, pixels.floor) || exceeds(coarse, blocks.floor);
    Some(Spread { variance, bias, biased })
}

/// Means of products of differences between images, for all pairs.
struct Level {
    /// Of xᵢ - r and xⱼ - r.
    products: Vec<Vec<f64>>,
    floor: f64,
}

impl Level {
    fn pixels(images: &[&RgbImage], reference: &Reference) -> Self {
        let values = |image: &RgbImage| -> Vec<f64> {
            image.pixels().iter().flatten().map(|v| f64::from(*v)).collect()
        };
        let noise = reference.variance.as_ref().map(values);
        Self::new(images.iter().map(|image| values(image)), &values(&reference.image), noise)
    }

    fn blocks(images: &[&RgbImage], reference: &Reference) -> Self {
        let noise = reference.variance.as_ref().map(|v| block_sums(v, 2));
        let images = images.iter().map(|image| block_sums(image, 1));
        Self::new(images, &block_sums(&reference.image, 1), noise)
    }

    fn new(
        images: impl Iterator<Item = Vec<f64>>,
        reference: &[f64],
        noise: Option<Vec<f64>>,
    ) -> Self {
        let scale: Vec<f64> = reference.iter().map(|r| 1.0 / (r * r + RELATIVE_OFFSET)).collect();
        let n = reference.len() as f64;
        let errors: Vec<Vec<f64>> =
            images.map(|image| image.iter().zip(reference).map(|(x, r)| x - r).collect()).collect();
        let product = |a: &Vec<f64>, b: &Vec<f64>| {
            a.iter().zip(b).zip(&scale).map(|((a, b), s)| a * b * s).sum::<f64>() / n
        };
        let row = |a: &Vec<f64>| errors.iter().map(|b| product(a, b)).collect();
        let products = errors.iter().map(row).collect();
        let floor =
            noise.map_or(0.0, |v| v.iter().zip(&scale).map(|(v, s)| v * s).sum::<f64>() / n);
        Level { products, floor }
    }

    /// The mean over pairs of different seeds.
    fn over_pairs(seeds: &[usize], of: impl Fn(usize, usize) -> f64) -> Option<f64> {
        let pairs = seeds.iter().flat_map(|i| seeds.iter().map(move |j| (*i, *j)));
        let values: Vec<f64> = pairs.filter(|(i, j)| i < j).map(|(i, j)| of(i, j)).collect();
        let mean = values.iter().sum::<f64>() / values.len() as f64;
        mean.is_finite().then_some(mean)
    }

    fn bias(&self, seeds: &[usize]) -> Option<f64> {
        Self::over_pairs(seeds, |i, j| self.products[i][j])
    }

    fn variance(&self, seeds: &[usize]) -> Option<f64> {
        let p = &self.products;
        Self::over_pairs(seeds, |i, j| 0.5 * (p[i][i] + p[j][j]) - p[i][j])
    }
}

/// The sum over each block and channel, over the number of its pixels to a power.
fn block_sums(image: &RgbImage, power: i32) -> Vec<f64> {
    let (width, height) = (image.width(), image.height());
    let mut sums = Vec::new();
    for y in (0..height).step_by(BLOCK) {
        for x in (0..width).step_by(BLOCK) {
            let (columns, rows) = (x..width.min(x + BLOCK), y..height.min(y + BLOCK));
            let count = (columns.len() * rows.len()) as f64;
            for c in 0..3 {
                let pixels = rows.clone().flat_map(|y| columns.clone().map(move |x| (x, y)));
                let sum: f64 = pixels.map(|(x, y)| f64::from(image.pixel(x, y)[c])).sum();
                sums.push(sum / count.powi(power));
            }
        }
    }
    sums
}
