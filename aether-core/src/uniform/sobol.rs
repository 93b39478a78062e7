//! Owen-scrambled Sobol points, padded by blocks (Burley 2020, "Practical Hash-based Owen
//! Scrambling", JCGT 9(4)).

use super::{UniformSource, combine, first_block_of_piece, first_of, mix, unit, with_second};
use crate::real::Single;

/// How many dimensions are stratified jointly; later ones are padded with shuffled copies.
const JOINT: usize = 4;

/// How many numbers that are drawn, and how many that choose, are of the first group of a block. The sequence's first two
/// dimensions are the best pair of all, and a sampler mostly draws two numbers, on which more depends than on choices.
const FIRST: u32 = JOINT as u32 / 2;

/// Primitive polynomials (degree, inner coefficients) and initial direction integers of dimensions
/// 2 to 4 of Joe and Kuo's table (2008).
const TABLE: [(usize, u32, [u32; 3]); JOINT - 1] =
    [(1, 0, [1, 0, 0]), (2, 1, [1, 3, 0]), (3, 1, [1, 3, 1])];

/// Direction numbers of the first dimensions.
const DIRECTIONS: [[u32; 32]; JOINT] = directions();

const fn directions() -> [[u32; 32]; JOINT] {
    let mut all = [[0; 32]; JOINT];
    let mut bit = 0;
    while bit < 32 {
        all[0][bit] = 1 << (31 - bit);
        bit += 1;
    }
    let mut dimension = 1;
    while dimension < JOINT {
        let (degree, coefficients, initial) = TABLE[dimension - 1];
        let mut v = [0_u32; 32];
        let mut k = 0;
        while k < 32 {
            if k < degree {
                v[k] = initial[k] << (31 - k);
            } else {
                v[k] = v[k - degree] ^ (v[k - degree] >> degree);
                let mut j = 1;
                while j < degree {
                    if (coefficients >> (degree - 1 - j)) & 1 == 1 {
                        v[k] ^= v[k - j];
                    }
                    j += 1;
                }
            }
            k += 1;
        }
        all[dimension] = v;
        dimension += 1;
    }
    all
}

/// What each four bits of an index, the bits of which are in opposite order, add to its point, whose bits are too: by their
/// value, the numbers of a group beside each other.
const NIBBLES: [[[u32; JOINT]; 16]; 8] = nibbles();

const fn nibbles() -> [[[u32; JOINT]; 16]; 8] {
    let mut all = [[[0; JOINT]; 16]; 8];
    let mut i = 0;
    while i < 8 * 16 * JOINT {
        let (nibble, value, number) = (i / (16 * JOINT), i / JOINT % 16, i % JOINT);
        let mut bit = 0;
        while bit < 4 {
            if (value >> bit) & 1 == 1 {
                all[nibble][value][number] ^=
                    DIRECTIONS[number][31 - (4 * nibble + bit)].reverse_bits();
            }
            bit += 1;
        }
        i += 1;
    }
    all
}

/// The point of the Sobol sequence with an index, in the dimensions of a group, as binary fractions. The bits of all are in
/// opposite order: of a number the first one behind the point is the lowest.
#[inline(always)]
fn reversed_sobol(reversed_index: u32) -> [u32; JOINT] {
    let mut point = [0; JOINT];
    for (i, nibble) in NIBBLES.iter().enumerate() {
        let row = &nibble[(reversed_index >> (4 * i)) as usize & 15];
        for (x, bits) in point.iter_mut().zip(row) {
            *x ^= bits;
        }
    }
    point
}

/// Owen's nested uniform scrambling of a binary fraction whose bits are in opposite order: a hash in which each bit depends only
/// on the bits below it (Laine and Karras 2011, with the constants that Vegdahl found).
#[inline]
fn owen(mut x: u32, seed: u32) -> u32 {
    x ^= x.wrapping_mul(0x3d20_adea);
    x = x.wrapping_add(seed);
    x = x.wrapping_mul((seed >> 16) | 1);
    x ^= x.wrapping_mul(0x0552_6c56);
    x ^ x.wrapping_mul(0x53a2_2864)
}

/// Owen-scrambled Sobol points: the samples of one stream are stratified over each group of four
/// dimensions, streams and groups are independent of each other. Up to 2^32 samples a stream.
///
/// A block starts a new group, so that each block has its own well-distributed dimensions whatever
/// the blocks before it consumed. The first two numbers that are drawn are the sequence's first two
/// dimensions, of which 2^k samples have one point in each elementary interval; the first two that choose
/// ([`UniformSource::choice`]) are the other two.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Sobol {
    /// What the randomisations of this seed and stream share.
    key: u64,
    /// The number of the sample, with its bits in opposite order.
    sample: u32,
    block: u32,
    /// Numbers drawn since the block began, and numbers that chose.
    drawn: u32,
    chosen: u32,
    /// The current group of the block, or [`NONE`].
    group: u32,
    /// The shuffled number of the sample in it, also reversed.
    index: u32,
    /// What is added to the numbers of blocks, for the current piece of the sample.
    beyond: u32,
    /// Randomisations of the group's dimensions, of two each.
    pairs: [u64; JOINT / 2],
    /// The scrambled point, as binary fractions.
    point: [u32; JOINT],
}

impl Sobol {
    /// The point number `sample` of the stream (say, the pixel).
    pub fn new(seed: u64, stream: u64, sample: u32) -> Self {
        let (key, sample) = (first_of(combine(seed, stream)), sample.reverse_bits());
        let (block, group, index, beyond) = (0, NONE, 0, 0);
        let (pairs, point) = ([0; JOINT / 2], [0; JOINT]);
        Sobol { key, sample, block, drawn: 0, chosen: 0, group, index, beyond, pairs, point }
    }

    /// Shuffles the sample index for a group, and finds its point: in all dimensions
    /// at once, as mostly several are drawn, and none waits for another.
    #[inline]
    fn begin_group(&mut self, group: u32) {
        self.group = group;
        let group = with_second(self.key, u64::from(self.block) << 32 | u64::from(group));
        // As a binary fraction: aligned runs of 2^k samples stay aligned runs.
        self.index = owen(self.sample, (group >> 32) as u32);
        let pairs @ [a, b] = [1, 3].map(|number| mix(group.wrapping_add(number)));
        let seeds = [a as u32, (a >> 32) as u32, b as u32, (b >> 32) as u32];
        let reversed = reversed_sobol(self.index);
        let scrambled: [u32; JOINT] = core::array::from_fn(|i| owen(reversed[i], seeds[i]));
        self.point = scrambled.map(u32::reverse_bits);
        self.pairs = pairs;
    }
}

/// No group.
const NONE: u32 = u32::MAX;

/// Which group the number `index` of one of the two sorts is of, and which dimension: the first two of either share the first
/// group, and all others have groups of their own.
#[inline(always)]
fn place(index: u32, chooses: bool) -> (u32, usize) {
    match index.checked_sub(FIRST) {
        None => (0, (index + if chooses { FIRST } else { 0 }) as usize),
        Some(beyond) => {
            let group = 2 + 2 * (beyond / JOINT as u32) + u32::from(chooses);
            (group, beyond as usize % JOINT)
        }
    }
}

impl Sobol {
    /// The number of a dimension of a group.
    #[inline]
    fn number<R: Single>(&mut self, (group, number): (u32, usize)) -> R {
        if self.group != group {
            self.begin_group(group);
        }
        let high = self.point[number];
        // Scrambling goes on for ever: the bits below the 32nd are random. Mostly single precision has none of them.
        let is_enough = size_of::<R>() <= 4 && high >= 1 << 24;
        let low = if is_enough {
            0
        } else {
            let pair = self.pairs[number / 2] >> (32 * (number % 2));
            mix(!pair ^ u64::from(self.index.reverse_bits())) >> 32
        };
        unit(u64::from(high) << 32 | low)
    }
}

impl<R: Single> UniformSource<R> for Sobol {
    #[inline]
    fn next(&mut self) -> R {
        self.drawn += 1;
        self.number(place(self.drawn - 1, false))
    }

    #[inline]
    fn choice(&mut self) -> R {
        self.chosen += 1;
        self.number(place(self.chosen - 1, true))
    }

    #[inline]
    fn start(&mut self, block: u32) {
        let block = block.wrapping_add(self.beyond);
        (self.block, self.drawn, self.chosen, self.group) = (block, 0, 0, NONE);
    }

    #[inline]
    fn piece(&mut self, number: u32) {
        self.beyond = first_block_of_piece(number);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn point(seed: u64, stream: u64, sample: u32, block: u32) -> [f64; 6] {
        let mut source = Sobol::new(seed, stream, sample);
        UniformSource::<f64>::start(&mut source, block);
        core::array::from_fn(|_| source.next())
    }

    #[test]
    fn first_points_of_the_unscrambled_sequence() {
        // The first eight points that Joe and Kuo's program prints (it runs in Gray code order).
        let eighths = |number: usize| {
            [0_u32, 1, 2, 3, 4, 5, 6, 7]
                .map(|k| reversed_sobol((k ^ (k >> 1)).reverse_bits())[number].reverse_bits() >> 29)
        };
        assert_eq!(eighths(0), [0, 4, 6, 2, 3, 7, 5, 1]);
        assert_eq!(eighths(1), [0, 4, 2, 6, 3, 7, 1, 5]);
        assert_eq!(eighths(2), [0, 4, 2, 6, 5, 1, 7, 3]);
    }

    #[test]
    fn one_point_in_each_elementary_interval() {
        for (seed, stream, block) in [(0, 0, 0), (1, 5, 3), (9, 1_000_000, 77)] {
            let points: Vec<_> = (0..256).map(|k| point(seed, stream, k, block)).collect();
            for bits in 0..=8 {
                let (columns, rows) = ((1 << bits) as f64, (1 << (8 - bits)) as f64);
                let mut count = [0; 256];
                // Of the sequence's first two dimensions.
                for [x, y, ..] in &points {
                    count[((x * columns).floor() * rows + (y * rows).floor()) as usize] += 1;
                }
                assert_eq!(count, [1; 256], "{columns} x {rows} intervals");
            }
            // Every single dimension is stratified too, also beyond the first group.
            for d in 0..6 {
                let mut count = [0; 256];
                points.iter().for_each(|p| count[(p[d] * 256.0) as usize] += 1);
                assert_eq!(count, [1; 256], "dimension {d}");
            }
        }
    }

    /// Numbers of a block in some order: those that choose, and those that are drawn.
    fn numbers(sample: u32, chooses: [bool; 8]) -> [Vec<f64>; 2] {
        let mut source = Sobol::new(4, 5, sample);
        UniformSource::<f64>::start(&mut source, 6);
        let mut found = [Vec::new(), Vec::new()];
        for chooses in chooses {
            let number = if chooses { source.choice() } else { source.next() };
            found[usize::from(!chooses)].push(number);
        }
        found
    }

    #[test]
    fn numbers_that_choose_are_others_and_as_well_distributed() {
        let (t, f) = (true, false);
        let (mixed, apart) = ([t, f, t, t, f, f, f, t], [f, f, f, f, t, t, t, t]);
        let points: Vec<_> = (0..256).map(|k| numbers(k, mixed)).collect();
        for (k, point) in (0..).zip(&points) {
            assert_eq!(*point, numbers(k, apart));
            let mut all: Vec<f64> = point.concat();
            all.sort_by(f64::total_cmp);
            assert!(all.windows(2).all(|pair| pair[0] < pair[1]), "{point:?}");
        }
        for (sort, d) in [(0, 0), (0, 1), (0, 2), (0, 3), (1, 0), (1, 3)] {
            let mut count = [0; 256];
            points.iter().for_each(|p| count[(p[sort][d] * 256.0) as usize] += 1);
            assert_eq!(count, [1; 256], "sort {sort}, dimension {d}");
        }
    }

    #[test]
    fn determined_by_its_numbers_and_by_the_block_alone() {
        assert_eq!(point(1, 2, 3, 4), point(1, 2, 3, 4));
        for other in [point(0, 2, 3, 4), point(1, 0, 3, 4), point(1, 2, 0, 4), point(1, 2, 3, 0)] {
            assert_ne!(other, point(1, 2, 3, 4));
        }
        let mut source = Sobol::new(1, 2, 3);
        UniformSource::<f64>::start(&mut source, 9);
        (0..17).for_each(|_| {
            UniformSource::<f64>::next(&mut source);
        });
        UniformSource::<f64>::start(&mut source, 4);
        assert_eq!(UniformSource::<f64>::next(&mut source), point(1, 2, 3, 4)[0]);
    }

    #[test]
    fn scrambling_is_uniform_over_seeds() {
        // 64 cells, 63 degrees of freedom: chi-square above 139 once in 1e7.
        let mut counts = [0.0; 64];
        (0..64_000).for_each(|s| counts[(point(s, 0, 5, 0)[1] * 64.0) as usize] += 1.0);
        let chi_square: f64 = counts.iter().map(|c: &f64| (c - 1e3).powi(2) / 1e3).sum();
        assert!(chi_square < 139.0, "{chi_square}");
    }

    #[test]
    fn groups_and_blocks_are_not_correlated() {
        // Correlation of 4096 points of independent dimensions: standard deviation 1/64; 6 of them.
        let correlation = |pick: &dyn Fn(u32) -> (f64, f64)| {
            let sum: f64 = (0..4096).map(pick).map(|(a, b)| (a - 0.5) * (b - 0.5)).sum();
            sum / 4096.0 * 12.0
        };
        let groups = correlation(&|k| (point(3, 3, k, 0)[0], point(3, 3, k, 0)[4]));
        let blocks = correlation(&|k| (point(3, 3, k, 0)[0], point(3, 3, k, 1)[0]));
        assert!(groups.abs() < 0.094 && blocks.abs() < 0.094, "{groups} {blocks}");
    }
}
