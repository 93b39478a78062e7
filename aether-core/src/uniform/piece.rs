//! Sampling dimensions of pieces of a sample that are made alike.

use crate::real::Real;
use crate::uniform::UniformSource;

/// A source for one of several pieces of a sample that are made alike, such as light paths: the blocks of
/// each lie apart from those of the others, so that a source with dimensions gives them different numbers.
///
/// ```
/// use aether_core::uniform::{Piece, Sobol, UniformSource};
/// let mut source = Sobol::new(7, 0, 12);
/// let [first, second] = [0, 1].map(|number| {
///     let mut piece = Piece::new(&mut source, number);
///     UniformSource::<f64>::start(&mut piece, 3);
///     UniformSource::<f64>::next(&mut piece)
/// });
/// assert_ne!(first, second);
/// ```
#[derive(Debug)]
pub struct Piece<'u, U: ?Sized> {
    source: &'u mut U,
    /// What is added to the numbers of blocks.
    beyond: u32,
}

/// How many blocks each piece has: those of paths of 8,192 vertices.
const BLOCKS: u32 = 1 << 16;
/// How many pieces a sample may have: further ones would draw the same numbers again.
pub const MOST_PIECES: u32 = 1 << 16;

impl<'u, U: ?Sized> Piece<'u, U> {
    /// The piece with this number, below [`MOST_PIECES`]; the first draws what `source` does.
    pub fn new(source: &'u mut U, number: u32) -> Self {
        Piece { source, beyond: number.wrapping_mul(BLOCKS) }
    }
}

impl<R: Real, U: UniformSource<R> + ?Sized> UniformSource<R> for Piece<'_, U> {
    fn next(&mut self) -> R {
        self.source.next()
    }

    fn choice(&mut self) -> R {
        self.source.choice()
    }

    fn start(&mut self, block: u32) {
        self.source.start(block.wrapping_add(self.beyond));
    }
}
