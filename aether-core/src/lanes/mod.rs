//! Eight samples at once: the number type [`Lanes`] (feature `wide`).
//!
//! What `#[sampler]` and `#[map]` emit is generic over [`Real`], so every random variable and map runs
//! on lanes as it stands: eight uniforms in, eight samples out, each with its density.
//!
//! ```
//! use aether_core::prelude::*;
//! use aether_core::Lanes;
//!
//! /// Directions about +z, distributed as cos(theta) / pi.
//! #[sampler]
//! fn cosine_hemisphere(u: [Uniform; 2]) -> Direction {
//!     let r = u[0].sqrt();
//!     let phi = TAU * u[1];
//!     Direction::new(r * phi.cos(), r * phi.sin(), (1.0 - u[0]).sqrt())
//! }
//!
//! let u = [Lanes::new([0.0, 0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7]), Lanes::splat(0.25)];
//! let w = cosine_hemisphere().sample(u);
//! let p = cosine_hemisphere().pdf(&w).value();
//! for i in 0..8 {
//!     let alone = cosine_hemisphere().sample([u[0].to_array()[i], 0.25f32]);
//!     assert_eq!(w.z.to_array()[i], alone.z);
//!     assert_eq!(p.to_array()[i], cosine_hemisphere().pdf(&alone).value());
//! }
//! ```
//!
//! # One lane is one scalar
//!
//! A lane has what `f32` has on the same input, for points outside the support, on its border and for NaN
//! as well. Arithmetic, square roots and choices have the same bits, because nothing is fused. Elementary
//! functions are kernels of this crate, evaluated in double precision and rounded once: within 0.51 ulp
//! of the exact value for every argument, `powf` and `atan2` included. (The arguments of sines are
//! reduced exactly, however large.) `f32` has the functions of the host, so results may differ by their
//! errors; with the feature `portable`, `f32` has these kernels too, and all results have the same bits.
//! [`Portable`] is one number that has them without the feature.
//! The functions of [`special`](crate::special) and numerical roots are one algorithm over any number.
//!
//! What happens rarely (a point that only
//! rounding has put outside, a membership that needs error bounds) is decided for each lane alone, by the
//! code that decides it for a scalar; where no lane needs it, nothing of it runs.
//!
//! A lane that does not take a branch still computes it. Its result, NaN perhaps, is dropped by
//! [`Real::select`], which chooses bits; nothing multiplies by zero.
//!
//! What there is of a sample, and of each of its preimages, is told by a [`LaneMask`]
//! ([`Sample::is_valid`](crate::Sample::is_valid), [`Sampler::preimages`](crate::Sampler::preimages)).
//! Tables, mixtures and strategies choose by what they drew, so they are for scalars only.
//!
//! # Uniforms
//!
//! An array of eight sources is a source of lanes: lane i gets what source i yields.
//!
//! ```
//! use aether_core::{Lanes, Sobol, draw_uniforms};
//!
//! let mut sources: [Sobol; 8] = core::array::from_fn(|i| Sobol::new(7, 0, i as u32));
//! let u: [Lanes; 2] = draw_uniforms(&mut sources);
//! let mut fourth = Sobol::new(7, 0, 3);
//! let alone: [f32; 2] = draw_uniforms(&mut fourth);
//! assert_eq!(u.map(|u| u.to_array()[3]), alone);
//! ```

/// The operators of a number type that wraps another one.
macro_rules! operators {
    ($type:ident) => {
        operators! {
            $type:
            Add add AddAssign add_assign +;
            Sub sub SubAssign sub_assign -;
            Mul mul MulAssign mul_assign *;
            Div div DivAssign div_assign /;
        }
    };
    ($type:ident: $($trait:ident $name:ident $assign:ident $assign_name:ident $op:tt;)*) => {
        impl Neg for $type {
            type Output = Self;
            #[inline(always)]
            fn neg(self) -> Self {
                $type(-self.0)
            }
        }
        $(impl $trait for $type {
            type Output = Self;
            #[inline(always)]
            fn $name(self, other: Self) -> Self { $type(self.0 $op other.0) }
        }
        impl $assign for $type {
            #[inline(always)]
            fn $assign_name(&mut self, other: Self) { *self = *self $op other; }
        })*
    };
}

mod double;
mod portable;
#[cfg(test)]
mod tests;

pub use portable::Portable;

use core::fmt;
use core::ops::{Add, AddAssign, Div, DivAssign, Mul, MulAssign, Neg, Sub, SubAssign};

use wide::f32x8;

use crate::real::{Mask, Real};
use crate::uniform::UniformSource;

/// Eight numbers in single precision.
#[derive(Clone, Copy, Default)]
pub struct Lanes(f32x8);

impl Lanes {
    /// A number for each lane.
    #[inline(always)]
    pub const fn new(numbers: [f32; 8]) -> Self {
        Lanes(f32x8::new(numbers))
    }

    /// The same number in each lane.
    #[inline(always)]
    pub const fn splat(number: f32) -> Self {
        Lanes(f32x8::splat(number))
    }

    /// The number of each lane.
    #[inline(always)]
    pub const fn to_array(self) -> [f32; 8] {
        self.0.to_array()
    }
}

impl From<[f32; 8]> for Lanes {
    #[inline(always)]
    fn from(numbers: [f32; 8]) -> Self {
        Lanes::new(numbers)
    }
}

impl From<Lanes> for [f32; 8] {
    #[inline(always)]
    fn from(lanes: Lanes) -> Self {
        lanes.to_array()
    }
}

impl From<f32x8> for Lanes {
    #[inline(always)]
    fn from(numbers: f32x8) -> Self {
        Lanes(numbers)
    }
}

impl From<Lanes> for f32x8 {
    #[inline(always)]
    fn from(lanes: Lanes) -> Self {
        lanes.0
    }
}

impl fmt::Debug for Lanes {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.to_array().fmt(f)
    }
}

/// Equal in all lanes.
impl PartialEq for Lanes {
    fn eq(&self, other: &Self) -> bool {
        self.to_array() == other.to_array()
    }
}

/// Eight truth values: what comparisons of [`Lanes`] return.
#[derive(Clone, Copy)]
pub struct LaneMask(f32x8);

impl LaneMask {
    /// The truth value of each lane.
    #[inline(always)]
    pub fn to_array(self) -> [bool; 8] {
        let bits = self.0.to_bitmask();
        core::array::from_fn(|i| bits >> i & 1 == 1)
    }
}

impl From<[bool; 8]> for LaneMask {
    #[inline(always)]
    fn from(values: [bool; 8]) -> Self {
        LaneMask(f32x8::new(values.map(pattern)))
    }
}

impl fmt::Debug for LaneMask {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.to_array().fmt(f)
    }
}

impl PartialEq for LaneMask {
    fn eq(&self, other: &Self) -> bool {
        self.to_array() == other.to_array()
    }
}

/// All bits set, or none.
#[inline(always)]
const fn pattern(value: bool) -> f32 {
    f32::from_bits(if value { u32::MAX } else { 0 })
}

impl Mask for LaneMask {
    const TRUE: Self = LaneMask(f32x8::splat(pattern(true)));
    const FALSE: Self = LaneMask(f32x8::splat(pattern(false)));
    #[inline(always)]
    fn and(self, other: Self) -> Self {
        LaneMask(self.0 & other.0)
    }
    #[inline(always)]
    fn or(self, other: Self) -> Self {
        LaneMask(self.0 | other.0)
    }
    #[inline(always)]
    fn not(self) -> Self {
        LaneMask(!self.0)
    }
    #[inline(always)]
    fn any(self) -> bool {
        self.0.any()
    }
    #[inline(always)]
    fn all(self) -> bool {
        self.0.all()
    }
    #[inline(always)]
    fn lane(self, i: usize) -> bool {
        self.to_array()[i]
    }
    #[inline(always)]
    fn with_lane(self, i: usize, value: bool) -> Self {
        let mut patterns = self.0.to_array();
        patterns[i] = pattern(value);
        LaneMask(f32x8::new(patterns))
    }
}

operators! { Lanes }

impl Real for Lanes {
    type Mask = LaneMask;
    type Lane = f32;
    const LANES: usize = 8;
    const ZERO: Self = Lanes::splat(0.0);
    const ONE: Self = Lanes::splat(1.0);
    const EPSILON: Self = Lanes::splat(f32::EPSILON);
    const INFINITY: Self = Lanes::splat(f32::INFINITY);
    const MIN_POSITIVE: Self = Lanes::splat(f32::MIN_POSITIVE);

    #[inline(always)]
    fn lane(self, i: usize) -> f32 {
        self.to_array()[i]
    }
    #[inline(always)]
    fn with_lane(self, i: usize, value: f32) -> Self {
        let mut numbers = self.to_array();
        numbers[i] = value;
        Lanes::new(numbers)
    }
    #[inline(always)]
    fn of(x: f64) -> Self {
        Lanes::splat(x as f32)
    }
    #[inline(always)]
    fn to_f64(self) -> f64 {
        f64::from(self.lane(0))
    }
    #[inline(always)]
    fn lt(self, other: Self) -> LaneMask {
        LaneMask(self.0.simd_lt(other.0))
    }
    #[inline(always)]
    fn le(self, other: Self) -> LaneMask {
        LaneMask(self.0.simd_le(other.0))
    }
    #[inline(always)]
    fn select(mask: LaneMask, yes: Self, no: Self) -> Self {
        Lanes(mask.0.select(yes.0, no.0))
    }
    #[inline(always)]
    fn finite(self) -> LaneMask {
        self.abs().lt(Self::INFINITY)
    }
    #[inline(always)]
    fn abs(self) -> Self {
        Lanes(self.0.abs())
    }
    #[inline(always)]
    fn min(self, other: Self) -> Self {
        Lanes(self.0.min(other.0))
    }
    #[inline(always)]
    fn max(self, other: Self) -> Self {
        Lanes(self.0.max(other.0))
    }
    #[inline(always)]
    fn floor(self) -> Self {
        Lanes(self.0.floor())
    }
    #[inline(always)]
    fn copysign(self, sign: Self) -> Self {
        Lanes(self.0.copysign(sign.0))
    }
    #[inline(always)]
    fn sqrt(self) -> Self {
        Lanes(self.0.sqrt())
    }
    crate::kernels::single_precision! { Lanes }
}

/// A source for each lane.
impl<S: UniformSource<f32>> UniformSource<Lanes> for [S; 8] {
    fn next(&mut self) -> Lanes {
        Lanes::new(self.each_mut().map(UniformSource::next))
    }
    fn choice(&mut self) -> Lanes {
        Lanes::new(self.each_mut().map(UniformSource::choice))
    }
    fn start(&mut self, block: u32) {
        self.iter_mut().for_each(|source| source.start(block));
    }
    fn piece(&mut self, number: u32) {
        self.iter_mut().for_each(|source| source.piece(number));
    }
}
