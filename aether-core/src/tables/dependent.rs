//! Two variables, one drawn given the other.

use crate::density::Density;
use crate::real::Real;
use crate::sampler::{PdfOf, Sampler};
use crate::vec::Vec2;

/// A family of random variables on the line with a number as parameter.
pub trait Family<R: Real>: Copy {
    /// The members.
    type Member: Sampler<R, Uniforms = [R; 1], Point = R>;
    /// The member with this parameter, if there is one.
    fn given(&self, y: R) -> Option<Self::Member>;
}

/// The point (x, y) of the plane with y from a sampler and the second uniform, and x from the member
/// of a family that y selects and the first uniform. The density is the product of both: the map is
/// triangular.
#[derive(Clone, Copy, Debug)]
pub struct Dependent<S, F> {
    y: S,
    x: F,
}

impl<S, F> Dependent<S, F> {
    /// y from `y`, then x from the member of `x` that y selects.
    pub fn new(y: S, x: F) -> Self {
        Dependent { y, x }
    }

    /// The family that x is from.
    pub fn family(&self) -> &F {
        &self.x
    }
}

impl<R, S, F> Sampler<R> for Dependent<S, F>
where
    R: Real<Mask = bool>,
    S: Sampler<R, Uniforms = [R; 1], Point = R>,
    F: Family<R>,
{
    type Uniforms = [R; 2];
    type Point = Vec2<R>;

    #[inline]
    fn forward(&self, u: [R; 2]) -> (Vec2<R>, bool) {
        let (y, first) = self.y.forward([u[1]]);
        match self.x.given(y) {
            None => (Vec2::new(R::ZERO, y), false),
            Some(member) => {
                let (x, second) = member.forward([u[0]]);
                (Vec2::new(x, y), first && second)
            }
        }
    }

    #[inline]
    fn pdf(&self, p: &Vec2<R>) -> PdfOf<Self, R> {
        let Some(member) = self.x.given(p.y) else { return Density::ZERO };
        Density::new(self.y.pdf(&p.y).value() * member.pdf(&p.x).value())
    }

    #[inline]
    fn pdf_of_uniforms(&self, u: [R; 2]) -> PdfOf<Self, R> {
        self.forward_with_pdf(u).2
    }

    #[inline]
    fn forward_with_pdf(&self, u: [R; 2]) -> (Vec2<R>, bool, PdfOf<Self, R>) {
        let (y, first, p) = self.y.forward_with_pdf([u[1]]);
        let Some(member) = self.x.given(y) else {
            return (Vec2::new(R::ZERO, y), false, Density::ZERO);
        };
        let (x, second, q) = member.forward_with_pdf([u[0]]);
        (Vec2::new(x, y), first && second, Density::new(p.value() * q.value()))
    }

    #[inline]
    fn preimages(&self, p: &Vec2<R>, mut visit: impl FnMut([R; 2], bool)) {
        let Some(member) = self.x.given(p.y) else { return };
        self.y.preimages(&p.y, |v, outer| {
            member.preimages(&p.x, |u, inner| visit([u[0], v[0]], outer && inner));
        });
    }
}
