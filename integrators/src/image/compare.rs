//! Error measures between an image and a reference, both linear Rec. 709.

use super::block_test::{BlockTest, BlockTestOptions, block_z_test};
use super::exr::Exr;
use super::flip::flip;
use super::{ImageError, RgbImage, is_finite};

/// What is added to the squared reference in relMSE, so that dark pixels do not decide alone.
pub const RELATIVE_OFFSET: f64 = 0.01;

/// How far an image is from its reference: the error measures of the whole program.
///
/// Pixels where either is NaN or infinite are left out of all measures (FLIP takes them as black
/// in both), and counted.
#[derive(Clone, Debug, PartialEq)]
pub struct Comparison {
    /// Number of columns and rows.
    pub size: (usize, usize),
    /// Pixels of the image with a channel that is NaN or infinite.
    pub non_finite_pixels: usize,
    /// Pixels of the reference with a channel that is NaN or infinite.
    pub non_finite_reference_pixels: usize,
    /// Square root of the mean squared difference over pixels and channels.
    pub rmse: f64,
    /// Mean over pixels and channels of `(x - r)² / (r² + 0.01)`; nothing is trimmed.
    pub rel_mse: f64,
    /// Symmetric mean absolute error, in [0, 1] for positive images: the mean over pixels and channels of
    /// `|x - r| / (|x| + |r| + 0.01)` (Vogels et al., *Denoising with Kernel Prediction and Asymmetric Loss
    /// Functions*, ACM Trans. Graph. 37(4), 2018, section 4).
    pub smape: f64,
    /// Peak signal-to-noise ratio in dB. The peak is 1: both images are clamped to [0, 1], in
    /// linear light, and the ratio is `-10 log10` of their mean squared difference. Infinite if
    /// they are equal.
    pub psnr: f64,
    /// Mean of the image over the mean of the reference; 1 if both are zero.
    pub mean_ratio: f64,
    /// Perceived difference in [0, 1] between the images as they are shown, clamped to [0, 1]: see [`flip`].
    pub flip: f64,
    /// Whether the expected values agree, if both images carry their variance.
    pub block_test: Option<BlockTest>,
}

/// Compares two files that have been read, with the [`block_z_test`] if both carry variances.
///
/// # Errors
/// If they differ in size, have no pixels, or no pixel is finite in both.
pub fn compare(image: &Exr, reference: &Exr) -> Result<Comparison, ImageError> {
    let mut comparison = compare_pixels(&image.rgb, &reference.rgb)?;
    let variances = [image, reference].map(Exr::variance_in_means);
    if let [Some(variance), Some(reference_variance)] = variances {
        let options = BlockTestOptions::default();
        let (a, b) = (&image.rgb, &reference.rgb);
        let test = block_z_test(a, &variance, b, &reference_variance, &options)?;
        comparison.block_test = Some(test);
    }
    Ok(comparison)
}

/// Compares two images of which no variance is known.
///
/// # Errors
/// If they differ in size, have no pixels, or no pixel is finite in both.
pub fn compare_pixels(image: &RgbImage, reference: &RgbImage) -> Result<Comparison, ImageError> {
    image.check_same_size(reference)?;
    let values: Vec<(f64, f64)> = (image.pixels().iter())
        .zip(reference.pixels())
        .filter(|(a, b)| is_finite(a) && is_finite(b))
        .flat_map(|(a, b)| [0, 1, 2].map(|c| (f64::from(a[c]), f64::from(b[c]))))
        .collect();
    if image.pixels().is_empty() {
        return Err(ImageError::Empty);
    }
    if values.is_empty() {
        return Err(ImageError::NothingFinite);
    }
    let mean = |term: fn(f64, f64) -> f64| {
        values.iter().map(|&(x, r)| term(x, r)).sum::<f64>() / values.len() as f64
    };
    let shown_mse = mean(|x, r| (x.clamp(0.0, 1.0) - r.clamp(0.0, 1.0)).powi(2));
    Ok(Comparison {
        size: (image.width(), image.height()),
        non_finite_pixels: image.non_finite_pixels(),
        non_finite_reference_pixels: reference.non_finite_pixels(),
        rmse: mean(|x, r| (x - r).powi(2)).sqrt(),
        rel_mse: mean(|x, r| (x - r).powi(2) / (r * r + RELATIVE_OFFSET)),
        smape: mean(|x, r| (x - r).abs() / (x.abs() + r.abs() + 0.01)),
        // The sum with 0 turns -0 dB into 0 dB.
        psnr: -10.0 * shown_mse.log10() + 0.0,
        mean_ratio: ratio(mean(|x, _| x), mean(|_, r| r)),
        flip: flip(image, reference)?,
        block_test: None,
    })
}

fn ratio(mean: f64, reference: f64) -> f64 {
    if mean == reference { 1.0 } else { mean / reference }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn exr(rgb: RgbImage, variance: Option<RgbImage>) -> Exr {
        Exr { rgb, variance, layers: Default::default(), attributes: Default::default() }
    }

    #[test]
    fn identical_images() {
        let image = RgbImage::from_fn(20, 10, |x, y| [x as f32, y as f32, 0.5]);
        let same = compare_pixels(&image, &image).unwrap();
        assert_eq!((same.rmse, same.rel_mse, same.mean_ratio, same.flip), (0.0, 0.0, 1.0, 0.0));
        assert_eq!(same.psnr, f64::INFINITY);
        assert_eq!(same.block_test, None);
        let black = RgbImage::filled(4, 4, [0.0; 3]);
        assert_eq!(compare_pixels(&black, &black).unwrap().mean_ratio, 1.0);
    }

    #[test]
    fn constant_offset() {
        let reference = RgbImage::filled(16, 16, [0.5; 3]);
        let image = RgbImage::filled(16, 16, [0.75; 3]);
        let result = compare_pixels(&image, &reference).unwrap();
        assert_eq!(result.rmse, 0.25);
        approx::assert_relative_eq!(result.rel_mse, 0.0625 / 0.26, max_relative = 1e-14);
        approx::assert_relative_eq!(result.smape, 0.25 / 1.26, max_relative = 1e-14);
        approx::assert_relative_eq!(result.psnr, 12.041_199_826_559_25, max_relative = 1e-14);
        assert_eq!(result.mean_ratio, 1.5);
        assert!(result.flip > 0.0);
    }

    #[test]
    fn values_beyond_the_display_do_not_count_for_psnr() {
        let reference = RgbImage::filled(4, 4, [8.0; 3]);
        let image = RgbImage::filled(4, 4, [9.0; 3]);
        let result = compare_pixels(&image, &reference).unwrap();
        assert_eq!((result.psnr, result.flip, result.rmse), (f64::INFINITY, 0.0, 1.0));
    }

    #[test]
    fn broken_pixels_are_counted_and_left_out() {
        let reference = RgbImage::filled(8, 8, [0.5; 3]);
        let mut image = reference.clone();
        image.pixels_mut()[3][1] = f32::NAN;
        image.pixels_mut()[9][0] = f32::INFINITY;
        let result = compare_pixels(&image, &reference).unwrap();
        assert_eq!((result.non_finite_pixels, result.non_finite_reference_pixels), (2, 0));
        assert_eq!((result.rmse, result.flip), (0.0, 0.0));

        let zero = RgbImage::filled(8, 8, [0.0; 3]);
        let (a, b) = (exr(image, Some(zero.clone())), exr(reference, Some(zero)));
        let test = compare(&a, &b).unwrap().block_test.unwrap();
        assert_eq!((test.failing_blocks, test.max_z()), (1, f64::INFINITY));

        let nothing = RgbImage::filled(8, 8, [f32::NAN; 3]);
        let error = compare_pixels(&nothing, &b.rgb).unwrap_err();
        assert!(matches!(error, ImageError::NothingFinite));
    }

    #[test]
    fn sizes_must_match() {
        let error =
            compare_pixels(&RgbImage::filled(4, 3, [0.0; 3]), &RgbImage::filled(3, 4, [0.0; 3]));
        assert!(error.unwrap_err().to_string().contains("4x3 against 3x4"));
    }
}
