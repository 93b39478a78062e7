//! LDR-FLIP: the difference that a viewer perceives who flips between two images.
//!
//! After Andersson, Nilsson, Akenine-Möller, Oskarsson, Åström and Fairchild, *FLIP: A Difference
//! Evaluator for Alternating Images*, Proc. ACM Comput. Graph. Interact. Tech. 3(2), 2020. Both
//! images are blurred by the contrast sensitivity of the eye in the opponent space YCxCz and
//! compared in L*a*b* with Hunt's adjustment under the HyAB distance; the colour difference is
//! then amplified where edges or points appear in one image only.
//!
//! The images are linear and shown by clamping to [0, 1]. They are seen at
//! [`PIXELS_PER_DEGREE`], a 0.7 m wide monitor of 3840 pixels at a distance of 0.7 m.

use std::f64::consts::PI;

use super::{ImageError, RgbImage, is_finite};

/// Pixels per degree of visual angle.
pub const PIXELS_PER_DEGREE: f64 = 67.0;

/// Exponent, breakpoint and value at the breakpoint of the map from colour distance to error.
const COLOUR_EXPONENT: f32 = 0.7;
const COLOUR_BREAK: f32 = 0.4;
const COLOUR_BREAK_ERROR: f32 = 0.95;
/// Exponent of the feature difference, and width in degrees of the feature that is detected best.
const FEATURE_EXPONENT: f32 = 0.5;
const FEATURE_WIDTH: f64 = 0.082;

/// Contrast sensitivity per channel as two Gaussians (a1, b1, a2, b2): the filter at a distance
/// of z degrees is the sum of `a sqrt(pi / b) exp(-pi² z² / b)`.
const SENSITIVITY: [[f64; 4]; 3] =
    [[1.0, 0.0047, 0.0, 1e-5], [1.0, 0.0053, 0.0, 1e-5], [34.1, 0.04, 13.5, 0.025]];

/// Linear Rec. 709 to CIE XYZ under D65.
const RGB_TO_XYZ: [[f64; 3]; 3] = [
    [10135552.0 / 24577794.0, 8788810.0 / 24577794.0, 4435075.0 / 24577794.0],
    [2613072.0 / 12288897.0, 8788810.0 / 12288897.0, 887015.0 / 12288897.0],
    [1425312.0 / 73733382.0, 8788810.0 / 73733382.0, 70074185.0 / 73733382.0],
];

/// The error of each pixel, in [0, 1]. Where either image is not finite, both count as black.
///
/// # Errors
/// If the images differ in size or have no pixels.
pub fn error_map(image: &RgbImage, reference: &RgbImage) -> Result<Vec<f32>, ImageError> {
    image.check_same_size(reference)?;
    if image.pixels().is_empty() {
        return Err(ImageError::Empty);
    }
    let usable = |p: usize| is_finite(&image.pixels()[p]) && is_finite(&reference.pixels()[p]);
    let (a, b) = (Perceived::new(image, usable), Perceived::new(reference, usable));
    let largest = hyab(perceptual([0.0, 1.0, 0.0]), perceptual([0.0, 0.0, 1.0]));
    let errors = (0..image.pixels().len()).map(|p| {
        let colour = colour_error(hyab(a.lab[p], b.lab[p]), largest);
        let edges = (a.edges[p] - b.edges[p]).abs();
        let points = (a.points[p] - b.points[p]).abs();
        let feature = (edges.max(points) / 2f32.sqrt()).powf(FEATURE_EXPONENT);
        colour.powf(1.0 - feature.min(1.0))
    });
    Ok(errors.collect())
}

/// The mean of the [`error_map`]: 0 for identical images, at most 1.
///
/// # Errors
/// If the images differ in size or have no pixels.
pub fn flip(image: &RgbImage, reference: &RgbImage) -> Result<f64, ImageError> {
    let map = error_map(image, reference)?;
    Ok(map.iter().map(|&e| f64::from(e)).sum::<f64>() / map.len() as f64)
}

/// What the eye makes of one image.
struct Perceived {
    /// Filtered colour as Hunt-adjusted L*a*b*.
    lab: Vec<[f32; 3]>,
    /// Strength of edges and of points in the luminance.
    edges: Vec<f32>,
    points: Vec<f32>,
}

impl Perceived {
    fn new(image: &RgbImage, usable: impl Fn(usize) -> bool) -> Self {
        let shown = |p: usize, c: usize| image.pixels()[p][c].clamp(0.0, 1.0);
        let opponent: Vec<[f32; 3]> = (0..image.pixels().len())
            .map(|p| if usable(p) { [0, 1, 2].map(|c| shown(p, c)) } else { [0.0; 3] })
            .map(rgb_to_ycxcz)
            .collect();
        let plane = |c: usize| -> Plane {
            let values = opponent.iter().map(|colour| colour[c]).collect();
            Plane { width: image.width(), height: image.height(), values }
        };
        let filtered = [0, 1, 2].map(|c| sensitivity_filter(&plane(c), SENSITIVITY[c]));
        let lab = (0..opponent.len())
            .map(|p| [0, 1, 2].map(|c| filtered[c][p]))
            .map(|colour| perceptual(ycxcz_to_rgb(colour).map(|v| v.clamp(0.0, 1.0))))
            .collect();
        let mut luminance = plane(0);
        luminance.values.iter_mut().for_each(|y| *y = (*y + 16.0) / 116.0);
        let (edges, points) = features(&luminance);
        Self { lab, edges, points }
    }
}

/// One channel of an image.
struct Plane {
    width: usize,
    height: usize,
    values: Vec<f32>,
}

impl Plane {
    /// Correlation with a separable kernel of odd length; the border pixels extend outwards.
    fn filter(&self, horizontal: &[f64], vertical: &[f64]) -> Vec<f32> {
        let rows = self.filter_axis(horizontal, self.width, 1);
        Plane { values: rows, ..*self }.filter_axis(vertical, self.height, self.width)
    }

    /// Correlation along the axis of `length` pixels that are `stride` apart.
    fn filter_axis(&self, kernel: &[f64], length: usize, stride: usize) -> Vec<f32> {
        let radius = kernel.len() / 2;
        let at = |p: usize| {
            let position = p / stride % length;
            let start = p - position * stride;
            let tap = |k: usize| (position + k).saturating_sub(radius).min(length - 1) * stride;
            let taps = kernel.iter().enumerate();
            taps.map(|(k, weight)| weight * f64::from(self.values[start + tap(k)])).sum::<f64>()
                as f32
        };
        (0..self.values.len()).map(at).collect()
    }
}

/// Blurs a channel of YCxCz by the eye's contrast sensitivity; the weights sum to 1.
fn sensitivity_filter(plane: &Plane, [a1, b1, a2, b2]: [f64; 4]) -> Vec<f32> {
    // All channels share the radius of three standard deviations of the widest Gaussian.
    let widest = SENSITIVITY.iter().map(|s| s[1].max(s[3])).fold(0.0, f64::max);
    let radius = (3.0 * (widest / (2.0 * PI * PI)).sqrt() * PIXELS_PER_DEGREE).ceil() as i32;
    let gaussian = |b: f64| -> Vec<f64> {
        let z = |x: i32| f64::from(x) / PIXELS_PER_DEGREE;
        (-radius..=radius).map(|x| (-(PI * z(x)).powi(2) / b).exp()).collect()
    };
    let terms: Vec<(f64, Vec<f64>)> = [(a1, b1), (a2, b2)]
        .into_iter()
        .filter(|(a, _)| *a > 0.0)
        .map(|(a, b)| (a * (PI / b).sqrt(), gaussian(b)))
        .collect();
    let total: f64 = terms.iter().map(|(a, g)| a * g.iter().sum::<f64>().powi(2)).sum();
    let mut result = vec![0.0; plane.values.len()];
    for (a, kernel) in &terms {
        let scaled: Vec<f64> = kernel.iter().map(|g| g * a / total).collect();
        let term = plane.filter(&scaled, kernel);
        result.iter_mut().zip(term).for_each(|(sum, value)| *sum += value);
    }
    result
}

/// Strength of edges (first derivative of a Gaussian) and of points (second) at each pixel.
fn features(luminance: &Plane) -> (Vec<f32>, Vec<f32>) {
    let sigma = 0.5 * FEATURE_WIDTH * PIXELS_PER_DEGREE;
    let radius = (3.0 * sigma).ceil() as i32;
    let kernel = |weight: fn(f64) -> f64| -> Vec<f64> {
        let x = |x: i32| f64::from(x) / sigma;
        let raw = (-radius..=radius).map(|i| weight(x(i)) * (-0.5 * x(i) * x(i)).exp());
        one_sided_unit_sums(raw.collect())
    };
    let (blur, first, second) = (kernel(|_| 1.0), kernel(|x| -x), kernel(|x| x * x - 1.0));
    let strength = |derivative: &[f64]| -> Vec<f32> {
        let dx = luminance.filter(derivative, &blur);
        let dy = luminance.filter(&blur, derivative);
        dx.iter().zip(dy).map(|(x, y)| x.hypot(y)).collect()
    };
    (strength(&first), strength(&second))
}

/// Scales the positive weights so that they sum to 1, and the negative ones to -1.
fn one_sided_unit_sums(mut kernel: Vec<f64>) -> Vec<f64> {
    let positive: f64 = kernel.iter().filter(|w| **w > 0.0).sum();
    let negative: f64 = kernel.iter().filter(|w| **w < 0.0).sum();
    kernel.iter_mut().for_each(|w| *w /= if *w < 0.0 { -negative } else { positive });
    kernel
}

/// Maps a colour distance to [0, 1]: most of the range belongs to small distances.
fn colour_error(distance: f32, largest: f32) -> f32 {
    let (d, top) = (distance.powf(COLOUR_EXPONENT), largest.powf(COLOUR_EXPONENT));
    let knee = COLOUR_BREAK * top;
    if d < knee {
        COLOUR_BREAK_ERROR / knee * d
    } else {
        // Filtered colours stay within the cube, but rounding could pass the largest distance.
        let above = ((d - knee) / (top - knee)).min(1.0);
        COLOUR_BREAK_ERROR + above * (1.0 - COLOUR_BREAK_ERROR)
    }
}

/// HyAB distance: city block in lightness, Euclidean in a* and b*.
fn hyab(a: [f32; 3], b: [f32; 3]) -> f32 {
    (a[0] - b[0]).abs() + (a[1] - b[1]).hypot(a[2] - b[2])
}

/// CIE XYZ relative to white, of a linear RGB colour.
fn relative_xyz(rgb: [f32; 3]) -> [f64; 3] {
    RGB_TO_XYZ.map(|row| {
        let value: f64 = row.iter().zip(rgb).map(|(m, v)| m * f64::from(v)).sum();
        value / row.iter().sum::<f64>()
    })
}

/// The linear opponent space in which the contrast sensitivity is known.
fn rgb_to_ycxcz(rgb: [f32; 3]) -> [f32; 3] {
    let [x, y, z] = relative_xyz(rgb);
    [116.0 * y - 16.0, 500.0 * (x - y), 200.0 * (y - z)].map(|v| v as f32)
}

fn ycxcz_to_rgb(colour: [f32; 3]) -> [f32; 3] {
    let [luma, cx, cz] = colour.map(f64::from);
    let y = (luma + 16.0) / 116.0;
    let white = RGB_TO_XYZ.map(|row| row.iter().sum::<f64>());
    let xyz = [white[0] * (y + cx / 500.0), white[1] * y, white[2] * (y - cz / 200.0)];
    let inverse = glam::DMat3::from_cols_array_2d(&RGB_TO_XYZ).transpose().inverse();
    (inverse * glam::DVec3::from(xyz)).to_array().map(|v| v as f32)
}

/// CIE L*a*b*, with a* and b* scaled by lightness: colours look less vivid in the dark (Hunt).
fn perceptual(rgb: [f32; 3]) -> [f32; 3] {
    let curve = |t: f64| {
        let delta = 6.0 / 29.0;
        if t > delta * delta * delta { t.cbrt() } else { t / (3.0 * delta * delta) + 4.0 / 29.0 }
    };
    let [x, y, z] = relative_xyz(rgb).map(curve);
    let lightness = 116.0 * y - 16.0;
    let hunt = 0.01 * lightness;
    [lightness, hunt * 500.0 * (x - y), hunt * 200.0 * (y - z)].map(|v| v as f32)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A gradient, and the same with a coloured square and a darker right border.
    fn pair() -> (RgbImage, RgbImage) {
        let gradient = |x: usize, y: usize| [x as f32 / 31.0, y as f32 / 23.0, 0.5];
        let reference = RgbImage::from_fn(32, 24, gradient);
        let image = RgbImage::from_fn(32, 24, |x, y| match (x, y) {
            (8..16, 8..16) => [0.9, 0.1, 0.2],
            (24.., _) => gradient(x, y).map(|v| 0.8 * v),
            _ => gradient(x, y),
        });
        (image, reference)
    }

    /// Values of the authors' own program, flip-evaluator 1.7 from PyPI, at 67 pixels per degree.
    #[test]
    fn agrees_with_the_published_program() {
        let (image, reference) = pair();
        let map = error_map(&image, &reference).unwrap();
        let known = [
            ((12, 12), 0.970_552_2),
            ((24, 12), 0.239_316_99),
            ((23, 12), 0.157_887_94),
            ((8, 8), 0.611_744_7),
            ((31, 20), 0.385_859_9),
        ];
        for ((x, y), expected) in known {
            approx::assert_relative_eq!(map[y * 32 + x], expected, max_relative = 1e-4);
        }
        let mean = flip(&image, &reference).unwrap();
        approx::assert_relative_eq!(mean, 0.225_232_765, max_relative = 1e-4);
    }

    #[test]
    fn identical_is_zero_and_order_does_not_matter() {
        let (image, reference) = pair();
        assert_eq!(flip(&image, &image).unwrap(), 0.0);
        assert_eq!(flip(&image, &reference).unwrap(), flip(&reference, &image).unwrap());
    }

    #[test]
    fn the_largest_difference_is_one() {
        let green = RgbImage::filled(9, 9, [0.0, 1.0, 0.0]);
        let blue = RgbImage::filled(9, 9, [0.0, 0.0, 1.0]);
        approx::assert_relative_eq!(flip(&green, &blue).unwrap(), 1.0, max_relative = 1e-4);
        let checks = RgbImage::from_fn(40, 40, |x, y| [((x / 4 + y / 4) % 2 * 1000) as f32; 3]);
        let inverse = RgbImage::from_fn(40, 40, |x, y| [((x / 4 + y / 4 + 1) % 2) as f32; 3]);
        let map = error_map(&checks, &inverse).unwrap();
        assert!(map.iter().all(|e| (0.0..=1.0).contains(e)));
    }

    #[test]
    fn broken_pixels_do_not_spread() {
        let (mut image, reference) = pair();
        image.pixels_mut()[0] = [f32::NAN; 3];
        assert!(flip(&image, &reference).unwrap().is_finite());
    }
}
