//! A sampler as a map.

use crate::map::Map;
use crate::real::{Mask, Real};
use crate::sampler::Sampler;
use crate::vec::Vec2;

/// The map from the unit square (primary sample space) that a sampler of two uniforms is. After a
/// density on the unit square it makes one on the sampler's space: a table of directions, or a lobe
/// guided by a table.
///
/// The change of measure is one over the sampler's density, which is right for samplers of which
/// every point has one preimage.
#[derive(Clone, Copy, Debug)]
pub struct Warp<S>(pub S);

impl<R: Real, S: Sampler<R, Uniforms = [R; 2]>> Map<R> for Warp<S> {
    type Source = Vec2<R>;
    type Target = S::Point;
    const INJECTIVE: bool = true;

    #[inline]
    fn forward(&self, x: &Vec2<R>) -> (S::Point, R::Mask) {
        let inside = |t: R| t.ge(R::ZERO).and(t.lt(R::ONE));
        let (y, valid) = self.0.forward([x.x, x.y]);
        (y, valid.and(inside(x.x)).and(inside(x.y)))
    }

    #[inline]
    fn preimages(&self, y: &S::Point, mut visit: impl FnMut(Vec2<R>, R::Mask)) {
        self.0.preimages(y, |u, valid| visit(Vec2::new(u[0], u[1]), valid));
    }

    #[inline]
    fn jacobian(&self, x: &Vec2<R>) -> R {
        self.0.pdf_of_uniforms([x.x, x.y]).value().recip()
    }

    /// Next to the far end of a uniform a point may have digits that the uniform has no room for: so far out in a tail that the
    /// density there is none, the uniform is that of a point further in.
    #[inline]
    fn jacobian_between(&self, x: &Vec2<R>, y: &S::Point) -> R {
        let density = self.0.pdf(y).value();
        let known = density.ge(R::ZERO);
        if known.all() {
            density.recip()
        } else {
            R::select(known, density.recip(), self.jacobian(x))
        }
    }
}
