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

/// The generator of numbers that choose: together with the two above, the lattice has small P2, up to 2^12 points.
const CHOSEN: [u32; 2] = [2_246_821_147, 3_266_487_345];

/// What the generators of every other step of a path are multiplied by: its points are those of the step before in another
/// order, such that the four numbers that both draw have small P2, up to 2^13 points.
const OTHER: u32 = 2_654_432_797;

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
    /// Numbers drawn since the block began, and numbers that chose.
    drawn: Numbers,
    chosen: Numbers,
    /// What is added to the numbers of blocks, for the current piece of the sample.
    beyond: u32,
}

/// Numbers of one sort, of those that are drawn and those that choose.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
struct Numbers {
    count: u32,
    /// The place in the lattice of the latest ones, as a binary fraction, times what all generators are multiplied by.
    place: u32,
    /// The random shift.
    shift: u64,
}

impl Lattice {
    /// The point number `sample` of the stream (say, the pixel).
    pub fn new(seed: u64, stream: u64, sample: u32) -> Self {
        let key = first_of(combine(seed, stream));
        let (drawn, chosen) = Default::default();
        Lattice { key, sample: sample.reverse_bits(), block: 0, drawn, chosen, beyond: 0 }
    }

    /// Where the sample lies in a lattice, which those of other steps and of another sort share, and where that is shifted to.
    /// Numbers after the first pair have lattices of their own.
    #[inline]
    fn begin(&self, pair: u32, sort: u32) -> (u32, u64) {
        let lattice = if pair == 0 { 0 } else { 2 * pair + sort };
        let lattice = u64::from(self.block & !STEP) << 32 | u64::from(lattice);
        let lattice = with_second(self.key, lattice);
        // As a binary fraction: aligned runs of 2^k samples stay aligned runs.
        let index = owen(self.sample, (lattice >> 32) as u32);
        let is_other = u32::from(self.block & STEP != 0);
        let place = if is_other == 1 { index.wrapping_mul(OTHER) } else { index };
        (place, mix(lattice.wrapping_add(u64::from(1 + 2 * is_other + sort))))
    }
}

impl Numbers {
    /// The next number, from a place and with a shift that are made for each pair.
    #[inline(always)]
    fn next<R: Single>(
        &mut self,
        generator: [u32; PAIR as usize],
        begin: impl FnOnce(u32) -> (u32, u64),
    ) -> R {
        let number = self.count % PAIR;
        if number == 0 {
            (self.place, self.shift) = begin(self.count / PAIR);
        }
        self.count += 1;
        let point = self.place.wrapping_mul(generator[number as usize]);
        // Either number takes all 64 bits of the shift, in another order.
        let shift = self.shift.rotate_left(32 * number);
        unit(shift.wrapping_add(u64::from(point) << 32))
    }
}

impl<R: Single> UniformSource<R> for Lattice {
    #[inline]
    fn next(&mut self) -> R {
        let mut drawn = std::mem::take(&mut self.drawn);
        let number = drawn.next(DRAWN, |pair| self.begin(pair, 0));
        self.drawn = drawn;
        number
    }

    #[inline]
    fn choice(&mut self) -> R {
        let mut chosen = std::mem::take(&mut self.chosen);
        let number = chosen.next(CHOSEN, |pair| self.begin(pair, 1));
        self.chosen = chosen;
        number
    }

    #[inline]
    fn start(&mut self, block: u32) {
        self.block = block.wrapping_add(self.beyond);
        (self.drawn.count, self.chosen.count) = (0, 0);
    }

    #[inline]
    fn piece(&mut self, number: u32) {
        self.beyond = first_block_of_piece(number);
    }
}
