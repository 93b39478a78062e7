//! Maps of one of two points that depend on the other one.
//!
//! Two points that were drawn together, (a, b), are brought to where they belong one after the other:
//! [`on_second`] maps b by a map that may depend on a, then [`on_first`] maps a by one that may depend
//! on what b has become. Each step leaves one of the points as it is, so that its Jacobian is that of
//! the map of the other point.
//!
//! ```
//! use aether_core::pairs::{on_first, on_second};
//! use aether_core::prelude::*;
//!
//! /// Two numbers on their own.
//! #[sampler]
//! fn square(u: [Uniform; 2]) -> (f64, f64) {
//!     (u[0], u[1])
//! }
//!
//! /// Stretched by 1 + s.
//! #[map]
//! fn stretch(x: f64, s: f64) -> f64 {
//!     (1.0 + s * s) * x
//! }
//!
//! // (a, b) to (a, c) with c = (1 + a²) b, and then to ((1 + c²) a, c).
//! let pair = square().then(on_second(|a: &f64| stretch(*a))).then(on_first(|c: &f64| stretch(*c)));
//! let x = pair.sample([0.5, 0.8]);
//! assert_eq!(x.value(), (1.0, 1.0));
//! assert!((pair.pdf(&x).value() - 1.0 / (1.25 * 2.0)).abs() < 1e-15);
//! ```

use core::marker::PhantomData;

use crate::map::Map;
use crate::point::Point;
use crate::real::Real;

/// Maps (p, x) to (p, m(x)), where `map` makes m of p.
pub fn on_second<P, M, F: Fn(&P) -> M + Copy>(map: F) -> OnSecond<P, F> {
    OnSecond { map, other: PhantomData }
}

/// The map that [`on_second`] returns.
pub struct OnSecond<P, F> {
    map: F,
    other: PhantomData<fn(&P)>,
}

impl<P, F: Copy> Clone for OnSecond<P, F> {
    fn clone(&self) -> Self {
        *self
    }
}
impl<P, F: Copy> Copy for OnSecond<P, F> {}

impl<R, P, M, F> Map<R> for OnSecond<P, F>
where
    R: Real,
    P: Point<R>,
    M: Map<R>,
    F: Fn(&P) -> M + Copy,
{
    type Source = (P, M::Source);
    type Target = (P, M::Target);
    const INJECTIVE: bool = M::INJECTIVE;

    #[inline(always)]
    fn forward(&self, (p, x): &Self::Source) -> (Self::Target, R::Mask) {
        let (image, exists) = (self.map)(p).forward(x);
        ((*p, image), exists)
    }

    #[inline(always)]
    fn preimages(&self, (p, x): &Self::Target, mut visit: impl FnMut(Self::Source, R::Mask)) {
        (self.map)(p).preimages(x, |x, exists| visit((*p, x), exists));
    }

    #[inline(always)]
    fn jacobian(&self, (p, x): &Self::Source) -> R {
        (self.map)(p).jacobian(x)
    }
}

/// Maps (x, p) to (m(x), p), where `map` makes m of p.
pub fn on_first<P, M, F: Fn(&P) -> M + Copy>(map: F) -> OnFirst<P, F> {
    OnFirst { map, other: PhantomData }
}

/// The map that [`on_first`] returns.
pub struct OnFirst<P, F> {
    map: F,
    other: PhantomData<fn(&P)>,
}

impl<P, F: Copy> Clone for OnFirst<P, F> {
    fn clone(&self) -> Self {
        *self
    }
}
impl<P, F: Copy> Copy for OnFirst<P, F> {}

impl<R, P, M, F> Map<R> for OnFirst<P, F>
where
    R: Real,
    P: Point<R>,
    M: Map<R>,
    F: Fn(&P) -> M + Copy,
{
    type Source = (M::Source, P);
    type Target = (M::Target, P);
    const INJECTIVE: bool = M::INJECTIVE;

    #[inline(always)]
    fn forward(&self, (x, p): &Self::Source) -> (Self::Target, R::Mask) {
        let (image, exists) = (self.map)(p).forward(x);
        ((image, *p), exists)
    }

    #[inline(always)]
    fn preimages(&self, (x, p): &Self::Target, mut visit: impl FnMut(Self::Source, R::Mask)) {
        (self.map)(p).preimages(x, |x, exists| visit((x, *p), exists));
    }

    #[inline(always)]
    fn jacobian(&self, (x, p): &Self::Source) -> R {
        (self.map)(p).jacobian(x)
    }
}
