//! The PCG32 generator (O'Neill 2014, "PCG: A Family of Simple Fast Space-Efficient Statistically
//! Good Algorithms for Random Number Generation").

use super::{UniformSource, combine, first_block_of_piece, first_of, unit, with_second};
use crate::real::Single;

const MULTIPLIER: u64 = 6_364_136_223_846_793_005;

/// Pseudo-random numbers: 64 bits of state, 2^63 streams, period 2^64.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Pcg32 {
    state: u64,
    /// Odd; names the stream.
    increment: u64,
    /// What the blocks of this sample are derived from.
    key: u64,
    /// What its places have in common.
    places: u64,
    /// What is added to the numbers of blocks, for the current piece of the sample.
    beyond: u32,
}

impl Pcg32 {
    /// The generator of one sample of one stream (say, of a pixel). Any two (seed, stream, sample)
    /// have unrelated states.
    pub fn new(seed: u64, stream: u64, sample: u64) -> Self {
        let stream = combine(seed, stream);
        Self::with_sequence(combine(stream, sample), stream)
    }

    /// The generator with the given initial state on the given sequence, as the reference
    /// implementation (`pcg32_srandom`), pbrt and Mitsuba seed it.
    pub fn with_sequence(initial_state: u64, sequence: u64) -> Self {
        let mut pcg = Self::from_words([0, (sequence << 1) | 1, initial_state]);
        pcg.next_u32();
        pcg.state = pcg.state.wrapping_add(initial_state);
        pcg.next_u32();
        pcg
    }

    /// All that the next numbers depend on, to be kept in a file.
    pub fn words(&self) -> [u64; 3] {
        [self.state, self.increment, self.key]
    }

    /// The generator whose [`Pcg32::words`] these are: it goes on with the same numbers.
    pub fn from_words([state, increment, key]: [u64; 3]) -> Self {
        Pcg32 { state, increment, key, places: first_of(key), beyond: 0 }
    }

    /// The next 32 random bits.
    #[inline]
    pub fn next_u32(&mut self) -> u32 {
        let old = self.state;
        self.state = old.wrapping_mul(MULTIPLIER).wrapping_add(self.increment);
        let xor_shifted = (((old >> 18) ^ old) >> 27) as u32;
        xor_shifted.rotate_right((old >> 59) as u32)
    }

    /// Skips `steps` outputs of 32 bits (backwards by wrapping around) in 64 steps at most (Brown
    /// 1994, "Random Number Generation with Arbitrary Strides").
    pub fn advance(&mut self, mut steps: u64) {
        let (mut multiplier, mut increment) = (MULTIPLIER, self.increment);
        let (mut all_multiplier, mut all_increment) = (1_u64, 0_u64);
        while steps > 0 {
            if steps & 1 == 1 {
                all_multiplier = all_multiplier.wrapping_mul(multiplier);
                all_increment = all_increment.wrapping_mul(multiplier).wrapping_add(increment);
            }
            increment = multiplier.wrapping_add(1).wrapping_mul(increment);
            multiplier = multiplier.wrapping_mul(multiplier);
            steps >>= 1;
        }
        self.state = all_multiplier.wrapping_mul(self.state).wrapping_add(all_increment);
    }
}

/// Draws 32 bits for a type of `f32`'s precision, 64 bits for a finer one.
impl<R: Single> UniformSource<R> for Pcg32 {
    #[inline]
    fn next(&mut self) -> R {
        let high = u64::from(self.next_u32()) << 32;
        let fine = R::EPSILON.to_f64() < 1e-9;
        unit(if fine { high | u64::from(self.next_u32()) } else { high })
    }

    /// Moves to a place of its own for each block. The place is hashed: states that are a multiple
    /// of a power of two apart share their low bits.
    #[inline]
    fn start(&mut self, block: u32) {
        self.state = with_second(self.places, u64::from(block.wrapping_add(self.beyond)));
    }

    #[inline]
    fn piece(&mut self, number: u32) {
        self.beyond = first_block_of_piece(number);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn first_outputs_of_the_reference_implementation() {
        // The demo program of the reference C library, seeded with (42, 54).
        let mut pcg = Pcg32::with_sequence(42, 54);
        let expected =
            [0xa15c_02b7, 0x7b47_f409, 0xba1d_3330, 0x83d2_f293, 0xbfa4_784b, 0xcbed_606e];
        assert_eq!(expected.map(|_| pcg.next_u32()), expected);
    }

    #[test]
    fn advancing_is_skipping() {
        let mut walked = Pcg32::with_sequence(1, 2);
        let start = walked.clone();
        (0..1000).for_each(|_| {
            walked.next_u32();
        });
        let mut jumped = start.clone();
        jumped.advance(1000);
        assert_eq!(jumped, walked);
        jumped.advance(1000_u64.wrapping_neg());
        assert_eq!(jumped, start);
    }

    #[test]
    fn words_are_the_whole_state() {
        let mut pcg = Pcg32::new(1, 2, 3);
        pcg.advance(7);
        let mut again = Pcg32::from_words(pcg.words());
        assert_eq!(again.next_u32(), pcg.next_u32());
        for pcg in [&mut pcg, &mut again] {
            UniformSource::<f64>::start(pcg, 4);
        }
        assert_eq!(again.next_u32(), pcg.next_u32());
    }

    #[test]
    fn same_key_same_numbers_other_key_other_numbers() {
        let first = |seed, stream, sample, block| -> f64 {
            let mut pcg = Pcg32::new(seed, stream, sample);
            UniformSource::<f64>::start(&mut pcg, block);
            pcg.next()
        };
        assert_eq!(first(1, 2, 3, 4), first(1, 2, 3, 4));
        for other in [first(2, 2, 3, 4), first(1, 3, 3, 4), first(1, 2, 4, 4), first(1, 2, 3, 5)] {
            assert_ne!(other, first(1, 2, 3, 4));
        }
    }

    #[test]
    fn uniform_along_and_across_streams() {
        // 64 cells, 63 degrees of freedom: chi-square above 139 once in 1e7 per test.
        let chi_square = |draw: &mut dyn FnMut(u64) -> f64| {
            let mut counts = [0.0; 64];
            (0..64_000).for_each(|k| counts[(draw(k) * 64.0) as usize] += 1.0);
            counts.iter().map(|c: &f64| (c - 1e3).powi(2) / 1e3).sum::<f64>()
        };
        let mut pcg = Pcg32::new(5, 6, 7);
        assert!(chi_square(&mut |_| pcg.next()) < 139.0);
        assert!(chi_square(&mut |k| Pcg32::new(0, 0, k).next()) < 139.0);
        assert!(chi_square(&mut |k| Pcg32::new(0, k, 0).next()) < 139.0);
        let mut blocks = Pcg32::new(0, 0, 0);
        assert!(
            chi_square(&mut |k| {
                UniformSource::<f64>::start(&mut blocks, k as u32);
                UniformSource::<f64>::next(&mut blocks)
            }) < 139.0
        );
    }
}
