//! Maps between spaces, and their composition with samplers: what `#[map]` derives.

use crate::density::Density;
use crate::point::Point;
use crate::real::{Mask, Real};
use crate::sampler::{Errors, PdfOf, Sampler};
use crate::support::{add_logs, log_density};

/// A differentiable map from one space to another, with its inverse and its change of measure
/// derived by the compiler. Made by `#[map]`.
pub trait Map<R: Real>: Copy {
    /// The space that it maps from.
    type Source: Point<R>;
    /// The space that it maps to.
    type Target: Point<R>;
    /// Whether no point has more than one preimage, so that nobody need look for others.
    const INJECTIVE: bool = false;

    /// The image of `x`, and whether there is one.
    fn forward(&self, x: &Self::Source) -> (Self::Target, R::Mask);

    /// Calls `visit` with every preimage of `y` (where the mask holds, and then its coordinates are finite).
    fn preimages(&self, y: &Self::Target, visit: impl FnMut(Self::Source, R::Mask));

    /// The preimages of a point whose coordinates are known to within `errors`, each with bounds for the errors that
    /// its own coordinates have by that and by rounding; none, if the map does not know them.
    #[inline]
    fn preimages_near(
        &self,
        y: &Self::Target,
        errors: Errors<'_, Self::Target, R>,
        mut visit: impl FnMut(Self::Source, Errors<'_, Self::Source, R>, R::Mask),
    ) {
        let _ = errors;
        self.preimages(y, |x, valid| visit(x, &|| no_errors(&x), valid));
    }

    /// The change of measure at `x`: how much the map stretches the measure of the source space to
    /// that of the target (units of the target's measure over units of the source's), the
    /// derivative restricted to the tangent space of the source.
    fn jacobian(&self, x: &Self::Source) -> R;

    /// The change of measure at `x`, a preimage of `y` that was found by rounding. A map that tells it better from `y`
    /// than from `x` does so.
    #[inline(always)]
    fn jacobian_between(&self, x: &Self::Source, y: &Self::Target) -> R {
        let _ = y;
        self.jacobian(x)
    }

    /// The density at `y` by way of its preimage `x`, at which it is `p`: p over the change of measure there. A map that
    /// knows one over that in terms of `y` multiplies by it.
    #[inline(always)]
    fn pushed(&self, p: R, (x, y): (&Self::Source, &Self::Target)) -> R {
        p / self.jacobian_between(x, y)
    }

    /// Calls `visit` with every preimage of `y` (where the mask holds), and with the density at `y` by way of it if it has the
    /// density one: one over the change of measure. The points that maps one after the other go through on the way back are
    /// not computed again for that.
    #[inline(always)]
    fn preimages_pushed(&self, y: &Self::Target, mut visit: impl FnMut(Self::Source, R, R::Mask)) {
        self.preimages(y, |x, valid| {
            let density = if valid.any() { self.pushed(R::ONE, (&x, y)) } else { R::ZERO };
            visit(x, density, valid);
        });
    }

    /// The natural logarithm of [`Map::jacobian`].
    #[inline]
    fn log_jacobian(&self, x: &Self::Source) -> R {
        self.jacobian(x).ln()
    }

    /// The image of `x`; meaningful where [`Map::forward`] says that there is one.
    #[inline(always)]
    fn apply(&self, x: &Self::Source) -> Self::Target {
        self.forward(x).0
    }

    /// This map, then another.
    #[inline(always)]
    fn then<M: Map<R, Source = Self::Target>>(self, next: M) -> Then<Self, M> {
        Then::new(self, next)
    }
}

/// One thing after another: a sampler and a map, or two maps. Densities divide by the change of
/// measure at each step, summed over the preimages of each.
#[derive(Clone, Copy, Debug)]
pub struct Then<A, B> {
    first: A,
    second: B,
}

impl<A, B> Then<A, B> {
    /// `second` after `first`.
    #[inline(always)]
    pub fn new(first: A, second: B) -> Self {
        Then { first, second }
    }
}

/// Calls `visit` with the preimages of `y`, the image of `x`, other than `x` itself. Of several, the
/// nearest is taken to be `x`: inverted, it need not be `x` to the last digit.
#[inline(always)]
pub(crate) fn other_preimages<R: Real, M: Map<R>>(
    map: &M,
    x: &M::Source,
    y: &M::Target,
    mut visit: impl FnMut(M::Source, R::Mask),
) {
    if M::INJECTIVE {
        return;
    }
    let (mut count, mut nearest) = (0, R::INFINITY);
    map.preimages(y, |z, valid| {
        count += 1;
        nearest = nearest.min(R::select(valid, distance(x, &z), R::INFINITY));
    });
    if count <= 1 {
        return;
    }
    let mut counted = R::Mask::FALSE;
    map.preimages(y, |z, valid| {
        let itself = valid.and(counted.not()).and(distance(x, &z).le(nearest));
        counted = counted.or(itself);
        let other = valid.and(itself.not());
        if other.any() {
            visit(z, other);
        }
    });
}

/// The largest difference of coordinates.
#[inline(always)]
fn distance<R: Real, P: Point<R>>(x: &P, z: &P) -> R {
    let (x, z) = (x.coordinates(), z.coordinates());
    let mut largest = R::ZERO;
    for (x, z) in x.as_ref().iter().zip(z.as_ref()) {
        largest = largest.max((*x - *z).abs());
    }
    largest
}

/// Zero for each coordinate of a point.
pub(crate) fn no_errors<R: Real, P: Point<R>>(x: &P) -> P::Coordinates {
    let mut errors = x.coordinates();
    errors.as_mut().fill(R::ZERO);
    errors
}

/// The density of the images of a sampler's points at `y` by way of one preimage, `x`; zero if it is not valid.
#[inline(always)]
pub(crate) fn by_way_of<R: Real, S: Sampler<R>, M: Map<R, Source = S::Point>>(
    sampler: &S,
    map: &M,
    (x, y): (&S::Point, &M::Target),
    valid: R::Mask,
) -> R {
    if !valid.any() {
        return R::ZERO;
    }
    pulled(sampler.pdf_of_finite(x).value(), map, (x, y), valid)
}

/// The density at `y` by way of a preimage `x` at which it is `p`.
#[inline(always)]
fn pulled<R: Real, M: Map<R>>(
    p: R,
    map: &M,
    (x, y): (&M::Source, &M::Target),
    valid: R::Mask,
) -> R {
    let inside = valid.and(p.gt(R::ZERO));
    // Where the sampler has no density the map need not have a derivative.
    if !inside.any() {
        return R::ZERO;
    }
    let q = map.pushed(p, (x, y));
    // Nor is a quotient of infinities a density.
    R::select(inside.and(q.ge(R::ZERO)), q, R::ZERO)
}

impl<S, M> Then<S, M> {
    /// [`by_way_of`], not in line.
    #[inline(never)]
    fn by_way_of<R: Real>(&self, x: &S::Point, y: &M::Target, valid: R::Mask) -> R
    where
        S: Sampler<R>,
        M: Map<R, Source = S::Point>,
    {
        by_way_of(&self.first, &self.second, (x, y), valid)
    }

    /// The density where it is positive, and where it is not that of a point which rounding may have put outside.
    #[cold]
    #[inline(never)]
    fn or_beside<R: Real>(&self, density: R, y: &M::Target) -> R
    where
        S: Sampler<R>,
        M: Map<R, Source = S::Point>,
    {
        let beside = self.pdf_near(y, &|| no_errors(y)).value();
        R::select(density.gt(R::ZERO), density, beside)
    }
}

impl<R: Real, S: Sampler<R>, M: Map<R, Source = S::Point>> Sampler<R> for Then<S, M> {
    type Uniforms = S::Uniforms;
    type Point = M::Target;

    #[inline(always)]
    fn forward(&self, u: S::Uniforms) -> (M::Target, R::Mask) {
        let (x, sampled) = self.first.forward(u);
        let (y, mapped) = self.second.forward(&x);
        (y, sampled.and(mapped))
    }

    #[inline(always)]
    fn pdf(&self, y: &M::Target) -> PdfOf<Self, R> {
        let p = self.pdf_as_is(y).value();
        Density::new(if p.gt(R::ZERO).all() { p } else { self.or_beside(p, y) })
    }

    #[inline(always)]
    fn pdf_as_is(&self, y: &M::Target) -> PdfOf<Self, R> {
        // The last preimage, mostly the only one, is taken in line, which the body of a closure rarely is.
        let (mut sum, mut last) = (R::ZERO, None);
        self.second.preimages(y, |x, valid| {
            if let Some((x, valid)) = last.replace((x, valid)) {
                sum += self.by_way_of(&x, y, valid);
            }
        });
        if let Some((x, valid)) = last {
            sum += by_way_of(&self.first, &self.second, (&x, y), valid);
        }
        Density::new(sum)
    }

    #[inline]
    fn pdf_near(&self, y: &M::Target, errors: Errors<'_, M::Target, R>) -> PdfOf<Self, R> {
        let mut sum = R::ZERO;
        self.second.preimages_near(y, errors, |x, errors, valid| {
            if valid.any() {
                let density = self.first.pdf_near(&x, errors).value();
                sum += pulled(density, &self.second, (&x, y), valid);
            }
        });
        Density::new(sum)
    }

    #[inline]
    fn log_pdf(&self, y: &M::Target) -> R {
        let density = self.pdf(y).value();
        log_density(density, || {
            let mut sum = -R::INFINITY;
            self.second.preimages(y, |x, valid| {
                if valid.any() {
                    let p = self.first.log_pdf(&x);
                    let inside = valid.and(p.gt(-R::INFINITY));
                    let q = R::select(inside, p - self.second.log_jacobian(&x), p);
                    sum = add_logs(sum, R::select(inside, q, -R::INFINITY));
                }
            });
            R::select(sum.gt(-R::INFINITY), sum, density.ln())
        })
    }

    #[inline(always)]
    fn pdf_of_uniforms(&self, u: S::Uniforms) -> PdfOf<Self, R> {
        self.forward_with_pdf(u).2
    }

    #[inline(always)]
    fn forward_with_pdf(&self, u: S::Uniforms) -> (M::Target, R::Mask, PdfOf<Self, R>) {
        let (x, sampled, p) = self.first.forward_with_pdf(u);
        let (y, mapped) = self.second.forward(&x);
        let p = p.value() / self.second.jacobian(&x);
        let mut sum = R::select(p.ge(R::ZERO), p, R::ZERO);
        // Other points that have the same image only inversion finds.
        other_preimages(&self.second, &x, &y, |z, valid| {
            sum += by_way_of(&self.first, &self.second, (&z, &y), valid);
        });
        (y, sampled.and(mapped), Density::new(sum))
    }

    #[inline(always)]
    fn preimages(&self, y: &M::Target, mut visit: impl FnMut(S::Uniforms, R::Mask)) {
        self.second.preimages(y, |x, outer| {
            self.first.preimages(&x, |u, inner| visit(u, outer.and(inner)));
        });
    }
}

impl<R: Real, A: Map<R>, B: Map<R, Source = A::Target>> Map<R> for Then<A, B> {
    type Source = A::Source;
    type Target = B::Target;
    const INJECTIVE: bool = A::INJECTIVE && B::INJECTIVE;

    #[inline(always)]
    fn forward(&self, x: &A::Source) -> (B::Target, R::Mask) {
        let (y, first) = self.first.forward(x);
        let (z, second) = self.second.forward(&y);
        (z, first.and(second))
    }

    #[inline(always)]
    fn preimages(&self, z: &B::Target, mut visit: impl FnMut(A::Source, R::Mask)) {
        self.second.preimages(z, |y, outer| {
            self.first.preimages(&y, |x, inner| visit(x, outer.and(inner)));
        });
    }

    #[inline(always)]
    fn preimages_pushed(&self, z: &B::Target, mut visit: impl FnMut(A::Source, R, R::Mask)) {
        self.second.preimages(z, |y, outer| {
            self.first.preimages_pushed(&y, |x, density, inner| {
                let valid = outer.and(inner);
                let is_there = valid.any();
                let density = if is_there { self.second.pushed(density, (&y, z)) } else { density };
                visit(x, density, valid);
            });
        });
    }

    #[inline]
    fn preimages_near(
        &self,
        z: &B::Target,
        errors: Errors<'_, B::Target, R>,
        mut visit: impl FnMut(A::Source, Errors<'_, A::Source, R>, R::Mask),
    ) {
        self.second.preimages_near(z, errors, |y, errors, outer| {
            self.first.preimages_near(&y, errors, |x, errors, inner| {
                visit(x, errors, outer.and(inner));
            });
        });
    }

    #[inline(always)]
    fn jacobian(&self, x: &A::Source) -> R {
        let y = self.first.forward(x).0;
        self.first.jacobian(x) * self.second.jacobian(&y)
    }

    #[inline(always)]
    fn jacobian_between(&self, x: &A::Source, z: &B::Target) -> R {
        let y = self.first.forward(x).0;
        self.first.jacobian_between(x, &y) * self.second.jacobian_between(&y, z)
    }

    #[inline(always)]
    fn pushed(&self, p: R, (x, z): (&A::Source, &B::Target)) -> R {
        let y = self.first.forward(x).0;
        self.second.pushed(self.first.pushed(p, (x, &y)), (&y, z))
    }

    #[inline]
    fn log_jacobian(&self, x: &A::Source) -> R {
        let y = self.first.forward(x).0;
        self.first.log_jacobian(x) + self.second.log_jacobian(&y)
    }
}
