//! The kernels of elementary functions for eight numbers.

use wide::{f64x8, u64x8};

use super::Lanes;
use crate::kernels::{
    Double, EXPONENT, LEAST, MANTISSA, ONE, POWER_SHIFT, SinglePrecision, outside,
};
use crate::real::Mask;

/// Eight numbers in double precision.
#[derive(Clone, Copy)]
pub(crate) struct Eight(f64x8);

/// What comparing them returns.
#[derive(Clone, Copy, Debug)]
pub(crate) struct EightMask(f64x8);

impl Mask for EightMask {
    const TRUE: Self = EightMask(f64x8::splat(f64::from_bits(u64::MAX)));
    const FALSE: Self = EightMask(f64x8::splat(0.0));
    #[inline(always)]
    fn and(self, other: Self) -> Self {
        EightMask(self.0 & other.0)
    }
    #[inline(always)]
    fn or(self, other: Self) -> Self {
        EightMask(self.0 | other.0)
    }
    #[inline(always)]
    fn not(self) -> Self {
        EightMask(!self.0)
    }
    #[inline(always)]
    fn any(self) -> bool {
        self.0.any()
    }
    #[inline(always)]
    fn lane(self, i: usize) -> bool {
        self.0.to_bitmask() >> i & 1 == 1
    }
    #[inline(always)]
    fn with_lane(self, i: usize, value: bool) -> Self {
        let mut patterns = self.0.to_array();
        patterns[i] = f64::from_bits(if value { u64::MAX } else { 0 });
        EightMask(f64x8::new(patterns))
    }
}

macro_rules! operators {
    ($($trait:ident $name:ident $op:tt;)*) => {
        $(impl core::ops::$trait for Eight {
            type Output = Self;
            #[inline(always)]
            fn $name(self, other: Self) -> Self { Eight(self.0 $op other.0) }
        })*
    };
}
operators! { Add add +; Sub sub -; Mul mul *; Div div /; }

impl core::ops::Neg for Eight {
    type Output = Self;
    #[inline(always)]
    fn neg(self) -> Self {
        Eight(-self.0)
    }
}

impl Double for Eight {
    type Mask = EightMask;
    #[inline(always)]
    fn of(x: f64) -> Self {
        Eight(f64x8::splat(x))
    }
    #[inline(always)]
    fn lt(self, other: Self) -> EightMask {
        EightMask(self.0.simd_lt(other.0))
    }
    #[inline(always)]
    fn le(self, other: Self) -> EightMask {
        EightMask(self.0.simd_le(other.0))
    }
    #[inline(always)]
    fn select(mask: EightMask, yes: Self, no: Self) -> Self {
        Eight(mask.0.select(yes.0, no.0))
    }
    #[inline(always)]
    fn abs(self) -> Self {
        Eight(self.0.abs())
    }
    #[inline(always)]
    fn sqrt(self) -> Self {
        Eight(self.0.sqrt())
    }
    #[inline(always)]
    fn copysign(self, sign: Self) -> Self {
        Eight(self.0.copysign(sign.0))
    }
    #[inline(always)]
    fn power_of_two(self) -> Self {
        Eight(f64x8::from_bits((self.0 + f64x8::splat(POWER_SHIFT)).to_bits() << 52))
    }
    #[inline(always)]
    fn mantissa_exponent(self) -> (Self, Self) {
        let bits = self.0.to_bits() + u64x8::splat(ONE - LEAST);
        let mantissa = f64x8::from_bits((bits & u64x8::splat(MANTISSA)) + u64x8::splat(LEAST));
        let exponent = f64x8::from_bits((bits >> 52) | u64x8::splat(EXPONENT));
        (Eight(mantissa), Eight(exponent - f64x8::splat(POWER_SHIFT)))
    }
    #[inline(always)]
    fn replace(self, mask: EightMask, x: Self, f: fn(f64) -> f64) -> Self {
        if mask.any() { each(self, mask, x, f) } else { self }
    }
    #[inline(always)]
    fn turned(quarters: Self, sin: Self, cos: Self) -> (Self, Self) {
        let (n, sin, cos) = (quarters.0.to_bits(), sin.0.to_bits(), cos.0.to_bits());
        let [zero, one, two] = [0, 1, 2].map(u64x8::splat);
        let exchanged = (sin ^ cos) & (zero - (n & one));
        let sin = sin ^ exchanged ^ ((n & two) << 62);
        let cos = cos ^ exchanged ^ (((n + one) & two) << 62);
        (Eight(f64x8::from_bits(sin)), Eight(f64x8::from_bits(cos)))
    }
}

/// [`outside`] where the mask is true.
#[cold]
fn each(kept: Eight, mask: EightMask, x: Eight, f: fn(f64) -> f64) -> Eight {
    let (kept, x) = (kept.0.to_array(), x.0.to_array());
    let number = |i: usize| if mask.lane(i) { outside(x[i], f) } else { kept[i] };
    Eight(f64x8::new(core::array::from_fn(number)))
}

impl SinglePrecision for Lanes {
    type Wide = Eight;
    #[inline(always)]
    fn widen(self) -> Eight {
        Eight(f64x8::new(self.to_array().map(f64::from)))
    }
    #[inline(always)]
    fn narrow(wide: Eight) -> Lanes {
        Lanes::new(wide.0.to_array().map(|x| x as f32))
    }
}
