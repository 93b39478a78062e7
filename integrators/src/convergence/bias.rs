//! What the images of several seeds say together: the variance of an image, and its bias.

use crate::image::RgbImage;
use crate::image::compare::RELATIVE_OFFSET;

use super::reference::Reference;
use super::statistics::{Interval, Sums, jackknife};

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
    let variance = jackknife(images.len(), |left_out| pixels.variance(left_out))?;
    let bias = jackknife(images.len(), |left_out| pixels.bias(left_out))?;
    let coarse = jackknife(images.len(), |left_out| blocks.bias(left_out))?;
    let exceeds = |bias: Interval, floor: f64| bias.low > 2.0 * floor + ROUNDING * ROUNDING;
    let biased = exceeds(bias, pixels.floor) || exceeds(coarse, blocks.floor);
    Some(Spread { variance, bias, biased })
}

/// Means of products of differences dᵢ = xᵢ - r between images and the reference. What all pairs add up to follows from the sum
/// of all images, so that there is no work for each pair.
struct Level {
    /// Of dᵢ with itself.
    squares: Sums,
    /// Of dᵢ with the sum of all others.
    with_others: Vec<f64>,
    /// Half the sum of those: of all pairs.
    pairs: f64,
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
        images: impl Iterator<Item = Vec<f64>> + Clone,
        reference: &[f64],
        noise: Option<Vec<f64>>,
    ) -> Self {
        let scale: Vec<f64> = reference.iter().map(|r| 1.0 / (r * r + RELATIVE_OFFSET)).collect();
        let n = reference.len() as f64;
        let mut sum = vec![0.0; reference.len()];
        for image in images.clone() {
            sum.iter_mut().zip(image).zip(reference).for_each(|((sum, x), r)| *sum += x - r);
        }
        let (mut squares, mut with_others) = (Vec::new(), Vec::new());
        for image in images {
            let (mut square, mut product) = (0.0, 0.0);
            for (((x, r), sum), s) in image.iter().zip(reference).zip(&sum).zip(&scale) {
                let d = x - r;
                square += d * d * s;
                product += d * (sum - d) * s;
            }
            squares.push(square / n);
            with_others.push(product / n);
        }
        let pairs = 0.5 * with_others.iter().sum::<f64>();
        let floor =
            noise.map_or(0.0, |v| v.iter().zip(&scale).map(|(v, s)| v * s).sum::<f64>() / n);
        Level { squares: Sums::of(&squares), with_others, pairs, floor }
    }

    /// The mean product of pairs of different seeds, without one of them: the square of the bias.
    fn bias(&self, left_out: Option<usize>) -> Option<f64> {
        let pairs = self.pairs - left_out.map_or(0.0, |k| self.with_others[k]);
        let seeds = (self.with_others.len() - usize::from(left_out.is_some())) as f64;
        let mean = pairs / (0.5 * seeds * (seeds - 1.0));
        mean.is_finite().then_some(mean)
    }

    /// The mean of (dᵢ - dⱼ)² / 2 over pairs of different seeds, without one of them.
    fn variance(&self, left_out: Option<usize>) -> Option<f64> {
        let variance = self.squares.mean_without(left_out) - self.bias(left_out)?;
        variance.is_finite().then_some(variance)
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

#[cfg(test)]
mod tests {
    use super::*;

    fn images(count: usize, pixel: impl Fn(usize, usize) -> f32) -> Vec<RgbImage> {
        let image = |k| RgbImage::from_fn(3, 2, |x, y| [pixel(k, 2 * x + y), 1.5, 0.5]);
        (0..count).map(image).collect()
    }

    fn reference() -> Reference {
        let image = RgbImage::from_fn(3, 2, |x, y| [1.0 + x as f32, 1.0, 0.25 * y as f32]);
        Reference { image, variance: None, made_by: String::new(), doubts: Vec::new() }
    }

    /// Means over all pairs, as they are defined, with the intervals of leaving out one seed after another.
    #[test]
    fn pairs_are_those_of_the_definition() {
        let images = images(5, |k, pixel| ((7 * k + 3 * pixel) % 11) as f32 * 0.25);
        let reference = reference();
        let mean = |seeds: &[usize], of: fn([f64; 3]) -> f64| {
            let (mut sum, mut count) = (0.0, 0);
            for (i, j) in seeds.iter().flat_map(|i| seeds.iter().map(move |j| (*i, *j))) {
                let values = [&images[i], &images[j], &reference.image]
                    .map(|image| image.pixels().iter().flatten().map(|v| f64::from(*v)));
                let [a, b, r] = values;
                for ((a, b), r) in a.zip(b).zip(r).filter(|_| i < j) {
                    sum += of([a, b, r]) / (r * r + RELATIVE_OFFSET);
                    count += 1;
                }
            }
            sum / f64::from(count)
        };
        let expected = |of: fn([f64; 3]) -> f64| {
            jackknife(5, |left_out| {
                let seeds: Vec<usize> = (0..5).filter(|k| Some(*k) != left_out).collect();
                Some(mean(&seeds, of))
            })
            .unwrap()
        };
        let found = spread(&images.iter().collect::<Vec<_>>(), &reference).unwrap();
        let cases = [
            (found.bias, expected(|[a, b, r]| (a - r) * (b - r))),
            (found.variance, expected(|[a, b, _]| 0.5 * (a - b).powi(2))),
        ];
        for (found, expected) in cases {
            for (found, expected) in [
                (found.value, expected.value),
                (found.low, expected.low),
                (found.high, expected.high),
            ] {
                approx::assert_relative_eq!(found, expected, max_relative = 1e-12);
            }
        }
    }

    /// With work for each pair of them, and each that is left out, this would never end.
    #[test]
    fn many_seeds_are_no_more_work_than_their_images() {
        let images = images(50_000, |k, pixel| if (k + pixel) % 2 == 0 { 1.0 } else { 2.0 });
        let found = spread(&images.iter().collect::<Vec<_>>(), &reference()).unwrap();
        // One channel in three varies, by a half, over the squares of 1, 2 and 3.
        let expected = 0.25 / 9.0 * (1.0 / 1.01 + 1.0 / 4.01 + 1.0 / 9.01);
        approx::assert_relative_eq!(found.variance.value, expected, max_relative = 1e-4);
    }

    #[test]
    fn what_is_no_number_has_no_spread() {
        let images = images(4, |k, _| if k == 2 { f32::NAN } else { 1.0 });
        assert_eq!(spread(&images.iter().collect::<Vec<_>>(), &reference()), None);
    }
}
