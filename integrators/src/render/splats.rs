//! Contributions of paths to pixels that they were not sampled for.

/// What one thread has to add to pixels of the image.
#[derive(Clone, Debug, Default)]
pub struct Splats(Vec<Splat>);

/// The image (0 for the main one), the pixel, and what it gets.
type Splat = (u32, (u32, u32), [f32; 3]);

impl Splats {
    /// Adds to a pixel, which must lie in the image. Each sample of a pixel is to add its share of the
    /// expected value that all samples with its number add up to.
    pub fn add(&mut self, pixel: (u32, u32), value: [f32; 3]) {
        if value != [0.0; 3] {
            self.0.push((0, pixel, value));
        }
    }

    /// Adds to a pixel of a further image, of those that the kernel has ([`AnyKernel::images`]).
    ///
    /// [`AnyKernel::images`]: super::AnyKernel::images
    pub fn add_to(&mut self, image: usize, pixel: (u32, u32), value: [f32; 3]) {
        if value != [0.0; 3] {
            self.0.push((image as u32 + 1, pixel, value));
        }
    }

    /// How many contributions wait.
    pub fn len(&self) -> usize {
        self.0.len()
    }

    /// Whether none waits.
    pub fn is_empty(&self) -> bool {
        self.0.is_empty()
    }
}

/// The sums of the contributions to each pixel and of their squares.
///
/// They are integers, multiples of 2⁻⁶⁴: adding them is exact, so that their order does not matter, and the
/// image depends neither on threads nor on passes.
#[derive(Clone, Debug)]
pub struct SplatSums {
    width: usize,
    /// Pixels of an image; the images follow each other.
    pixels: usize,
    sums: Vec<[[i128; 3]; 2]>,
    invalid: u64,
}

/// One, in the units of the sums.
const ONE: f64 = 18_446_744_073_709_551_616.0;
/// What a contribution may be at most.
const MOST: f32 = 1e15;

impl SplatSums {
    /// For so many images of this size (columns, rows).
    pub fn new(size: (u32, u32), images: usize) -> Self {
        let pixels = size.0 as usize * size.1 as usize;
        let sums = vec![[[0; 3]; 2]; images * pixels];
        SplatSums { width: size.0 as usize, pixels, sums, invalid: 0 }
    }

    /// Takes over what waits.
    pub fn take(&mut self, splats: &mut Splats) {
        for (image, (x, y), value) in splats.0.drain(..) {
            let pixel = y as usize * self.width + x as usize;
            let [sum, squares] = &mut self.sums[image as usize * self.pixels + pixel];
            if !value.iter().all(|v| v.abs() <= MOST) {
                self.invalid += 1;
                continue;
            }
            for (c, value) in value.into_iter().enumerate() {
                let value = f64::from(value);
                sum[c] += (value * ONE) as i128;
                squares[c] = squares[c].saturating_add((value * value * ONE) as i128);
            }
        }
    }

    /// Contributions that were NaN, infinite or beyond all measure, and were left out.
    pub fn invalid(&self) -> u64 {
        self.invalid
    }

    /// What is added to the mean of a pixel (by its number, row by row, one image after the other) and to the variance of the mean
    /// after `samples` samples of each pixel. Light paths are many, and each adds little to a pixel: the
    /// variance of their sum is the sum of squares.
    pub fn estimate(&self, pixel: usize, samples: f64) -> [[f64; 3]; 2] {
        let [sum, squares] = self.sums[pixel];
        let over = |sum: [i128; 3], scale: f64| sum.map(|s| s as f64 / ONE / scale);
        if samples > 0.0 {
            [over(sum, samples), over(squares, samples * samples)]
        } else {
            [[0.0; 3]; 2]
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_order_of_contributions_does_not_matter() {
        let values = [1e-9f32, 3.7e4, 0.1, 5e-4, 123.456, 1e9];
        let total = |order: &[usize]| {
            let (mut splats, mut sums) = (Splats::default(), SplatSums::new((2, 2), 1));
            for i in order {
                splats.add((1, 1), [values[*i], -values[*i], 0.0]);
                sums.take(&mut splats);
            }
            sums.estimate(3, 2.0)
        };
        let forwards = total(&[0, 1, 2, 3, 4, 5]);
        assert_eq!(forwards, total(&[5, 2, 4, 0, 1, 3]));
        let exact: f64 = values.iter().map(|v| f64::from(*v)).sum();
        approx::assert_relative_eq!(forwards[0][0], exact / 2.0, max_relative = 1e-15);
        assert_eq!((forwards[0][1], forwards[0][2]), (-forwards[0][0], 0.0));
        let squares: f64 = values.iter().map(|v| f64::from(*v).powi(2)).sum();
        approx::assert_relative_eq!(forwards[1][0], squares / 4.0, max_relative = 1e-15);
    }

    #[test]
    fn what_is_no_number_is_left_out_and_counted() {
        let (mut splats, mut sums) = (Splats::default(), SplatSums::new((1, 1), 1));
        for value in [f32::NAN, f32::INFINITY, 1e30, 1.0] {
            splats.add((0, 0), [value, 0.0, 0.0]);
        }
        sums.take(&mut splats);
        assert_eq!((sums.invalid(), sums.estimate(0, 1.0)[0]), (3, [1.0, 0.0, 0.0]));
    }
}
