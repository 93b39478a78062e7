//! Measures as types, and densities with respect to them.

use core::fmt;
use core::marker::PhantomData;
use core::ops::{Add, Div, Mul};

use crate::real::{Real, Scalar};

/// A reference measure that a density is taken with respect to.
pub trait Measure: 'static {
    /// The measure's name, as documentation and error texts print it.
    const NAME: &'static str;
}

macro_rules! measures {
    ($($(#[$doc:meta])* $name:ident = $text:literal;)*) => {
        $($(#[$doc])*
        #[derive(Clone, Copy, Debug, PartialEq, Eq)]
        pub struct $name;
        impl Measure for $name { const NAME: &'static str = $text; })*
    };
}

measures! {
    /// Length on the real line (one-dimensional Lebesgue measure).
    Length = "length";
    /// Area in the plane or on a surface (two-dimensional Hausdorff measure).
    Area = "area";
    /// Solid angle of directions: area on the unit sphere, in steradians.
    SolidAngle = "solid angle";
    /// Volume in space (three-dimensional Lebesgue measure).
    Volume = "volume";
    /// Counting measure: a density with respect to it is a probability.
    Counting = "counting";
}

/// K-dimensional Hausdorff measure of a manifold in R^n, for manifolds without a name of their own.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Hausdorff<const K: usize>;
impl<const K: usize> Measure for Hausdorff<K> {
    const NAME: &'static str = "Hausdorff";
}

/// The product of two measures.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Product<A, B>(PhantomData<(A, B)>);
impl<A: Measure, B: Measure> Measure for Product<A, B> {
    const NAME: &'static str = "product";
}

/// Every measure is the same as itself, and as no other.
#[diagnostic::on_unimplemented(
    message = "a density with respect to `{M}` and one with respect to `{Self}` cannot be added",
    label = "these are densities with respect to different measures",
    note = "bring both samples into one space first: a `#[map]` from one to the other, by `sampler.then(map)`, \
            converts the density with its Jacobian"
)]
pub trait SameMeasure<M> {}
impl<M> SameMeasure<M> for M {}

/// A probability density with respect to the measure `M`: never negative, never NaN, infinite only
/// at a true pole.
///
/// The measure is part of the type, so that adding a density over solid angle to one over area does
/// not compile:
///
/// ```compile_fail
/// use aether_core::{Area, Density, SolidAngle};
/// let wrong = Density::<SolidAngle>::new(1.0) + Density::<Area>::new(1.0);
/// ```
pub struct Density<M, R = f64> {
    value: R,
    measure: PhantomData<M>,
}

impl<M, R: Real> Density<M, R> {
    /// The density of a point outside the support.
    pub const ZERO: Self = Density { value: R::ZERO, measure: PhantomData };

    /// A density from its value in one over the units of `M`.
    #[inline(always)]
    pub fn new(value: R) -> Self {
        Density { value, measure: PhantomData }
    }

    /// The value, in one over the units of `M`.
    #[inline(always)]
    pub fn value(self) -> R {
        self.value
    }

    /// The density after a map that stretches `M` to `N` by `jacobian` (units of N over units of M).
    #[inline(always)]
    pub fn stretch<N>(self, jacobian: R) -> Density<N, R> {
        Density::new(self.value / jacobian)
    }
}

impl<M, R: Copy> Clone for Density<M, R> {
    fn clone(&self) -> Self {
        *self
    }
}
impl<M, R: Copy> Copy for Density<M, R> {}
impl<M, R: PartialEq> PartialEq for Density<M, R> {
    fn eq(&self, other: &Self) -> bool {
        self.value == other.value
    }
}
impl<M, R: PartialOrd> PartialOrd for Density<M, R> {
    fn partial_cmp(&self, other: &Self) -> Option<core::cmp::Ordering> {
        self.value.partial_cmp(&other.value)
    }
}
impl<M: Measure, R: fmt::Debug> fmt::Debug for Density<M, R> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{:?} per {}", self.value, M::NAME)
    }
}
impl<M, R: Real> Default for Density<M, R> {
    fn default() -> Self {
        Self::ZERO
    }
}
impl<M, N: SameMeasure<M>, R: Real> Add<Density<N, R>> for Density<M, R> {
    type Output = Self;
    #[inline(always)]
    fn add(self, other: Density<N, R>) -> Self {
        Density::new(self.value + other.value)
    }
}
/// The density of two independent samples.
impl<M, N, R: Real> Mul<Density<N, R>> for Density<M, R> {
    type Output = Density<Product<M, N>, R>;
    #[inline(always)]
    fn mul(self, other: Density<N, R>) -> Self::Output {
        Density::new(self.value * other.value)
    }
}
/// Weighted by a probability, as in a mixture.
impl<M, R: Real> Mul<R> for Density<M, R> {
    type Output = Self;
    #[inline(always)]
    fn mul(self, probability: R) -> Self {
        Density::new(self.value * probability)
    }
}
/// How much likelier one technique is than another: a pure number.
impl<M, R: Real> Div for Density<M, R> {
    type Output = R;
    #[inline(always)]
    fn div(self, other: Self) -> R {
        self.value / other.value
    }
}
impl<M, R: Scalar> core::iter::Sum for Density<M, R> {
    fn sum<I: Iterator<Item = Self>>(items: I) -> Self {
        items.fold(Self::ZERO, |a, b| a + b)
    }
}
