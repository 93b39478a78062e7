//! Do two renders have the same expected value? A z-test on the means of blocks of pixels.
//!
//! Both images carry the variance of the mean of each pixel. For each block of pixels and each
//! channel, `z = (a - b) / sqrt(var a + var b)` is close to standard normal if the two renders
//! agree: a block averages many samples. Holm's correction bounds the chance of any false alarm
//! among all blocks and channels, whatever their dependence.
//!
//! Pixels are taken as independent, which holds for a box filter and for filter importance
//! sampling. Where one sample is shared among several pixels, their variances are to be given times
//! [`Film::correlation`](crate::render::Film::correlation).

use super::{ImageError, RgbImage};

/// What counts as a difference between two renders.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BlockTestOptions {
    /// The side of a block in pixels; blocks at the right and lower border may be smaller.
    pub block: usize,
    /// The chance that any block is reported although the two expected values are equal.
    pub family_alpha: f64,
    /// The relative standard error that both programs' rounding is allowed on top of the
    /// variance, so that pixels without noise need not be equal to the last bit.
    pub rounding: f64,
}

impl Default for BlockTestOptions {
    /// Blocks of 8x8 pixels, a false alarm in 10 000 comparisons, rounding of 1e-5.
    fn default() -> Self {
        Self { block: 8, family_alpha: 1e-4, rounding: 1e-5 }
    }
}

/// The comparison of one channel in one block.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BlockScore {
    /// The first column and row of the block.
    pub origin: (usize, usize),
    /// 0, 1 or 2 for red, green or blue.
    pub channel: usize,
    /// Mean of the image in the block.
    pub mean: f64,
    /// Mean of the reference in the block.
    pub reference_mean: f64,
    /// Difference of the means in standard errors; infinite where a value is not finite.
    pub z: f64,
    /// The chance of a difference at least this large.
    pub p_value: f64,
}

/// The outcome of a [`block_z_test`].
#[derive(Clone, Debug, PartialEq)]
pub struct BlockTest {
    /// The number of blocks; each is tested in three channels.
    pub blocks: usize,
    /// The number of blocks in which a channel differs significantly.
    pub failing_blocks: usize,
    /// The channel and block with the largest difference in standard errors.
    pub worst: BlockScore,
}

impl BlockTest {
    /// The largest absolute difference in standard errors.
    pub fn max_z(&self) -> f64 {
        self.worst.z.abs()
    }

    /// Whether no block differs significantly.
    pub fn passed(&self) -> bool {
        self.failing_blocks == 0
    }
}

/// Tests whether image and reference have the same expected value, given the variance of the mean
/// of each of their pixels. See the [module](self) for the method.
///
/// # Errors
/// If the four images differ in size or have no pixels.
pub fn block_z_test(
    image: &RgbImage,
    variance: &RgbImage,
    reference: &RgbImage,
    reference_variance: &RgbImage,
    options: &BlockTestOptions,
) -> Result<BlockTest, ImageError> {
    let scores = block_scores(image, variance, reference, reference_variance, options)?;
    let p_values: Vec<f64> = scores.iter().map(|score| score.p_value).collect();
    let rejected = holm(&p_values, options.family_alpha);
    // Scores come in triples, one for each channel of a block.
    let failing_blocks = rejected.chunks(3).filter(|block| block.contains(&true)).count();
    let worst = scores.iter().max_by(|a, b| a.z.abs().total_cmp(&b.z.abs()));
    let worst = *worst.ok_or(ImageError::Empty)?;
    Ok(BlockTest { blocks: scores.len() / 3, failing_blocks, worst })
}

/// The scores of all blocks, three channels each, from the top left. To correct for the number of
/// tests over several pairs of images, join their p-values and call [`holm`].
///
/// # Errors
/// If the four images differ in size or have no pixels.
pub fn block_scores(
    image: &RgbImage,
    variance: &RgbImage,
    reference: &RgbImage,
    reference_variance: &RgbImage,
    options: &BlockTestOptions,
) -> Result<Vec<BlockScore>, ImageError> {
    for other in [variance, reference, reference_variance] {
        image.check_same_size(other)?;
    }
    if image.pixels().is_empty() {
        return Err(ImageError::Empty);
    }
    let side = options.block.max(1);
    let mut scores = Vec::new();
    for y in (0..image.height()).step_by(side) {
        for x in (0..image.width()).step_by(side) {
            for channel in 0..3 {
                let mean = |i: &RgbImage| block_mean(i, (x, y), side, channel);
                let (a, b) = (mean(image), mean(reference));
                let pixels = side.min(image.width() - x) * side.min(image.height() - y);
                let noise = (mean(variance) + mean(reference_variance)) / pixels as f64;
                let z = z_score(a, b, noise, options.rounding);
                let p_value = libm::erfc(z.abs() / std::f64::consts::SQRT_2);
                let origin = (x, y);
                scores.push(BlockScore { origin, channel, mean: a, reference_mean: b, z, p_value });
            }
        }
    }
    Ok(scores)
}

/// The mean of one channel over the part of a square block that lies in the image.
fn block_mean(image: &RgbImage, origin: (usize, usize), side: usize, channel: usize) -> f64 {
    let columns = origin.0..(origin.0 + side).min(image.width());
    let rows = origin.1..(origin.1 + side).min(image.height());
    let count = columns.len() * rows.len();
    let values = rows.flat_map(|y| columns.clone().map(move |x| (x, y)));
    values.map(|(x, y)| f64::from(image.pixel(x, y)[channel])).sum::<f64>() / count as f64
}

/// The difference in standard errors; infinite if it is not a number.
fn z_score(a: f64, b: f64, variance: f64, rounding: f64) -> f64 {
    if !(a.is_finite() && b.is_finite() && variance.is_finite()) {
        return f64::INFINITY;
    }
    if a == b {
        return 0.0;
    }
    let rounding = rounding * a.abs().max(b.abs());
    (a - b) / (variance.max(0.0) + rounding * rounding).sqrt()
}

/// Which of these p-values are significant when the chance of any false alarm is to be at most
/// `alpha`: Holm's step-down procedure, valid whatever the dependence of the tests.
pub fn holm(p_values: &[f64], alpha: f64) -> Vec<bool> {
    let mut order: Vec<usize> = (0..p_values.len()).collect();
    order.sort_by(|&i, &j| p_values[i].total_cmp(&p_values[j]));
    let mut rejected = vec![false; p_values.len()];
    for (rank, &index) in order.iter().enumerate() {
        // Written so that a p-value that is not a number counts as significant.
        if p_values[index] > alpha / (p_values.len() - rank) as f64 {
            break;
        }
        rejected[index] = true;
    }
    rejected
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Standard normal numbers from a 64-bit linear congruential generator (Box and Muller).
    fn noise(seed: u64) -> impl FnMut() -> f32 {
        let mut state = seed;
        let mut uniform = move || {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
            ((state >> 11) as f64 + 0.5) / (1u64 << 53) as f64
        };
        move || {
            let radius = (-2.0 * uniform().ln()).sqrt();
            (radius * (std::f64::consts::TAU * uniform()).cos()) as f32
        }
    }

    fn noisy(seed: u64, scale: f32, deviation: f32) -> RgbImage {
        let mut normal = noise(seed);
        RgbImage::from_fn(60, 44, |x, _| {
            [1.0, 2.0, 0.5 + x as f32 / 60.0].map(|mean| scale * mean + deviation * normal())
        })
    }

    fn test(a: &RgbImage, b: &RgbImage, deviation: f32) -> BlockTest {
        let variance = RgbImage::filled(60, 44, [deviation * deviation; 3]);
        block_z_test(a, &variance, b, &variance, &BlockTestOptions::default()).unwrap()
    }

    #[test]
    fn equal_means_pass_for_every_seed() {
        for seed in 0..50 {
            let result = test(&noisy(2 * seed, 1.0, 0.02), &noisy(2 * seed + 1, 1.0, 0.02), 0.02);
            assert!(result.passed(), "seed {seed}: {result:?}");
            // 48 blocks in three channels: the largest of 144 normal numbers.
            assert_eq!(result.blocks, 48);
            assert!((1.5..5.0).contains(&result.max_z()), "seed {seed}: {result:?}");
        }
    }

    #[test]
    fn one_percent_is_found() {
        let result = test(&noisy(1, 1.01, 0.01), &noisy(2, 1.0, 0.01), 0.01);
        assert!(result.failing_blocks > 40, "{result:?}");
        let (a, b) = (noisy(1, 1.0, 0.0), noisy(1, 1.01, 0.0));
        assert_eq!(test(&a, &b, 0.0).failing_blocks, 48);
    }

    #[test]
    fn underestimated_noise_is_found() {
        let (a, b) = (noisy(3, 1.0, 0.1), noisy(4, 1.0, 0.1));
        assert!(!test(&a, &b, 0.02).passed());
    }

    #[test]
    fn rounding_without_noise_is_no_difference() {
        let a = RgbImage::filled(60, 44, [0.8; 3]);
        let b = RgbImage::filled(60, 44, [0.800_000_1; 3]);
        assert!(test(&a, &b, 0.0).passed());
        assert_eq!(test(&a, &a, 0.0).max_z(), 0.0);
    }

    #[test]
    fn holm_steps_down() {
        // 0.03 / 3 rejects the first, 0.03 / 2 the second, and 0.03 / 1 not the third.
        assert_eq!(holm(&[0.04, 0.009, 0.014], 0.03), [false, true, true]);
        // A failure stops the procedure even though 0.029 < 0.03 / 1.
        assert_eq!(holm(&[0.029, 0.02, 0.009], 0.03), [false, false, true]);
        assert!(holm(&[], 0.1).is_empty());
    }

    #[test]
    fn p_value_is_two_sided() {
        let one = |value| RgbImage::filled(1, 1, [value; 3]);
        let options = BlockTestOptions { rounding: 0.0, ..BlockTestOptions::default() };
        let scores = block_scores(&one(2.5), &one(0.0625), &one(3.0), &one(0.0), &options).unwrap();
        assert_eq!(scores[0].z, -2.0);
        approx::assert_relative_eq!(scores[0].p_value, 0.045_500_263_896, max_relative = 1e-9);
    }
}
