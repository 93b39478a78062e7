//! Random variables: what `#[sampler]` derives from a function of uniforms.

use core::fmt;
use core::ops::Deref;

use crate::density::Density;
use crate::map::Map;
use crate::mixed::Followed;
use crate::point::Point;
use crate::preimages::Preimages;
use crate::real::Real;
use crate::support::log_density;

/// A uniform random number in [0, 1) as the body of a sampler sees it.
pub type Uniform = f64;

/// An array of uniforms, `[R; N]`.
pub trait Uniforms<R>: Copy + fmt::Debug + AsRef<[R]> {
    /// How many.
    const COUNT: usize;
    /// An array from its elements.
    fn from_fn(element: impl FnMut(usize) -> R) -> Self;
}

impl<R: Real, const N: usize> Uniforms<R> for [R; N] {
    const COUNT: usize = N;
    #[inline(always)]
    fn from_fn(mut element: impl FnMut(usize) -> R) -> Self {
        // The standard library's own ways are not always inlined.
        let (mut all, mut k) = ([R::ZERO; N], 0);
        while k < N {
            all[k] = element(k);
            k += 1;
        }
        all
    }
}

/// What the compiler derived for a sampler or a map, as text.
#[derive(Clone, Copy, Debug)]
pub struct Derivation {
    /// Name of the function that was written.
    pub name: &'static str,
    /// The map as written, with intermediate names resolved.
    pub forward: &'static str,
    /// The derived inverse, one line an unknown and preimage.
    pub inverse: &'static str,
    /// The derived Jacobian factor √det(JᵀJ).
    pub jacobian: &'static str,
    /// The derived density.
    pub pdf: &'static str,
    /// Name of the reference measure.
    pub measure: &'static str,
    /// How many preimages a point has at most.
    pub preimages: usize,
    /// Worst relative error of the density in `f64` over the points inside of the domain that were tried while compiling, where
    /// that is not what rounding the point and the parameters does; infinite if it was no number.
    pub worst_error: f64,
}

/// The density of a sampler's points.
pub type PdfOf<S, R> = Density<<<S as Sampler<R>>::Point as Point<R>>::Measure, R>;

/// Bounds for the errors of a point's coordinates, which are computed where somebody asks.
pub type Errors<'a, P, R> = &'a dyn Fn() -> <P as Point<R>>::Coordinates;

/// A continuous random variable: a map from uniforms to points of a space, with its inverse and
/// density derived by the compiler. Made by `#[sampler]`, or from others by [`Sampler::then`].
///
/// ```
/// use aether_core::prelude::*;
///
/// /// Directions about +z, distributed as cos(theta) / pi.
/// #[sampler]
/// fn cosine_hemisphere(u: [Uniform; 2]) -> Direction {
///     let r = u[0].sqrt();
///     let phi = TAU * u[1];
///     Direction::new(r * phi.cos(), r * phi.sin(), (1.0 - u[0]).sqrt())
/// }
///
/// let w = cosine_hemisphere().sample([0.3, 0.7]);
/// let p = cosine_hemisphere().pdf(&w).value();
/// assert!((p - w.z / PI).abs() < 1e-15);
/// ```
pub trait Sampler<R: Real>: Copy {
    /// The uniforms that a sample consumes, `[R; N]`.
    type Uniforms: Uniforms<R>;
    /// The space of the samples.
    type Point: Point<R>;

    /// The map from uniforms in [0, 1) to a point, and whether there is one (a defective map has no
    /// sample for some uniforms; its density then integrates to less than one).
    fn forward(&self, u: Self::Uniforms) -> (Self::Point, R::Mask);

    /// The density at any point of the space: the sum over all preimages u of x of
    /// 1 / √det(J(u)ᵀJ(u)), zero outside the support and for NaN or infinite coordinates (Aether
    /// 2017, Eq. 5, with the authors' erratum).
    fn pdf(&self, x: &Self::Point) -> PdfOf<Self, R>;

    /// The density at exactly this point. [`Sampler::pdf`] of a composition takes one that lies outside of the
    /// support by no more than the rounding of its maps as inside. Where several random variables may have made a
    /// point, as in a mixture, that would count one on a border between them for each of them: who adds up
    /// densities asks this, and, if they are all zero, `pdf`.
    #[inline(always)]
    fn pdf_as_is(&self, x: &Self::Point) -> PdfOf<Self, R> {
        self.pdf(x)
    }

    /// [`Sampler::pdf_as_is`] of a point whose coordinates are known to be finite, as those of a preimage are: what depends on
    /// some of them does not ask for the others.
    #[inline(always)]
    fn pdf_of_finite(&self, x: &Self::Point) -> PdfOf<Self, R> {
        self.pdf_as_is(x)
    }

    /// The density at a point whose coordinates are known to within `errors`: one that lies outside of the support by
    /// no more than that counts as inside. A map that comes after a sampler asks this about points that it has
    /// computed. A sampler without an answer of its own takes the point as it is.
    #[inline]
    fn pdf_near(&self, x: &Self::Point, errors: Errors<'_, Self::Point, R>) -> PdfOf<Self, R> {
        let _ = errors;
        self.pdf(x)
    }

    /// The density of the sample that `u` maps to. Needs no inversion if the map is injective.
    fn pdf_of_uniforms(&self, u: Self::Uniforms) -> PdfOf<Self, R>;

    /// [`Sampler::forward`] together with [`Sampler::pdf_of_uniforms`], which share what they can. The density
    /// says nothing where there is no point.
    #[inline(always)]
    fn forward_with_pdf(&self, u: Self::Uniforms) -> (Self::Point, R::Mask, PdfOf<Self, R>) {
        let (point, valid) = self.forward(u);
        (point, valid, self.pdf_of_uniforms(u))
    }

    /// Calls `visit` with every preimage of `x` (where the mask holds).
    fn preimages(&self, x: &Self::Point, visit: impl FnMut(Self::Uniforms, R::Mask));

    /// The natural logarithm of [`Sampler::pdf`]; minus infinity outside the support.
    ///
    /// It is finite where the density itself is too small or too large for the number type: for
    /// samplers whose density has exponentials or powers with a variable exponent, the compiler derives
    /// the logarithm as well, a sum over their factors, and it is computed where `pdf` has left the range
    /// of normal numbers. All others are left to `ln`.
    ///
    /// ```
    /// use aether_core::prelude::*;
    ///
    /// /// A normal variable in polar coordinates.
    /// #[sampler]
    /// fn normal(u: [Uniform; 2]) -> Vec2 {
    ///     let r = (-2.0 * (-u[0]).ln_1p()).sqrt();
    ///     Vec2::new(r * (TAU * u[1]).cos(), r * (TAU * u[1]).sin())
    /// }
    ///
    /// let far = Vec2::new(60.0, 80.0);
    /// assert_eq!(normal().pdf(&far).value(), 0.0);
    /// assert!((normal().log_pdf(&far) + 5000.0 + TAU.ln()).abs() < 1e-11);
    /// ```
    #[inline]
    fn log_pdf(&self, x: &Self::Point) -> R {
        self.pdf(x).value().ln()
    }

    /// Draws the sample of the uniforms `u`.
    #[inline(always)]
    fn sample(&self, u: Self::Uniforms) -> Sample<Self, R> {
        let (value, valid) = self.forward(u);
        Sample { sampler: *self, uniforms: u, value, valid }
    }

    /// The uniforms that map to `x`: every preimage, none outside the support. Where there are several
    /// lanes, [`Sampler::preimages`] tells in which of them each preimage exists.
    fn invert(&self, x: &Self::Point) -> Preimages<Self::Uniforms>
    where
        R: Real<Mask = bool>,
    {
        let mut found = Preimages::new();
        self.preimages(x, |u, valid| {
            if valid {
                found.push(u);
            }
        });
        found
    }

    /// The random variable `map(self)`: a [`Then`](crate::Then). The map takes the points of this sampler, or, if this one
    /// has atoms, points of the space in which they lie: a [`mixed::Then`](crate::mixed::Then).
    #[inline(always)]
    fn then<M: Map<R>>(
        self,
        map: M,
    ) -> <Self as Followed<R, <Self as Sampler<R>>::Point, M::Source>>::Then<M>
    where
        Self: Followed<R, <Self as Sampler<R>>::Point, M::Source>,
    {
        self.followed_by(map)
    }
}

/// A sample: the value, and how it came about. Dereferences to the value.
#[derive(Clone, Copy, Debug)]
pub struct Sample<S: Sampler<R>, R: Real> {
    sampler: S,
    uniforms: S::Uniforms,
    value: S::Point,
    valid: R::Mask,
}

impl<S: Sampler<R>, R: Real> Sample<S, R> {
    /// The sampled point.
    #[inline(always)]
    pub fn value(&self) -> S::Point {
        self.value
    }

    /// The random variable that it was drawn from.
    #[inline(always)]
    pub fn sampler(&self) -> &S {
        &self.sampler
    }

    /// The uniforms that it was drawn with.
    #[inline(always)]
    pub fn uniforms(&self) -> S::Uniforms {
        self.uniforms
    }

    /// Whether there is a sample: a defective map has none for some uniforms.
    #[inline(always)]
    pub fn is_valid(&self) -> R::Mask {
        self.valid
    }

    /// The density of this sample under its own random variable; zero if there is no sample.
    #[inline(always)]
    pub fn pdf(&self) -> PdfOf<S, R> {
        let p = self.sampler.pdf_of_uniforms(self.uniforms).value();
        Density::new(R::select(self.valid, p, R::ZERO))
    }

    /// The natural logarithm of the density of this sample, finite also where [`Sample::pdf`] is too
    /// small or too large for the number type; minus infinity if there is no sample.
    #[inline]
    pub fn log_pdf(&self) -> R {
        log_density(self.pdf().value(), || {
            R::select(self.valid, self.sampler.log_pdf(&self.value), -R::INFINITY)
        })
    }
}

impl<S: Sampler<R>, R: Real> Deref for Sample<S, R> {
    type Target = S::Point;
    #[inline(always)]
    fn deref(&self) -> &S::Point {
        &self.value
    }
}

/// A parameter outside its declared domain.
#[derive(Clone, Debug, PartialEq)]
pub struct DomainError {
    /// The sampler or map.
    pub item: &'static str,
    /// The parameter or relation that failed, as declared.
    pub requirement: &'static str,
    /// The offending value.
    pub value: f64,
}

impl fmt::Display for DomainError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let DomainError { item, requirement, value } = self;
        write!(f, "{item}: parameter value {value} violates the declared domain `{requirement}`")
    }
}

impl std::error::Error for DomainError {}
