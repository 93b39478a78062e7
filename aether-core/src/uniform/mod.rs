//! Sources of uniform random numbers.
//!
//! A source is keyed by (seed, stream, sample), so what a sample draws depends on nothing but its
//! own numbers: not on the thread that draws it, nor on what was drawn before.

mod pcg;
mod sobol;

pub use pcg::Pcg32;
pub use sobol::Sobol;

use crate::real::{Real, Scalar};
use crate::sampler::Uniforms;

/// A source of uniform random numbers in [0, 1).
///
/// Any closure `FnMut() -> R` is a source too (it ignores [`UniformSource::start`]). Lanes take eight
/// sources, one each.
///
/// ```
/// use aether_core::uniform::{Sobol, UniformSource, draw_uniforms};
/// let mut source = Sobol::new(7, 0, 12); // seed, pixel, sample
/// UniformSource::<f64>::start(&mut source, 3);
/// let u: [f64; 2] = draw_uniforms(&mut source);
/// assert!(u.iter().all(|u| (0.0..1.0).contains(u)));
/// ```
pub trait UniformSource<R: Real> {
    /// The next uniform, in [0, 1): never one, not even after rounding to `R`.
    fn next(&mut self) -> R;

    /// The next uniform that chooses between several things: strategies take those of `choose` here, and what a sampler
    /// draws from [`UniformSource::next`]. A source that has no notion of dimensions need not tell them apart.
    #[inline]
    fn choice(&mut self) -> R {
        self.next()
    }

    /// Begins a numbered block of sampling dimensions, so that the numbering follows the structure
    /// of a path and not the order of execution: the same block of the same sample always yields
    /// the same numbers. A source that has no notion of dimensions may ignore it.
    fn start(&mut self, block: u32);

    /// Says which of several pieces of a sample that are made alike, such as light paths, what follows belongs to, below
    /// [`MOST_PIECES`]; it is the first one, 0, until this is called. The blocks of each lie apart from those of the others,
    /// so that they have different numbers. A source that has no notion of dimensions may ignore it.
    ///
    /// ```
    /// use aether_core::uniform::{Pcg32, Sobol, UniformSource};
    /// fn drawn(mut source: impl UniformSource<f64>, pieces: [u32; 3]) -> [f64; 3] {
    ///     pieces.map(|number| {
    ///         source.piece(number);
    ///         source.start(3);
    ///         source.next()
    ///     })
    /// }
    /// for pieces in [drawn(Sobol::new(7, 0, 12), [0, 1, 0]), drawn(Pcg32::new(7, 0, 12), [0, 1, 0])] {
    ///     assert!(pieces[0] == pieces[2] && pieces[0] != pieces[1]);
    /// }
    /// ```
    #[inline]
    fn piece(&mut self, _number: u32) {}
}

/// How many blocks each piece of a sample has: those of paths of 8,192 vertices.
const BLOCKS: u32 = 1 << 16;
/// How many pieces a sample may have ([`UniformSource::piece`]): further ones would draw the same numbers again.
pub const MOST_PIECES: u32 = 1 << 16;

/// The first block of a piece of a sample, which sources add to the numbers of those that they are asked for.
pub const fn first_block_of_piece(number: u32) -> u32 {
    number.wrapping_mul(BLOCKS)
}

/// A source of which every uniform is 1/2: for strategies that draw nothing, and for the middle of what others draw.
///
/// ```
/// use aether_core::uniform::{Middle, draw_uniforms};
/// assert_eq!(draw_uniforms::<f64, [f64; 2]>(&mut Middle), [0.5; 2]);
/// ```
#[derive(Clone, Copy, Debug)]
pub struct Middle;

impl<R: Real> UniformSource<R> for Middle {
    fn next(&mut self) -> R {
        R::of(0.5)
    }
    fn start(&mut self, _block: u32) {}
}

impl<R: Real, F: FnMut() -> R> UniformSource<R> for F {
    fn next(&mut self) -> R {
        self()
    }
    fn start(&mut self, _block: u32) {}
}

/// The next uniforms of a source as the array that a sampler takes.
#[inline]
pub fn draw_uniforms<R: Real, U: Uniforms<R>>(source: &mut (impl UniformSource<R> + ?Sized)) -> U {
    U::from_fn(|_| source.next())
}

/// Any number as a uniform: what is NaN or negative becomes 0, what is 1 or more the largest number
/// below one, and all else stays.
///
/// ```
/// use aether_core::uniform::clamped;
///
/// assert_eq!([f64::NAN, -3.0, 0.25, 1.0].map(clamped), [0.0, 0.0, 0.25, 1.0 - f64::EPSILON / 2.0]);
/// ```
#[inline]
pub fn clamped<R: Scalar>(x: R) -> R {
    if x >= R::ONE {
        R::ONE.next_below()
    } else if x > R::ZERO {
        x
    } else {
        R::ZERO
    }
}

/// The number in [0, 1) whose binary fraction is `bits`, rounded to `R`; what would round to one
/// becomes the largest number below one.
#[inline]
fn unit<R: Real>(bits: u64) -> R {
    const SCALE: f64 = 1.0 / (1_u64 << 53) as f64;
    let below_one = R::ONE - R::EPSILON * R::of(0.5);
    R::of((bits >> 11) as f64 * SCALE).min(below_one)
}

/// Spreads the information in `x` over all 64 bits (the finaliser of SplitMix64, Steele et al. 2014,
/// with the constants of Stafford's variant 13). A bijection.
#[inline]
fn mix(x: u64) -> u64 {
    let x = (x ^ (x >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    let x = (x ^ (x >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    x ^ (x >> 31)
}

/// A key made of two: different for (a, b) and (b, a).
#[inline]
fn combine(a: u64, b: u64) -> u64 {
    with_second(first_of(a), b)
}

/// What all keys share that are made of this number and another one.
#[inline]
fn first_of(a: u64) -> u64 {
    mix(a.wrapping_add(0x9e37_79b9_7f4a_7c15))
}

/// The key of two numbers, the first of which is known by what its keys share.
#[inline]
fn with_second(first: u64, b: u64) -> u64 {
    mix(first.wrapping_add(b))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn mean(source: &mut dyn UniformSource<f64>) -> f64 {
        (0..10_000).map(|_| source.next()).sum::<f64>() / 1e4
    }

    #[test]
    fn sources_work_as_trait_objects_and_closures_are_sources() {
        // Standard error of the mean is 0.0029; six of them: false alarm once in 5e8.
        assert!((mean(&mut Pcg32::new(1, 2, 3)) - 0.5).abs() < 0.0174);
        let mut k = 0.0;
        let mut lattice = || {
            k += 1.0;
            (k * 0.618_033_988_749_895) % 1.0
        };
        assert!((mean(&mut lattice) - 0.5).abs() < 1e-3);
        let u: [f64; 3] = draw_uniforms(&mut || 0.25);
        assert_eq!(u, [0.25; 3]);
    }

    #[test]
    fn no_uniform_is_one() {
        assert_eq!(unit::<f64>(u64::MAX), 1.0 - f64::EPSILON / 2.0);
        assert_eq!(unit::<f32>(u64::MAX), 1.0 - f32::EPSILON / 2.0);
        assert_eq!(unit::<f32>(0), 0.0);
        assert_eq!(unit::<f64>(1 << 63), 0.5);
    }
}
