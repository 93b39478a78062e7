//! From an image and its gradients, each with noise, to one image: the screened Poisson equation (Bhat, Curless,
//! Cohen and Zitnick 2008; Kettunen et al. 2015, section 2).
//!
//! Sought is the image I for which a norm of α (I - image) and of the differences of neighbouring pixels of I from
//! the gradients is least. In the norm L2 the result is linear in what is given, so that it is unbiased if that is.
//! In the norm L1 it follows outliers less, which is worth much with the heavy tails of light transport,
//! but is biased.

use crate::image::RgbImage;

/// How an image is made of its gradients.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Reconstruction {
    /// By least absolute deviations: least noise, biased.
    #[default]
    L1,
    /// By least squares: unbiased.
    L2,
    /// Not at all: the image as it was sampled.
    None,
}

impl std::str::FromStr for Reconstruction {
    type Err = String;

    fn from_str(name: &str) -> Result<Self, String> {
        match name {
            "l1" => Ok(Self::L1),
            "l2" => Ok(Self::L2),
            "none" => Ok(Self::None),
            _ => Err("expected l1, l2 or none".to_owned()),
        }
    }
}

/// The weight of the image against its gradients, α in Kettunen et al. 2015.
pub const ALPHA: f64 = 0.2;

/// How often the weights of L1 are computed anew, and how small a deviation they can still tell from zero at
/// first, relative to the mean of the image; each time by half of that.
const REWEIGHTINGS: usize = 20;
const FIRST_DEVIATION: f64 = 0.05;
/// At most so many steps of conjugate gradients, and where they end, relative to the start.
const MOST_STEPS: usize = 1000;
const RESIDUAL: f64 = 1e-7;
/// The same for each of the least squares problems of L1, which start from the result of the one before.
const STEPS_WEIGHTED: usize = 50;

type Pixel = [f64; 3];

/// The image that fits `image` and the gradients best: `dx` is the right neighbour minus the pixel, `dy` the lower
/// neighbour minus the pixel. The last column of `dx` and the last row of `dy`, which lead out of the image, do
/// not matter; at its borders nothing else is assumed.
///
/// # Panics
/// If the sizes differ.
pub fn reconstruct(
    image: &RgbImage,
    [dx, dy]: [&RgbImage; 2],
    alpha: f64,
    reconstruction: Reconstruction,
) -> RgbImage {
    let (width, height) = (image.width(), image.height());
    for other in [dx, dy] {
        assert_eq!((other.width(), other.height()), (width, height), "images of one size");
    }
    let wide = |image: &RgbImage| -> Vec<Pixel> {
        image.pixels().iter().map(|pixel| pixel.map(f64::from)).collect()
    };
    let problem = Problem { width, height, alpha, given: [wide(image), wide(dx), wide(dy)] };
    let result = match reconstruction {
        Reconstruction::None => return image.clone(),
        Reconstruction::L2 => problem.least_squares(),
        Reconstruction::L1 => problem.least_deviations(),
    };
    RgbImage::from_fn(width, height, |x, y| result[y * width + x].map(|v| v as f32))
}

/// What is given: values of pixels and of differences.
struct Problem {
    width: usize,
    height: usize,
    alpha: f64,
    /// The image, and the differences to the right and down.
    given: [Vec<Pixel>; 3],
}

/// How much each of the given numbers counts.
type Weights = [Vec<f64>; 3];

impl Problem {
    fn least_squares(&self) -> Vec<Pixel> {
        let weights = self.weights(|_| 1.0, &self.given);
        let mut image = self.given[0].clone();
        self.solve(&weights, &mut image, MOST_STEPS);
        image
    }

    /// By iteratively reweighted least squares.
    fn least_deviations(&self) -> Vec<Pixel> {
        let mean = self.given[0].iter().flatten().map(|v| v.abs()).sum::<f64>()
            / (3 * self.given[0].len()).max(1) as f64;
        let mut image = self.least_squares();
        let mut smallest = FIRST_DEVIATION * mean;
        // Of a black image there is nothing to improve.
        if smallest.is_nan() || smallest <= 0.0 {
            return image;
        }
        for _ in 0..REWEIGHTINGS {
            let deviations = self.deviations(&image);
            let weights = self.weights(|size| 1.0 / (size + smallest), &deviations);
            self.solve(&weights, &mut image, STEPS_WEIGHTED);
            smallest = (0.5 * smallest).max(1e-6 * mean);
        }
        image
    }

    /// Whether a pixel has a neighbour to its right (1) or below it (2); of the image itself (0), always.
    fn has(&self, part: usize, pixel: usize) -> bool {
        match part {
            1 => pixel % self.width + 1 < self.width,
            2 => pixel / self.width + 1 < self.height,
            _ => true,
        }
    }

    /// How far away the neighbour is, in pixels.
    fn step(&self, part: usize) -> usize {
        if part == 1 { 1 } else { self.width }
    }

    /// The weights of all numbers by how large a deviation there is; zero of what leads out of the image.
    fn weights(&self, weight: impl Fn(f64) -> f64, deviations: &[Vec<Pixel>; 3]) -> Weights {
        std::array::from_fn(|part| {
            let scale = if part == 0 { self.alpha } else { 1.0 };
            let of = |(pixel, deviation): (usize, &Pixel)| {
                if !self.has(part, pixel) {
                    return 0.0;
                }
                let size = deviation.iter().map(|v| v * v).sum::<f64>().sqrt();
                // The scale counts in the deviation itself, squared in the equations.
                scale * scale * weight(scale * size)
            };
            deviations[part].iter().enumerate().map(of).collect()
        })
    }

    /// The values of an image and its differences minus what is given.
    fn deviations(&self, image: &[Pixel]) -> [Vec<Pixel>; 3] {
        std::array::from_fn(|part| {
            let value = |pixel: usize| match part {
                0 => image[pixel],
                _ if self.has(part, pixel) => {
                    let next = pixel + self.step(part);
                    std::array::from_fn(|c| image[next][c] - image[pixel][c])
                }
                _ => self.given[part][pixel],
            };
            let given = &self.given[part];
            let deviation = |pixel: usize| {
                let value = value(pixel);
                std::array::from_fn(|c| value[c] - given[pixel][c])
            };
            (0..image.len()).map(deviation).collect()
        })
    }

    /// The gradient of half the weighted sum of squares, given the deviations.
    fn gradient(&self, weights: &Weights, deviations: &[Vec<Pixel>; 3]) -> Vec<Pixel> {
        let mut sum = vec![[0.0; 3]; deviations[0].len()];
        for part in 0..3 {
            for pixel in (0..sum.len()).filter(|pixel| self.has(part, *pixel)) {
                for c in 0..3 {
                    let pull = weights[part][pixel] * deviations[part][pixel][c];
                    if part == 0 {
                        sum[pixel][c] += pull;
                    } else {
                        sum[pixel][c] -= pull;
                        sum[pixel + self.step(part)][c] += pull;
                    }
                }
            }
        }
        sum
    }

    /// Improves an image until the weighted sum of squares is least, by conjugate gradients, each channel on its
    /// own.
    fn solve(&self, weights: &Weights, image: &mut [Pixel], most: usize) {
        // Without what is given, the gradient is the matrix of the equations.
        let homogeneous =
            Problem { given: std::array::from_fn(|_| vec![[0.0; 3]; image.len()]), ..*self };
        let times = |v: &[Pixel]| homogeneous.gradient(weights, &homogeneous.deviations(v));
        let mut residual = self.gradient(weights, &self.deviations(image));
        residual.iter_mut().flatten().for_each(|v| *v = -*v);
        let mut direction = residual.clone();
        let mut squares = dot(&residual, &residual);
        let end = squares.map(|s| s * RESIDUAL * RESIDUAL);
        for _ in 0..most {
            if (0..3).all(|c| squares[c] <= end[c]) {
                break;
            }
            let moved = times(&direction);
            let curvature = dot(&direction, &moved);
            let length: Pixel = std::array::from_fn(|c| quotient(squares[c], curvature[c]));
            for (pixel, value) in image.iter_mut().enumerate() {
                for c in 0..3 {
                    value[c] += length[c] * direction[pixel][c];
                    residual[pixel][c] -= length[c] * moved[pixel][c];
                }
            }
            let next = dot(&residual, &residual);
            let share: Pixel = std::array::from_fn(|c| quotient(next[c], squares[c]));
            for (pixel, value) in direction.iter_mut().enumerate() {
                for c in 0..3 {
                    value[c] = residual[pixel][c] + share[c] * value[c];
                }
            }
            squares = next;
        }
    }
}

/// Zero over zero is zero: that channel is done.
fn quotient(a: f64, b: f64) -> f64 {
    if b > 0.0 { a / b } else { 0.0 }
}

/// The inner products of each channel.
fn dot(a: &[Pixel], b: &[Pixel]) -> Pixel {
    let mut sum = [0.0; 3];
    for (a, b) in a.iter().zip(b) {
        (0..3).for_each(|c| sum[c] += a[c] * b[c]);
    }
    sum
}

#[cfg(test)]
mod tests {
    use super::*;
    use aether_core::{Pcg32, UniformSource};

    fn noise(width: usize, height: usize, seed: u64) -> RgbImage {
        let mut uniforms = Pcg32::new(seed, 0, 0);
        RgbImage::from_fn(width, height, |_, _| {
            [(); 3].map(|()| UniformSource::<f32>::next(&mut uniforms))
        })
    }

    /// The differences of an image to the right and down.
    fn differences(image: &RgbImage) -> [RgbImage; 2] {
        let of = |dx: usize, dy: usize| {
            RgbImage::from_fn(image.width(), image.height(), |x, y| {
                if x + dx >= image.width() || y + dy >= image.height() {
                    return [7.0; 3];
                }
                let (a, b) = (image.pixel(x, y), image.pixel(x + dx, y + dy));
                std::array::from_fn(|c| b[c] - a[c])
            })
        };
        [of(1, 0), of(0, 1)]
    }

    fn assert_close(a: &RgbImage, b: &RgbImage, tolerance: f32) {
        for (p, q) in a.pixels().iter().flatten().zip(b.pixels().iter().flatten()) {
            assert!((p - q).abs() <= tolerance, "{p} {q}");
        }
    }

    /// The normal equations of one channel, solved by elimination.
    fn direct(image: &RgbImage, [dx, dy]: [&RgbImage; 2], alpha: f64, c: usize) -> Vec<f64> {
        let (width, height) = (image.width(), image.height());
        let n = width * height;
        let mut rows = vec![vec![0.0; n + 1]; n];
        let mut observe = |entries: &[(usize, f64)], value: f64| {
            for (i, a) in entries {
                entries.iter().for_each(|(j, b)| rows[*i][*j] += a * b);
                rows[*i][n] += a * value;
            }
        };
        for (x, y) in (0..height).flat_map(|y| (0..width).map(move |x| (x, y))) {
            let pixel = y * width + x;
            let value = |image: &RgbImage| f64::from(image.pixel(x, y)[c]);
            observe(&[(pixel, alpha)], alpha * value(image));
            if x + 1 < width {
                observe(&[(pixel, -1.0), (pixel + 1, 1.0)], value(dx));
            }
            if y + 1 < height {
                observe(&[(pixel, -1.0), (pixel + width, 1.0)], value(dy));
            }
        }
        for i in 0..n {
            let pivot = rows[i].clone();
            for row in rows.iter_mut().skip(i + 1) {
                let factor = row[i] / pivot[i];
                row.iter_mut().zip(&pivot).for_each(|(a, b)| *a -= factor * b);
            }
        }
        let mut solution = vec![0.0; n];
        for i in (0..n).rev() {
            let known: f64 = (i + 1..n).map(|j| rows[i][j] * solution[j]).sum();
            solution[i] = (rows[i][n] - known) / rows[i][i];
        }
        solution
    }

    #[test]
    fn least_squares_agree_with_elimination() {
        for (width, height) in [(7, 5), (1, 6), (6, 1), (1, 1)] {
            let (image, dx, dy) =
                (noise(width, height, 1), noise(width, height, 2), noise(width, height, 3));
            let found = reconstruct(&image, [&dx, &dy], ALPHA, Reconstruction::L2);
            for c in 0..3 {
                let expected = direct(&image, [&dx, &dy], ALPHA, c);
                for (i, value) in expected.iter().enumerate() {
                    let found = f64::from(found.pixel(i % width, i / width)[c]);
                    assert!((found - value).abs() < 1e-5, "{found} {value}");
                }
            }
        }
    }

    #[test]
    fn an_image_is_made_of_its_own_gradients() {
        for kind in [Reconstruction::L1, Reconstruction::L2, Reconstruction::None] {
            for image in [
                noise(9, 6, 4),
                RgbImage::filled(4, 3, [0.0; 3]),
                RgbImage::filled(4, 3, [2.0, 0.0, 1e4]),
            ] {
                let [dx, dy] = differences(&image);
                let found = reconstruct(&image, [&dx, &dy], ALPHA, kind);
                assert_close(&found, &image, 1e-5 * image.pixel(0, 0)[2].max(1.0));
            }
        }
    }

    #[test]
    fn an_outlier_is_spread_by_least_squares_and_rejected_by_least_deviations() {
        let truth = noise(12, 12, 5);
        let [dx, dy] = differences(&truth);
        let mut image = truth.clone();
        image.pixels_mut()[6 * 12 + 6] = [100.0; 3];
        let largest = |found: &RgbImage| {
            let pairs = found.pixels().iter().flatten().zip(truth.pixels().iter().flatten());
            pairs.map(|(a, b)| (a - b).abs()).fold(0.0, f32::max)
        };
        assert!(largest(&reconstruct(&image, [&dx, &dy], ALPHA, Reconstruction::L2)) > 0.5);
        assert!(largest(&reconstruct(&image, [&dx, &dy], ALPHA, Reconstruction::L1)) < 0.01);
        assert_eq!(reconstruct(&image, [&dx, &dy], ALPHA, Reconstruction::None), image);
    }

    #[test]
    fn the_mean_is_that_of_the_image() {
        // Gradients say nothing about it.
        let (image, dx, dy) = (noise(16, 9, 6), noise(16, 9, 7), noise(16, 9, 8));
        let mean = |image: &RgbImage| {
            image.pixels().iter().flatten().map(|v| f64::from(*v)).sum::<f64>() / 432.0
        };
        let found = reconstruct(&image, [&dx, &dy], ALPHA, Reconstruction::L2);
        assert!((mean(&found) - mean(&image)).abs() < 1e-5);
    }

    #[test]
    fn names() {
        assert_eq!("l2".parse(), Ok(Reconstruction::L2));
        assert!("L3".parse::<Reconstruction>().is_err());
    }
}
