//! Contributions of paths to pixels that they were not sampled for, and to images beside the image.

use std::collections::BTreeMap;
use std::io::{self, Read, Write};

use super::gathered::{MOST_SQUARE, Parts, SQUARE_UNIT, pow2};
use super::shares::Shares;
use super::technique::{Layer, Technique};
use crate::stored::{Stored, malformed};

/// The pixel, the layer (none for the image itself), and what it gets.
type Splat = ((u32, u32), Option<Layer>, [f32; 3]);

/// What one thread has to add to pixels of the image.
#[derive(Clone, Debug, Default)]
pub struct Splats {
    waiting: Vec<Splat>,
    /// The most vertices of paths whose techniques have layers of their own.
    pub layered: usize,
    /// Whether samples are shared among pixels.
    pub is_shared: bool,
    /// Those of the sample under way, if it is known where it lies.
    shares: Shares,
    lies: bool,
    /// How many contributions waited when the sample under way began, and whether it has been given up.
    before: usize,
    given_up: bool,
}

impl Splats {
    /// Without any, for techniques of paths with up to so many vertices to have layers.
    pub fn new(layered: usize) -> Self {
        Splats { layered, ..Splats::default() }
    }

    /// Begins a sample, of which nothing is known.
    pub(super) fn begin(&mut self) {
        self.lies = false;
        (self.before, self.given_up) = (self.waiting.len(), false);
    }

    /// Takes back what the sample under way has added, which is not to count: the render is cancelled before it is
    /// complete.
    pub fn give_up(&mut self) {
        self.waiting.truncate(self.before);
        self.given_up = true;
    }

    /// Whether the last sample was given up.
    pub(super) fn is_given_up(&self) -> bool {
        self.given_up
    }

    /// The sample under way lies at a film point: what pixels have in it, to be moved there, if samples are shared.
    pub fn lie(&mut self) -> Option<&mut Shares> {
        self.lies = self.is_shared;
        self.is_shared.then_some(&mut self.shares)
    }

    /// What pixels have in the sample under way, if it is shared among them.
    pub fn shares(&self) -> Option<&Shares> {
        self.lies.then_some(&self.shares)
    }

    /// Adds to a pixel, which must lie in the image. Each sample of a pixel is to add its share of the
    /// expected value that all samples with its number add up to.
    pub fn add(&mut self, pixel: (u32, u32), value: [f32; 3]) {
        self.push(pixel, None, value);
    }

    /// [`Splats::add`] to the layers of a technique, if it is to have layers: what it contributes by its weight, and
    /// what it would alone.
    #[inline]
    pub fn add_by(&mut self, technique: Technique, pixel: (u32, u32), values: [[f32; 3]; 2]) {
        if technique.vertices <= self.layered {
            self.add_to_layers(technique, pixel, values);
        }
    }

    /// The same of a technique that is to have layers, as mostly none is.
    #[cold]
    fn add_to_layers(&mut self, technique: Technique, pixel: (u32, u32), values: [[f32; 3]; 2]) {
        for (weighted, value) in [true, false].into_iter().zip(values) {
            self.add_to(Layer::Technique { weighted, technique }, pixel, value);
        }
    }

    /// [`Splats::add_by`] for a sample of a pixel: to all pixels that have a share of it, if it is shared.
    #[inline]
    pub fn share_by(&mut self, technique: Technique, own: (u32, u32), values: [[f32; 3]; 2]) {
        if technique.vertices <= self.layered {
            self.share_to_layers(technique, own, values);
        }
    }

    /// The same of a technique that is to have layers, as mostly none is.
    #[cold]
    fn share_to_layers(&mut self, technique: Technique, own: (u32, u32), values: [[f32; 3]; 2]) {
        if !self.lies {
            return self.add_to_layers(technique, own, values);
        }
        let shares = std::mem::take(&mut self.shares);
        for (pixel, share) in shares.each() {
            self.add_to_layers(technique, pixel, values.map(|value| value.map(|v| v * share)));
        }
        self.shares = shares;
    }

    /// [`Splats::add`] to a layer.
    pub fn add_to(&mut self, layer: Layer, pixel: (u32, u32), value: [f32; 3]) {
        self.push(pixel, Some(layer), value);
    }

    fn push(&mut self, pixel: (u32, u32), layer: Option<Layer>, value: [f32; 3]) {
        if value != [0.0; 3] {
            self.waiting.push((pixel, layer, value));
        }
    }

    /// How many contributions wait.
    pub fn len(&self) -> usize {
        self.waiting.len()
    }

    /// Whether none waits.
    pub fn is_empty(&self) -> bool {
        self.waiting.is_empty()
    }
}

/// The sums of the contributions to each pixel and of their squares.
///
/// They are integers, multiples of 2⁻⁶⁴ times a power of two that follows from the scene: adding them is exact, so that their
/// order does not matter, and the image depends neither on threads nor on passes. Squares are rounded upwards, and a sum of
/// squares that there is no room for is infinite: no variance is less than it is.
#[derive(Clone, Debug)]
pub struct SplatSums {
    width: usize,
    /// A power of two that contributions are multiplied by; squares by its square.
    scale: f64,
    sums: Vec<[[i128; 3]; 2]>,
    /// Of samples that are shared among pixels; empty if there are none. Squares are in units of their own.
    shared: Vec<[[i128; 3]; 2]>,
    layers: BTreeMap<Layer, Vec<[[i128; 3]; 2]>>,
    invalid: u64,
}

/// What the sums of one pixel of a layer take.
pub const BYTES_OF_A_SUM: u64 = size_of::<[[i128; 3]; 2]>() as u64;

/// One, in the units of the sums.
const ONE: f64 = 18_446_744_073_709_551_616.0;
/// What a contribution may be at most, once it is scaled.
const MOST: f64 = 1e15;

/// A number in the units of the sums, rounded toward zero.
#[inline]
fn in_units(value: f64) -> i128 {
    let units = value * ONE;
    // Mostly half as many bits have room for it, which the machine converts at once.
    if units.abs() < 0.5 * ONE { i128::from(units as i64) } else { units as i128 }
}

impl SplatSums {
    /// For an image of this size (columns, rows).
    pub fn new(size: (u32, u32)) -> Self {
        let pixels = size.0 as usize * size.1 as usize;
        let (sums, layers) = (vec![[[0; 3]; 2]; pixels], BTreeMap::new());
        let width = size.0 as usize;
        SplatSums { width, scale: 1.0, sums, shared: Vec::new(), layers, invalid: 0 }
    }

    /// The same for an image as bright as this power of two, roughly ([`Scene::brightness_exponent`]).
    ///
    /// [`Scene::brightness_exponent`]: crate::scene::Scene::brightness_exponent
    pub(super) fn with_brightness(self, exponent: i32) -> Self {
        SplatSums { scale: pow2(-i64::from(exponent)), ..self }
    }

    /// What contributions are multiplied by.
    pub(super) fn scale(&self) -> f64 {
        self.scale
    }

    /// What a contribution may be at most.
    pub(super) fn most(&self) -> f64 {
        MOST / self.scale
    }

    /// The same, for shares in samples too.
    pub(super) fn with_shares(self) -> Self {
        SplatSums { shared: vec![[[0; 3]; 2]; self.sums.len()], ..self }
    }

    /// Takes over what waits.
    pub fn take(&mut self, splats: &mut Splats) {
        for ((x, y), layer, value) in splats.waiting.drain(..) {
            let pixel = y as usize * self.width + x as usize;
            let value = value.map(|v| f64::from(v) * self.scale);
            if !value.iter().all(|v| v.abs() <= MOST) {
                self.invalid += u64::from(layer.is_none());
                continue;
            }
            let blank = || vec![[[0; 3]; 2]; self.sums.len()];
            let [sum, squares] = match layer {
                None => &mut self.sums[pixel],
                Some(layer) => &mut self.layers.entry(layer).or_insert_with(blank)[pixel],
            };
            for (c, value) in value.into_iter().enumerate() {
                sum[c] = sum[c].saturating_add(in_units(value));
                let square = in_units(value * value).saturating_add((value != 0.0).into());
                squares[c] = squares[c].saturating_add(square);
            }
        }
    }

    /// Adds to a pixel what samples that are shared among pixels have added up to, scaled, and their squares, in parts that are
    /// multiples of the units of these sums.
    pub(super) fn gather(&mut self, (x, y): (u32, u32), parts: Parts) {
        let sums = &mut self.shared[y as usize * self.width + x as usize];
        for ((sums, parts), one) in sums.iter_mut().zip(parts).zip([ONE, 1.0 / SQUARE_UNIT]) {
            for (sum, parts) in sums.iter_mut().zip(parts) {
                let more = parts.iter().map(|part| (part * one) as i128).sum();
                *sum = sum.saturating_add(more);
            }
        }
    }

    /// What shared samples add to the mean of a pixel, if it has shares of so many.
    pub(super) fn shared(&self, pixel: usize, samples: f64) -> [f64; 3] {
        self.unscaled([self.shared[pixel][0], [0; 3]], samples)[0]
    }

    /// What the variance of the mean of a pixel with shares of so many samples is at most, if each adds a number that knows
    /// nothing of the others: the sum of squares. Infinite if a square was too large to be told.
    pub(super) fn shared_at_most(&self, pixel: usize, samples: f64) -> [f64; 3] {
        self.shared[pixel][1].map(|squares| {
            let squares = squares as f64 * SQUARE_UNIT;
            let over = samples * self.scale;
            if squares < MOST_SQUARE { squares / (over * over) } else { f64::INFINITY }
        })
    }

    /// Contributions that were NaN, infinite or beyond all measure, and were left out.
    pub fn invalid(&self) -> u64 {
        self.invalid
    }

    /// What is added to the mean of a pixel (by its number, row by row, one image after the other) and to the variance of the mean
    /// after `samples` samples of each pixel. Light paths are many, and each adds little to a pixel: the
    /// variance of their sum is the sum of squares.
    pub fn estimate(&self, pixel: usize, samples: f64) -> [[f64; 3]; 2] {
        self.unscaled(self.sums[pixel], samples)
    }

    /// [`SplatSums::estimate`] for the pixels of each layer that anything was added to.
    pub fn layers(&self, samples: f64) -> BTreeMap<Layer, Vec<[[f64; 3]; 2]>> {
        let pixels =
            |sums: &Vec<_>| sums.iter().map(|sums| self.unscaled(*sums, samples)).collect();
        self.layers.iter().map(|(layer, sums)| (*layer, pixels(sums))).collect()
    }

    /// The mean of so many samples, and the variance of the mean.
    fn unscaled(&self, [sum, squares]: [[i128; 3]; 2], samples: f64) -> [[f64; 3]; 2] {
        if samples <= 0.0 {
            return [[0.0; 3]; 2];
        }
        let over = |sum: [i128; 3], by: f64| sum.map(|s| s as f64 / ONE / by);
        let by = samples * self.scale;
        let mut variance = over(squares, by * by);
        for (variance, squares) in variance.iter_mut().zip(squares) {
            if squares == i128::MAX {
                *variance = f64::INFINITY;
            }
        }
        [over(sum, by), variance]
    }
}

impl Stored for SplatSums {
    fn store(&self, to: &mut dyn Write) -> io::Result<()> {
        (self.width, self.scale, self.invalid, self.layers.len()).store(to)?;
        self.sums.store(to)?;
        self.shared.store(to)?;
        self.layers.iter().try_for_each(|(layer, sums)| {
            layer.store(to)?;
            sums.store(to)
        })
    }

    fn load(from: &mut dyn Read) -> io::Result<Self> {
        let (width, scale, invalid, layers) = <(usize, f64, u64, usize)>::load(from)?;
        let (sums, shared): (Vec<_>, Vec<_>) = Stored::load(from)?;
        let layers =
            (0..layers).map(|_| Stored::load(from)).collect::<io::Result<BTreeMap<_, _>>>()?;
        if layers.values().any(|layer: &Vec<_>| layer.len() != sums.len()) {
            return Err(malformed("a layer has another size than the image"));
        }
        Ok(SplatSums { width, scale, sums, shared, layers, invalid })
    }
}

impl Stored for Technique {
    fn store(&self, to: &mut dyn Write) -> io::Result<()> {
        [self.vertices, self.camera, self.light].store(to)?;
        self.joint.to_owned().store(to)
    }

    fn load(from: &mut dyn Read) -> io::Result<Self> {
        let ([vertices, camera, light], joint) = <(_, String)>::load(from)?;
        Ok(Technique { vertices, joint: Self::joint_called(&joint), camera, light })
    }
}

impl Stored for Layer {
    fn store(&self, to: &mut dyn Write) -> io::Result<()> {
        match self {
            Layer::Direct => 0u8.store(to),
            Layer::Dx => 1u8.store(to),
            Layer::Dy => 2u8.store(to),
            Layer::Technique { weighted, technique } => {
                (3u8, *weighted).store(to)?;
                technique.store(to)
            }
        }
    }

    fn load(from: &mut dyn Read) -> io::Result<Self> {
        match u8::load(from)? {
            0 => Ok(Layer::Direct),
            1 => Ok(Layer::Dx),
            2 => Ok(Layer::Dy),
            3 => {
                let (weighted, technique) = Stored::load(from)?;
                Ok(Layer::Technique { weighted, technique })
            }
            _ => Err(malformed("a layer of no known sort")),
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
            let (mut splats, mut sums) = (Splats::default(), SplatSums::new((2, 2)));
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
    fn numbers_are_rounded_toward_zero_whatever_their_size() {
        for value in [0.0, 1e-30, 3e-19, 0.1, 0.499_999_999, 0.5, 0.75, 1.0, 123.456, MOST] {
            for value in [value, -value] {
                assert_eq!(in_units(value), (value * ONE) as i128, "{value}");
            }
        }
    }

    #[test]
    fn layers_have_sums_of_their_own() {
        let (mut splats, mut sums) = (Splats::default(), SplatSums::new((2, 1)));
        let layer = |camera, light| Layer::Technique {
            weighted: true,
            technique: Technique::edge(camera, light),
        };
        for value in [1.0, 3.0] {
            splats.add_to(layer(2, 1), (1, 0), [value, 0.0, 0.5]);
        }
        sums.take(&mut splats);
        let pixels = vec![[[0.0; 3]; 2], [[1.0, 0.0, 0.25], [10.0 / 16.0, 0.0, 0.5 / 16.0]]];
        let expected = BTreeMap::from([(layer(2, 1), pixels)]);
        assert_eq!(sums.layers(4.0), expected);
        let mut file = Vec::new();
        sums.store(&mut file).unwrap();
        assert_eq!(SplatSums::load(&mut &file[..]).unwrap().layers(4.0), expected);
        assert_eq!(layer(2, 1).to_string(), "weighted.s1t2");
        assert_eq!(sums.estimate(1, 4.0)[0], [0.0; 3]);
    }

    #[test]
    fn no_variance_is_less_than_it_is() {
        for value in [1e-18f32, 1e-13, 3e-10, 1.0, 2.9e9, 1e10, 1e15] {
            let (mut splats, mut sums) = (Splats::default(), SplatSums::new((1, 1)));
            for _ in 0..10 {
                splats.add((0, 0), [value, -value, 0.0]);
            }
            sums.take(&mut splats);
            let [_, variance] = sums.estimate(0, 5.0);
            // Ten squares over 25.
            let exact = 10.0 * f64::from(value).powi(2) / 25.0;
            assert!(variance[0] >= exact * (1.0 - 1e-12), "{value:e}: {variance:?}, not {exact:e}");
            assert!(variance[0] == variance[1] && variance[2] == 0.0, "{variance:?}");
            if (1e-8..1e9).contains(&value) {
                approx::assert_relative_eq!(variance[0], exact, max_relative = 1e-3);
            }
        }
    }

    #[test]
    fn what_is_no_number_is_left_out_and_counted() {
        let (mut splats, mut sums) = (Splats::default(), SplatSums::new((1, 1)));
        for value in [f32::NAN, f32::INFINITY, 1e30, 1.0] {
            splats.add((0, 0), [value, 0.0, 0.0]);
        }
        sums.take(&mut splats);
        assert_eq!((sums.invalid(), sums.estimate(0, 1.0)[0]), (3, [1.0, 0.0, 0.0]));
    }
}
