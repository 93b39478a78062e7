//! One number with the functions of lanes.

use core::ops::{Add, AddAssign, Div, DivAssign, Mul, MulAssign, Neg, Sub, SubAssign};

use crate::kernels::SinglePrecision;
use crate::real::Real;

/// A number in single precision with the elementary functions of [`Lanes`](super::Lanes): what a lane has, to the bit,
/// without the seven others.
///
/// It is `f32` as the feature `portable` makes it, but a type of its own, so that both can be had in one program. Samplers
/// and maps take it; what is for scalars (tables, choices, strategies) does not. What is rare is decided by `f32`, as it is for
/// each of several lanes.
///
/// ```
/// use aether_core::lanes::{Lanes, Portable};
/// use aether_core::prelude::*;
///
/// /// Free flight through a homogeneous medium.
/// #[sampler]
/// fn free_flight(u: [Uniform; 1], extinction: f64) -> f64 {
///     -(-u[0]).ln_1p() / extinction
/// }
///
/// let one = free_flight(Portable(0.3)).sample([Portable(0.7)]).value();
/// let eight = free_flight(Lanes::splat(0.3)).sample([Lanes::splat(0.7)]).value();
/// assert_eq!(eight.to_array()[5].to_bits(), one.0.to_bits());
/// ```
#[derive(Clone, Copy, Debug, Default, PartialEq, PartialOrd)]
pub struct Portable(pub f32);

impl SinglePrecision for Portable {
    type Wide = f64;
    #[inline(always)]
    fn widen(self) -> f64 {
        f64::from(self.0)
    }
    #[inline(always)]
    fn narrow(wide: f64) -> Portable {
        Portable(wide as f32)
    }
}

operators! { Portable }

impl Real for Portable {
    type Mask = bool;
    type Lane = f32;
    const LANES: usize = 1;
    const ZERO: Self = Portable(0.0);
    const ONE: Self = Portable(1.0);
    const EPSILON: Self = Portable(f32::EPSILON);
    const INFINITY: Self = Portable(f32::INFINITY);
    const MIN_POSITIVE: Self = Portable(f32::MIN_POSITIVE);

    #[inline(always)]
    fn lane(self, _: usize) -> f32 {
        self.0
    }
    #[inline(always)]
    fn with_lane(self, _: usize, value: f32) -> Self {
        Portable(value)
    }
    #[inline(always)]
    fn of(x: f64) -> Self {
        Portable(x as f32)
    }
    #[inline(always)]
    fn to_f64(self) -> f64 {
        f64::from(self.0)
    }
    #[inline(always)]
    fn lt(self, other: Self) -> bool {
        self.0 < other.0
    }
    #[inline(always)]
    fn le(self, other: Self) -> bool {
        self.0 <= other.0
    }
    #[inline(always)]
    fn select(mask: bool, yes: Self, no: Self) -> Self {
        if mask { yes } else { no }
    }
    #[inline(always)]
    fn finite(self) -> bool {
        self.0.is_finite()
    }
    #[inline(always)]
    fn abs(self) -> Self {
        Portable(self.0.abs())
    }
    #[inline(always)]
    fn min(self, other: Self) -> Self {
        Portable(self.0.min(other.0))
    }
    #[inline(always)]
    fn max(self, other: Self) -> Self {
        Portable(self.0.max(other.0))
    }
    #[inline(always)]
    fn floor(self) -> Self {
        Portable(self.0.floor())
    }
    #[inline(always)]
    fn copysign(self, sign: Self) -> Self {
        Portable(self.0.copysign(sign.0))
    }
    #[inline(always)]
    fn sqrt(self) -> Self {
        Portable(self.0.sqrt())
    }
    crate::kernels::single_precision! { Portable }
}
