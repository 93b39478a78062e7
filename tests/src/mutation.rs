//! A deliberate mistake, to show that tests notice it.

use aether_core::{PdfOf, Real, Sampler};

/// A sampler whose densities are one percent too large.
#[derive(Clone, Copy, Debug)]
pub struct OnePercentOff<S>(pub S);

impl<R: Real, S: Sampler<R>> Sampler<R> for OnePercentOff<S> {
    type Uniforms = S::Uniforms;
    type Point = S::Point;

    fn forward(&self, u: S::Uniforms) -> (S::Point, R::Mask) {
        self.0.forward(u)
    }

    fn pdf(&self, x: &S::Point) -> PdfOf<Self, R> {
        self.0.pdf(x) * R::of(1.01)
    }

    fn pdf_of_uniforms(&self, u: S::Uniforms) -> PdfOf<Self, R> {
        self.0.pdf_of_uniforms(u) * R::of(1.01)
    }

    fn preimages(&self, x: &S::Point, visit: impl FnMut(S::Uniforms, R::Mask)) {
        self.0.preimages(x, visit);
    }
}
