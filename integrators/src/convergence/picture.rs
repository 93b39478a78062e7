//! Pictures of errors, and the part of an image in which integrators differ most.

use crate::image::RgbImage;
use crate::image::compare::RELATIVE_OFFSET;

/// The squared relative error of each pixel, mean over its channels, in colours: black is 1e-4 or less, then purple, red,
/// yellow, and white 10 or more, by the logarithm.
pub fn error_picture(image: &RgbImage, reference: &RgbImage) -> RgbImage {
    RgbImage::from_fn(image.width(), image.height(), |x, y| {
        heat(((pixel_error(image, reference, x, y).log10() + 4.0) / 5.0) as f32)
    })
}

fn pixel_error(image: &RgbImage, reference: &RgbImage, x: usize, y: usize) -> f64 {
    let (a, b) = (image.pixel(x, y), reference.pixel(x, y));
    let error = |c: usize| {
        let (a, b) = (f64::from(a[c]), f64::from(b[c]));
        (a - b).powi(2) / (b * b + RELATIVE_OFFSET)
    };
    (0..3).map(error).sum::<f64>() / 3.0
}

/// Colours from dark to bright for numbers from 0 to 1, linear Rec. 709.
fn heat(value: f32) -> [f32; 3] {
    const STOPS: [[f32; 3]; 5] =
        [[0.0, 0.0, 0.0], [0.1, 0.0, 0.2], [0.7, 0.02, 0.03], [1.0, 0.6, 0.0], [1.0, 1.0, 1.0]];
    // NaN is as bad as can be.
    let value = if value.is_nan() { 1.0 } else { value.clamp(0.0, 1.0) };
    let place = value * (STOPS.len() - 1) as f32;
    let k = (place as usize).min(STOPS.len() - 2);
    let part = place - k as f32;
    [0, 1, 2].map(|c| STOPS[k][c] + part * (STOPS[k + 1][c] - STOPS[k][c]))
}

/// A part of an image: column and row of its first pixel, its width and height.
pub type Crop = (usize, usize, usize, usize);

/// The part, a third as wide and high as the image, in which the logarithms of the errors of several images differ
/// most, and which shows something: their spread counts by the contrast of the reference.
pub fn telling_crop(images: &[&RgbImage], reference: &RgbImage) -> Crop {
    let (width, height) = (reference.width(), reference.height());
    let (w, h) = ((width / 3).max(1), (height / 3).max(1));
    let mut best = (f64::NEG_INFINITY, (0, 0, w, h));
    for y in (0..=height - h).step_by((h / 3).max(1)) {
        for x in (0..=width - w).step_by((w / 3).max(1)) {
            let error = |image: &&RgbImage| {
                let pixels = (y..y + h).flat_map(|y| (x..x + w).map(move |x| (x, y)));
                let sum: f64 =
                    pixels.map(|(x, y)| pixel_error(image, reference, x, y).min(10.0)).sum();
                (sum / (w * h) as f64 + 1e-6).ln()
            };
            let errors: Vec<f64> = images.iter().map(error).collect();
            let mean = errors.iter().sum::<f64>() / errors.len().max(1) as f64;
            let spread: f64 = errors.iter().map(|e| (e - mean).powi(2)).sum();
            let score = spread * (0.05 + contrast(reference, (x, y, w, h)));
            if score > best.0 {
                best = (score, (x, y, w, h));
            }
        }
    }
    best.1
}

/// The standard deviation of what is shown of a part of an image.
fn contrast(image: &RgbImage, part: Crop) -> f64 {
    let shown =
        |pixel: &[f32; 3]| f64::from(pixel.iter().sum::<f32>() / 3.0).clamp(0.0, 1.0).sqrt();
    let values: Vec<f64> = cut(image, part).pixels().iter().map(shown).collect();
    let n = values.len() as f64;
    let mean = values.iter().sum::<f64>() / n;
    (values.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / n).sqrt()
}

/// The part of an image.
pub fn cut(image: &RgbImage, (x, y, width, height): Crop) -> RgbImage {
    RgbImage::from_fn(width, height, |column, row| image.pixel(x + column, y + row))
}

/// The mean of several images of one size.
pub fn mean(images: &[&RgbImage]) -> Option<RgbImage> {
    let first = images.first()?;
    Some(RgbImage::from_fn(first.width(), first.height(), |x, y| {
        [0, 1, 2].map(|c| {
            let sum: f64 = images.iter().map(|image| f64::from(image.pixel(x, y)[c])).sum();
            (sum / images.len() as f64) as f32
        })
    }))
}
