//! What the samples of a tile add to the pixels in it and around it, summed up exactly.
//!
//! A sum of floating-point numbers depends on their order, unless nothing is rounded. Here a number is
//! taken apart into three, each a multiple of a unit of its own and not too large, so that sums of
//! several thousand have room in 53 bits.

use super::shares::{Expected, Shares};
use super::splats::SplatSums;
use crate::scene::Filter;
use crate::strategies::Pixel;

/// The units of the parts. The last is all that is kept of a number.
const UNITS: [f64; 3] = [pow2(12), pow2(-20), pow2(-60)];

/// The same for squares: they are at most [`MOST_SQUARE`], and say less when they are small.
const SQUARE_UNITS: [f64; 3] = [pow2(32), pow2(-6), SQUARE_UNIT];

/// Each square is rounded upwards, by at most twice as much.
pub(super) const SQUARE_UNIT: f64 = pow2(-44);

/// What no larger square is told from.
pub(super) const MOST_SQUARE: f64 = pow2(70);

/// How many numbers can be added to each sum: 2⁵⁰ at most each, of which the first part has 38 bits.
const MOST_ADDED: u32 = 1 << 13;

/// A power of two.
pub(super) const fn pow2(exponent: i64) -> f64 {
    f64::from_bits(((1023 + exponent) as u64) << 52)
}

/// A number, at most 2³⁸ of the first unit, as a sum of multiples of the units.
#[inline(always)]
fn parts(mut number: f64, units: [f64; 3]) -> [f64; 3] {
    units.map(|unit| {
        // What is added leaves no room for digits below the unit.
        let large = 1.5 * unit / f64::EPSILON;
        let part = number + large - large;
        number -= part;
        part
    })
}

/// For each channel the parts of the sum of some numbers, and of the sum of their squares.
pub(super) type Parts = [[[f64; 3]; 3]; 2];

/// Adds a number for each channel.
#[inline(always)]
fn add([sums, squares]: &mut Parts, numbers: [f64; 3]) {
    let add = |sum: &mut [f64; 3], parts: [f64; 3]| {
        sum.iter_mut().zip(parts).for_each(|(sum, part)| *sum += part);
    };
    for ((sum, square), number) in sums.iter_mut().zip(squares).zip(numbers) {
        add(sum, parts(number, UNITS));
        add(square, parts((number * number + SQUARE_UNIT).min(MOST_SQUARE), SQUARE_UNITS));
    }
}

/// The sums of one tile.
#[derive(Debug)]
pub(super) struct Gathered {
    first: Pixel,
    width: usize,
    /// A power of two that values are multiplied by, as they are in the sums that these are handed over to.
    scale: f64,
    sums: Vec<Parts>,
    added: u32,
}

impl Gathered {
    /// Nothing, of samples of the pixels of a tile (its first pixel, columns and rows) in an image of this size.
    pub fn new(
        filter: Filter,
        size: (u32, u32),
        (x, y): Pixel,
        (columns, rows): (u32, u32),
    ) -> Self {
        let reach = Expected::reach(filter);
        let first = (x.saturating_sub(reach), y.saturating_sub(reach));
        let end = (size.0.min(x + columns + reach), size.1.min(y + rows + reach));
        let [width, height] = [end.0 - first.0, end.1 - first.1].map(|n| n as usize);
        let sums = vec![Parts::default(); width * height];
        Gathered { first, width, scale: 1.0, sums, added: 0 }
    }

    /// The same with values multiplied by a power of two.
    pub fn scaled_by(self, scale: f64) -> Self {
        Gathered { scale, ..self }
    }

    fn index(&self, (x, y): Pixel) -> usize {
        (y - self.first.1) as usize * self.width + (x - self.first.0) as usize
    }

    /// Whether it has to be handed over before anything is added.
    pub fn is_full(&self) -> bool {
        self.added >= MOST_ADDED
    }

    /// Adds to each pixel its share of a value, whose magnitude is 2⁵⁰ at most once it is scaled, of a sample of a pixel of the tile that lies
    /// where the filter of that reaches.
    pub fn add(&mut self, shares: &Shares, value: [f32; 3]) {
        let (first, [across, down]) = shares.parts();
        if !across.is_empty() && !down.is_empty() {
            let start = self.index(first);
            for (row, down) in self.sums[start..].chunks_mut(self.width).zip(down) {
                let value = value.map(|v| f64::from(v * down) * self.scale);
                for (sums, across) in row.iter_mut().zip(across) {
                    add(sums, value.map(|v| v * f64::from(*across)));
                }
            }
        }
        if let Some((pixel, counts)) = shares.own() {
            let index = self.index(pixel);
            let value = value.map(|v| f64::from(v * counts) * self.scale);
            add(&mut self.sums[index], value);
        }
        self.added += 1;
    }

    /// Hands over everything.
    pub fn hand_over(&mut self, to: &mut SplatSums) {
        if self.added == 0 {
            return;
        }
        self.added = 0;
        for (index, sums) in self.sums.iter_mut().enumerate() {
            let (x, y) = (index % self.width, index / self.width);
            let pixel = (self.first.0 + x as u32, self.first.1 + y as u32);
            to.gather(pixel, std::mem::take(sums));
        }
    }
}

#[cfg(test)]
mod tests {
    use aether_core::prelude::Vec2;

    use super::*;
    use crate::scene::Film;

    #[test]
    fn parts_add_up_to_the_number() {
        for number in [0.0, 1.0, -0.1, 1e15, -1e15 / 3.0, 2f64.powi(-60), 4096.0 + 1e-7, 1e-9] {
            let parts = parts(number, UNITS);
            let rest = number - parts[0] - parts[1] - parts[2];
            assert!(rest.abs() <= UNITS[2] / 2.0, "{number}: {parts:?}");
            for (part, unit) in parts.iter().zip(UNITS) {
                assert_eq!(part % unit, 0.0, "{number}: {parts:?}");
            }
        }
    }

    #[test]
    fn the_order_of_samples_does_not_matter() {
        let filter = Filter::Gaussian { stddev: 0.5 };
        let size = (40, 30);
        let samples: Vec<_> = (0..500u32)
            .map(|k| {
                let [x, y] = [k * 7919 % 1600, k * 104_729 % 1600].map(|u| u as f32 / 100.0);
                let value = 10f32.powi(k as i32 % 25 - 10) * (1.0 + x);
                let mut shares = Shares::default();
                let film = Film { width: size.0, height: size.1, filter };
                shares.move_to(&film, (16 + x as u32, y as u32), Vec2::new(16.0 + x, y));
                (shares, [value, -value, 1e-3])
            })
            .collect();
        let total = |order: &mut dyn Iterator<Item = usize>, often: usize| {
            let mut sums = SplatSums::new(size).with_shares();
            let mut gathered = Gathered::new(filter, size, (16, 0), (16, 16));
            for (count, i) in order.enumerate() {
                let (shares, value) = &samples[i];
                gathered.add(shares, *value);
                if count % often == 0 {
                    gathered.hand_over(&mut sums);
                }
            }
            gathered.hand_over(&mut sums);
            (0..40 * 30).map(|pixel| sums.shared(pixel, 1.0)).collect::<Vec<_>>()
        };
        let forwards = total(&mut (0..500), 600);
        assert_eq!(forwards, total(&mut (0..500).rev(), 7));
        let weight = |shares: &Shares| shares.each().map(|(_, w)| f64::from(w)).sum::<f64>();
        let exact: f64 = samples.iter().map(|(shares, v)| weight(shares) * f64::from(v[0])).sum();
        let sum: f64 = forwards.iter().map(|pixel| pixel[0]).sum();
        approx::assert_relative_eq!(sum, exact, max_relative = 1e-6);
    }
}
