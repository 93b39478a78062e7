//! The one idea behind all tables: choose a piece, then a point of the piece.

use crate::density::Density;
use crate::discrete::{Cdf, Discrete};
use crate::point::Point;
use crate::real::{Real, Scalar};
use crate::sampler::{PdfOf, Sampler, Uniforms};

/// Disjoint pieces of a space, numbered from zero, each with a probability and a sampler.
///
/// Implement it for a reference to a table of your own; [`Piecewise`] makes the sampler of it.
pub trait Pieces<R: Scalar>: Copy {
    /// The sampler inside a piece.
    type Piece: Sampler<R>;
    /// Which uniform chooses the piece; what is left of it is spent inside.
    const AXIS: usize;

    /// The choice among the pieces.
    fn choice(&self) -> &Cdf<R>;

    /// The sampler inside a piece that has a probability.
    fn piece(&self, index: usize) -> Self::Piece;

    /// The piece that `x` lies in, and second the one that it may belong to but for rounding. None
    /// for a point outside, or one that has a NaN.
    fn locate(&self, x: &PointOf<Self, R>) -> [Option<usize>; 2];

    /// The point of a piece that is nearest to `x`, which lies in it but for rounding.
    fn confine(&self, index: usize, x: &PointOf<Self, R>) -> PointOf<Self, R>;
}

/// The space of the pieces.
pub type PointOf<P, R> = <<P as Pieces<R>>::Piece as Sampler<R>>::Point;

/// The sampler made of [`Pieces`]. Its density is the probability of the piece that a point lies in
/// times the density of the piece's own sampler, so a point costs one look-up, not a sum.
#[derive(Clone, Copy, Debug)]
pub struct Piecewise<P>(pub P);

impl<P> Piecewise<P> {
    /// Calls `visit` with the probability and the sampler of each piece that `x` may belong to, and
    /// with `x` inside of it, until one says that this is it.
    #[inline]
    fn find<R: Scalar>(
        &self,
        x: &PointOf<P, R>,
        mut visit: impl FnMut(usize, R, P::Piece, PointOf<P, R>) -> bool,
    ) where
        P: Pieces<R>,
    {
        if !x.finite() {
            return;
        }
        for index in self.0.locate(x).into_iter().flatten() {
            let probability = self.0.choice().probability(index);
            if probability > R::ZERO {
                let inside = self.0.confine(index, x);
                if visit(index, probability, self.0.piece(index), inside) {
                    return;
                }
            }
        }
    }
}

/// The array with another element at one place.
#[inline(always)]
fn replaced<R: Real, U: Uniforms<R>>(u: U, axis: usize, by: R) -> U {
    U::from_fn(|k| if k == axis { by } else { u.as_ref()[k] })
}

impl<R: Scalar, P: Pieces<R>> Sampler<R> for Piecewise<P> {
    type Uniforms = <P::Piece as Sampler<R>>::Uniforms;
    type Point = PointOf<P, R>;

    #[inline]
    fn forward(&self, u: Self::Uniforms) -> (Self::Point, bool) {
        let (choice, rest) = self.0.choice().sample_reuse(u.as_ref()[P::AXIS]);
        let (x, valid) = self.0.piece(choice.index).forward(replaced(u, P::AXIS, rest));
        (self.0.confine(choice.index, &x), valid)
    }

    #[inline]
    fn pdf(&self, x: &Self::Point) -> PdfOf<Self, R> {
        let mut found = R::ZERO;
        self.find(x, |_, probability, piece, x| {
            found = probability * piece.pdf(&x).value();
            found > R::ZERO
        });
        Density::new(found)
    }

    #[inline]
    fn pdf_of_uniforms(&self, u: Self::Uniforms) -> PdfOf<Self, R> {
        self.forward_with_pdf(u).2
    }

    #[inline]
    fn forward_with_pdf(&self, u: Self::Uniforms) -> (Self::Point, bool, PdfOf<Self, R>) {
        let (choice, rest) = self.0.choice().sample_reuse(u.as_ref()[P::AXIS]);
        let piece = self.0.piece(choice.index);
        let (x, valid, inside) = piece.forward_with_pdf(replaced(u, P::AXIS, rest));
        let density = Density::new(choice.probability * inside.value());
        (self.0.confine(choice.index, &x), valid, density)
    }

    #[inline]
    fn preimages(&self, x: &Self::Point, mut visit: impl FnMut(Self::Uniforms, bool)) {
        self.find(x, |index, _, piece, x| {
            let mut any = false;
            piece.preimages(&x, |v, valid| {
                let chosen = self.0.choice().uniform(index, v.as_ref()[P::AXIS]);
                if let (true, Some(u)) = (valid, chosen) {
                    any = true;
                    visit(replaced(v, P::AXIS, u), true);
                }
            });
            any
        });
    }
}
