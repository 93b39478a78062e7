//! Points of a rank-1 lattice, shifted at random, padded by blocks (Cranley and Patterson 1976, "Randomization of Number
//! Theoretic Methods for Multiple Integration"; Hickernell, Hong, L'Ecuyer and Lemieux 2000, "Extensible Lattice Sequences
//! for Quasi-Monte Carlo Quadrature").

use super::sobol::owen;
use super::{UniformSource, combine, first_block_of_piece, first_of, mix, unit, with_second};
use crate::real::Single;
use crate::sequence::first_block;

/// How many numbers that are drawn, and how many that choose, are of one lattice.
const PAIR: u32 = 2;

/// The generator of numbers that are drawn: of 2^k points (i, g i) / 2^k, modulo one, all k from 4 to 32 have nearest points far
/// apart, and this so also where one of the axes is stretched four to twelve times, as that of an azimuth is
/// where a square is wrapped onto a disk. It was found bit by bit, from the lowest on.
const DRAWN: [u32; 2] = [1, 1_634_125_975];

/// The generator of numbers that choose: found by errors of functions of one of them and of a pair that is drawn, up to 2^8
/// points, and by P2, up to 2^13.
const CHOSEN: [u32; 2] = [2_246_820_269, 3_266_490_597];

/// What the generators of every other step of a path are multiplied by: its points are those of the step before in another
/// order, such that the four numbers that both draw have small P2, up to 2^13 points.
const SECOND: u32 = 2_654_432_797;

/// Blocks that differ in this bit alone have one lattice: those of two steps of a path, one after the other.
const STEP: u32 = first_block(1);

/// Randomly shifted points of rank-1 lattices: those of one stream are spread over the square of the two numbers that a
/// block draws first, of each two steps of a path over all four, and over two that choose in each of these. Streams and all
/// else are independent of each other. Up to 2^32 samples a stream; any 2^k that begin at a multiple of it
/// are such a lattice.
///
/// As with [`Sobol`](super::Sobol), every single number is stratified: of 2^k samples, each 2^-k of the unit
/// interval has one. Pairs of numbers have no elementary intervals, but are farther apart from each other, which
/// is better where what is integrated jumps, as visibility does; and a number takes a multiplication and a sum.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Lattice {
    /// What the randomisations of this seed and stream share.
    key: u64,
    /// The number of the sample, with its bits in opposite order.
    sample: u32,
    block: u32,
    /// What is added to the numbers of blocks, for the current piece of the sample.
    beyond: u32,
    /// Numbers that were drawn since the block began, and that chose.
    counts: [u32; 2],
    /// Where the sample lies in the lattice of the block, once it has drawn or chosen.
    place: Option<Place>,
    /// The random shifts of numbers that are drawn and that choose.
    shifts: [u64; 2],
}

/// Where a sample lies in a lattice.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Place {
    /// What the shifts are derived from.
    lattice: u64,
    /// What generators are multiplied by: the place of the sample, as a binary fraction, in the order of the step.
    factor: u32,
}

/// Numbers that are drawn, and numbers that choose.
const SORTS: [[u32; 2]; 2] = [DRAWN, CHOSEN];

impl Lattice {
    /// The point number `sample` of the stream (say, the pixel).
    pub fn new(seed: u64, stream: u64, sample: u32) -> Self {
        let (key, sample) = (first_of(combine(seed, stream)), sample.reverse_bits());
        let (counts, place, shifts) = ([0; 2], None, [0; 2]);
        Lattice { key, sample, block: 0, beyond: 0, counts, place, shifts }
    }

    /// Whether the block is of the second of two steps.
    #[inline(always)]
    fn is_second(&self) -> u32 {
        u32::from(self.block & STEP != 0)
    }

    /// Where the sample lies in one of the lattices of the block and of that which shares them.
    #[inline(always)]
    fn place(&self, number: u32) -> Place {
        let lattice = u64::from(self.block & !STEP) << 32 | u64::from(number);
        let lattice = with_second(self.key, lattice);
        // As a binary fraction: aligned runs of 2^k samples stay aligned runs.
        let index = owen(self.sample, (lattice >> 32) as u32);
        Place { lattice, factor: index.wrapping_mul([1, SECOND][self.is_second() as usize]) }
    }

    /// The random shift of numbers of a sort.
    #[inline(always)]
    fn shift(&self, place: Place, sort: usize) -> u64 {
        mix(place.lattice.wrapping_add(u64::from(1 + self.is_second() + 2 * sort as u32)))
    }

    /// The next number of a sort.
    #[inline(always)]
    fn number<R: Single>(&mut self, sort: usize) -> R {
        let count = self.counts[sort];
        self.counts[sort] += 1;
        if count >= PAIR {
            return self.further(sort, count);
        }
        let place = match self.place {
            Some(place) => place,
            None => *self.place.insert(self.place(0)),
        };
        if count == 0 {
            self.shifts[sort] = self.shift(place, sort);
        }
        point(place, self.shifts[sort], sort, count)
    }

    /// A number after the first pair, each two of which have a lattice of their own.
    #[cold]
    fn further<R: Single>(&self, sort: usize, count: u32) -> R {
        let place = self.place(count / PAIR * 2 + sort as u32);
        point(place, self.shift(place, sort), sort, count % PAIR)
    }
}

/// The number of a dimension. Both numbers of a pair have all bits of the shift, in another order.
#[inline(always)]
fn point<R: Single>(place: Place, shift: u64, sort: usize, number: u32) -> R {
    let point = place.factor.wrapping_mul(SORTS[sort][number as usize]);
    unit(shift.rotate_left(32 * number).wrapping_add(u64::from(point) << 32))
}

impl<R: Single> UniformSource<R> for Lattice {
    #[inline]
    fn next(&mut self) -> R {
        self.number(0)
    }

    #[inline]
    fn choice(&mut self) -> R {
        self.number(1)
    }

    #[inline]
    fn start(&mut self, block: u32) {
        (self.block, self.counts, self.place) = (block.wrapping_add(self.beyond), [0; 2], None);
    }

    #[inline]
    fn piece(&mut self, number: u32) {
        self.beyond = first_block_of_piece(number);
    }
}

#[cfg(test)]
mod tests {
    use super::super::{Pcg32, Sobol};
    use super::*;

    /// Numbers of a block: four that are drawn, and two that choose.
    fn numbers(seed: u64, stream: u64, sample: u32, block: u32) -> [f64; 6] {
        let mut source = Lattice::new(seed, stream, sample);
        UniformSource::<f64>::start(&mut source, block);
        core::array::from_fn(|i| if i < 4 { source.next() } else { source.choice() })
    }

    #[test]
    fn every_number_is_stratified() {
        for (seed, stream, block) in [(0, 0, 0), (1, 5, 24), (9, 1_000_000, 77)] {
            let points: Vec<_> = (256..512).map(|k| numbers(seed, stream, k, block)).collect();
            for d in 0..6 {
                let mut count = [0; 256];
                points.iter().for_each(|p| count[(p[d] * 256.0) as usize] += 1);
                assert_eq!(count, [1; 256], "dimension {d}");
            }
        }
    }

    /// The distance between nearest points of the lattice of 2^bits points, with the second axis `stretched`, over the largest
    /// that any lattice of as many points has.
    fn nearest(bits: u32, stretched: f64) -> f64 {
        let n = 2_f64.powi(bits as i32);
        let (narrow, wide) = (1.0 / stretched.sqrt(), stretched.sqrt());
        let second = f64::from(DRAWN[1] & ((1_u64 << bits) - 1) as u32);
        // Gauss's reduction.
        let (mut a, mut b) = ([narrow / n, second * wide / n], [0.0, wide]);
        let dot = |a: [f64; 2], b: [f64; 2]| a[0] * b[0] + a[1] * b[1];
        loop {
            if dot(a, a) > dot(b, b) {
                std::mem::swap(&mut a, &mut b);
            }
            let k = (dot(a, b) / dot(a, a)).round();
            let shorter = [b[0] - k * a[0], b[1] - k * a[1]];
            if dot(shorter, shorter) >= dot(b, b) {
                return (dot(a, a) * n * 3_f64.sqrt() / 2.0).sqrt();
            }
            b = shorter;
        }
    }

    #[test]
    fn nearest_points_are_far_apart() {
        for bits in 4..=32 {
            for stretched in [0.25, 1.0, 2.0, 4.0, 8.0, 12.0] {
                let nearest = nearest(bits, stretched);
                assert!(nearest > 0.5, "2^{bits} points, stretched by {stretched}: {nearest}");
            }
        }
    }

    /// The mean square error of the mean of a function of 64 points, over many streams.
    fn error<S: UniformSource<f64>>(
        new: impl Fn(u64, u32) -> S,
        draw: impl Fn(&mut S) -> f64,
        mean: f64,
    ) -> f64 {
        let error = |stream| {
            let sum: f64 = (0..64).map(|sample| draw(&mut new(stream, sample))).sum();
            (sum / 64.0 - mean).powi(2)
        };
        (0..2000).map(error).sum::<f64>() / 2000.0
    }

    /// Whether a point of the unit disk, as samplers make it by its squared radius and its azimuth, lies beyond a chord.
    fn is_beyond(source: &mut impl UniformSource<f64>) -> f64 {
        let [u, v]: [f64; 2] = super::super::draw_uniforms(source);
        f64::from(u8::from(u.sqrt() * (core::f64::consts::TAU * v - 0.4).cos() > CHORD))
    }

    /// The distance of the chord.
    const CHORD: f64 = 0.3;

    #[test]
    fn errors_are_smaller_than_those_of_others_where_what_is_integrated_jumps() {
        let mean = (CHORD.acos() - CHORD * (1.0 - CHORD * CHORD).sqrt()) / core::f64::consts::PI;
        let lattice = error(|stream, k| Lattice::new(1, stream, k), is_beyond, mean);
        let sobol = error(|stream, k| Sobol::new(1, stream, k), is_beyond, mean);
        let new = |stream, k| Pcg32::new(1, stream, u64::from(k));
        let independent = error(new, is_beyond, mean);
        // The ratios are 0.46 and 0.045. The standard deviation of each, of 2000 squares, is 5 % of it: six of them.
        assert!(
            lattice < 0.6 * sobol && lattice < 0.06 * independent,
            "{lattice} {sobol} {independent}"
        );
    }

    #[test]
    fn two_steps_have_one_lattice_and_all_else_is_independent() {
        // Correlations of 4096 products of independent numbers: standard deviation 1/64; 6 of them, six times.
        let correlation = |pick: &dyn Fn(u32) -> [f64; 2]| {
            let sum: f64 = (0..4096).map(pick).map(|[a, b]| (a - 0.5) * (b - 0.5)).sum();
            sum / 4096.0 * 12.0
        };
        for (i, j) in [(0, 1), (0, 2), (0, 4), (1, 5)] {
            let within = correlation(&|k| [i, j].map(|d| numbers(3, 3, k, 16)[d]));
            assert!(within.abs() < 0.094, "{i} {j}: {within}");
        }
        for block in [17, 24, 32] {
            let between = correlation(&|k| [16, block].map(|block| numbers(3, 3, k, block)[0]));
            assert!(between.abs() < 0.094, "{block}: {between}");
        }
        // Differences of the first numbers of all 2^8 samples: of one lattice, all multiples of 2^-8 that its second step
        // makes of them.
        let order = |block: u32| -> Vec<u32> {
            (0..256).map(|k| (numbers(3, 3, k, block)[0] * 256.0) as u32).collect()
        };
        let [first, second] = [order(16), order(24)];
        let steps = |order: &[u32], k: usize| order[k].wrapping_sub(order[0]) % 256;
        for k in 0..256 {
            assert_eq!(steps(&second, k), steps(&first, k).wrapping_mul(SECOND) % 256);
        }
    }

    #[test]
    fn numbers_are_those_of_the_block_in_any_order() {
        let mut source = Lattice::new(1, 2, 3);
        UniformSource::<f64>::start(&mut source, 9);
        (0..7).for_each(|_| {
            UniformSource::<f64>::next(&mut source);
        });
        UniformSource::<f64>::start(&mut source, 4);
        let chosen: [f64; 2] = core::array::from_fn(|_| source.choice());
        let drawn: [f64; 4] = core::array::from_fn(|_| source.next());
        let expected = numbers(1, 2, 3, 4);
        assert_eq!((&drawn[..], &chosen[..]), expected.split_at(4));
        for other in
            [numbers(0, 2, 3, 4), numbers(1, 0, 3, 4), numbers(1, 2, 0, 4), numbers(1, 2, 3, 0)]
        {
            assert_ne!(other, expected);
        }
    }

    #[test]
    fn shifts_are_uniform_over_seeds() {
        // 64 cells, 63 degrees of freedom: chi-square above 139 once in 1e7, three times.
        for d in [0, 1, 4] {
            let mut counts = [0.0; 64];
            (0..64_000).for_each(|s| counts[(numbers(s, 0, 5, 24)[d] * 64.0) as usize] += 1.0);
            let chi_square: f64 = counts.iter().map(|c: &f64| (c - 1e3).powi(2) / 1e3).sum();
            assert!(chi_square < 139.0, "{chi_square}");
        }
    }
}
