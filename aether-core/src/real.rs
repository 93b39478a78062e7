//! The scalar that emitted code is generic over.

use crate::bounded::Bounded;
use core::fmt::Debug;
use core::ops::{Add, AddAssign, Div, DivAssign, Mul, MulAssign, Neg, Sub, SubAssign};

/// The result of comparing two [`Real`]s: `bool` for scalars, one truth value a lane for lanes.
pub trait Mask: Copy + Debug {
    /// All lanes true.
    const TRUE: Self;
    /// All lanes false.
    const FALSE: Self;
    /// Lane-wise conjunction.
    fn and(self, other: Self) -> Self;
    /// Lane-wise disjunction.
    fn or(self, other: Self) -> Self;
    /// Lane-wise negation.
    fn not(self) -> Self;
    /// Whether any lane is true.
    fn any(self) -> bool;
    /// Whether every lane is true.
    #[inline(always)]
    fn all(self) -> bool {
        !self.not().any()
    }
    /// The truth value of lane `i`.
    fn lane(self, i: usize) -> bool;
    /// The mask with another truth value in lane `i`.
    fn with_lane(self, i: usize, value: bool) -> Self;
}

impl Mask for bool {
    const TRUE: bool = true;
    const FALSE: bool = false;
    #[inline(always)]
    fn and(self, other: bool) -> bool {
        self & other
    }
    #[inline(always)]
    fn or(self, other: bool) -> bool {
        self | other
    }
    #[inline(always)]
    fn not(self) -> bool {
        !self
    }
    #[inline(always)]
    fn any(self) -> bool {
        self
    }
    #[inline(always)]
    fn lane(self, _: usize) -> bool {
        self
    }
    #[inline(always)]
    fn with_lane(self, _: usize, value: bool) -> bool {
        value
    }
}

/// A real number as the language sees it.
///
/// Implemented by `f32`, `f64`, [`Bounded`] (a value with a running error bound) and, with the feature
/// `wide`, by `Lanes` (eight `f32`). Comparisons return a [`Mask`] and branches are [`Real::select`],
/// so that the same emitted code runs on all of them.
pub trait Real:
    Copy
    + Debug
    + Default
    + PartialEq
    + Send
    + Sync
    + 'static
    + Neg<Output = Self>
    + Add<Output = Self>
    + Sub<Output = Self>
    + Mul<Output = Self>
    + Div<Output = Self>
    + AddAssign
    + SubAssign
    + MulAssign
    + DivAssign
{
    /// What comparisons return.
    type Mask: Mask;
    /// The number in one lane; a single number is its own and only lane.
    type Lane: Single;
    /// How many lanes there are.
    const LANES: usize;
    /// Zero.
    const ZERO: Self;
    /// One.
    const ONE: Self;
    /// Distance from one to the next larger number (2^-52 for `f64`, 2^-23 for `f32`).
    const EPSILON: Self;
    /// Positive infinity.
    const INFINITY: Self;
    /// The smallest positive number that is represented to full precision.
    const MIN_POSITIVE: Self;

    /// The number in lane `i`, which is less than [`Real::LANES`].
    fn lane(self, i: usize) -> Self::Lane;
    /// This, with another number in lane `i`.
    fn with_lane(self, i: usize, value: Self::Lane) -> Self;
    /// From the number of each lane.
    #[inline(always)]
    fn from_lanes(mut number: impl FnMut(usize) -> Self::Lane) -> Self {
        (0..Self::LANES).fold(Self::ZERO, |all, i| all.with_lane(i, number(i)))
    }
    /// The value without what is known of its error.
    #[inline(always)]
    fn exact(self) -> Self {
        self
    }
    /// The number nearest to `x`.
    fn of(x: f64) -> Self;
    /// The value as `f64`; that of the first lane, if there are several.
    fn to_f64(self) -> f64;
    /// `self < other`; false for NaN, like all comparisons here.
    fn lt(self, other: Self) -> Self::Mask;
    /// `self <= other`.
    fn le(self, other: Self) -> Self::Mask;
    /// `self > other`.
    #[inline(always)]
    fn gt(self, other: Self) -> Self::Mask {
        other.lt(self)
    }
    /// `self >= other`.
    #[inline(always)]
    fn ge(self, other: Self) -> Self::Mask {
        other.le(self)
    }
    /// `yes` where `mask` is true, `no` elsewhere.
    fn select(mask: Self::Mask, yes: Self, no: Self) -> Self;
    /// Neither NaN nor infinite.
    fn finite(self) -> Self::Mask;

    /// Absolute value.
    fn abs(self) -> Self;
    /// The smaller of two numbers; the other one if one is NaN.
    fn min(self, other: Self) -> Self;
    /// The larger of two numbers; the other one if one is NaN.
    fn max(self, other: Self) -> Self;
    /// Largest integer not above `self`.
    fn floor(self) -> Self;
    /// Magnitude of `self` with the sign of `sign`.
    fn copysign(self, sign: Self) -> Self;
    /// Square root.
    fn sqrt(self) -> Self;
    /// Cube root.
    fn cbrt(self) -> Self;
    /// e^self.
    fn exp(self) -> Self;
    /// e^self - 1, accurate near zero.
    fn exp_m1(self) -> Self;
    /// Natural logarithm.
    fn ln(self) -> Self;
    /// ln(1 + self), accurate near zero.
    fn ln_1p(self) -> Self;
    /// self^exponent.
    fn powf(self, exponent: Self) -> Self;
    /// self^exponent for an integer known when the code was emitted.
    fn powi(self, exponent: i32) -> Self;
    /// Sine of an angle in radians.
    fn sin(self) -> Self;
    /// Cosine of an angle in radians.
    fn cos(self) -> Self;
    /// Tangent of an angle in radians.
    fn tan(self) -> Self;
    /// sin(π self) and cos(π self), accurate next to their zeros: 2 is a turn, and subtracted without rounding.
    fn sin_cos_pi(self) -> (Self, Self);
    /// sin(π self), accurate next to its zeros.
    #[inline(always)]
    fn sin_pi(self) -> Self {
        self.sin_cos_pi().0
    }
    /// cos(π self), accurate next to its zeros.
    #[inline(always)]
    fn cos_pi(self) -> Self {
        self.sin_cos_pi().1
    }
    /// Inverse sine, in [-π/2, π/2].
    fn asin(self) -> Self;
    /// Inverse cosine, in [0, π].
    fn acos(self) -> Self;
    /// Inverse tangent, in [-π/2, π/2].
    fn atan(self) -> Self;
    /// Angle of the point (x, self) from the x axis, in [-π, π].
    fn atan2(self, x: Self) -> Self;
    /// Hyperbolic sine.
    fn sinh(self) -> Self;
    /// Hyperbolic cosine.
    fn cosh(self) -> Self;
    /// Hyperbolic tangent.
    fn tanh(self) -> Self;
    /// Inverse hyperbolic sine.
    fn asinh(self) -> Self;
    /// Inverse hyperbolic cosine.
    fn acosh(self) -> Self;
    /// Inverse hyperbolic tangent.
    fn atanh(self) -> Self;
    /// √(self² + other²) without overflow.
    fn hypot(self, other: Self) -> Self;
    /// A function of [`crate::special`] at `x`.
    #[doc(hidden)]
    #[inline(always)]
    fn special<F: crate::special::Function>(parameters: &[Self], x: Self) -> Self {
        F::value(parameters, x)
    }
    /// 1 / self.
    #[inline(always)]
    fn recip(self) -> Self {
        Self::ONE / self
    }
}

/// A [`Real`] of one lane, whose rounding errors can be followed.
pub trait Single: Real<Mask = bool, Lane = Self> {
    /// This number with a bound on its error, for the rare points where rounding decides.
    type Tracked: Real<Mask = bool>;
    /// The number with an error bound of one rounding.
    fn track(self) -> Self::Tracked;
    /// The number with this error bound.
    fn track_within(self, error: Self) -> Self::Tracked;
    /// Value and error bound of a tracked number.
    fn value_and_error(tracked: Self::Tracked) -> (Self, Self);
}

/// A [`Single`] number that can be compared with `<` and used in plain Rust code.
pub trait Scalar: Single + PartialOrd + core::iter::Sum {
    /// The largest number below this one.
    fn next_below(self) -> Self;
}
impl Scalar for f32 {
    #[inline(always)]
    fn next_below(self) -> f32 {
        self.next_down()
    }
}
impl Scalar for f64 {
    #[inline(always)]
    fn next_below(self) -> f64 {
        self.next_down()
    }
}

macro_rules! forward {
    ($t:ident: $($name:ident($($arg:ident),*));* $(;)?) => {
        $(#[inline(always)]
        fn $name(self $(, $arg: $t)*) -> $t { <$t>::$name(self $(, $arg)*) })*
    };
}

macro_rules! impl_real {
    ($t:ident; $($functions:tt)*) => {
        impl Single for $t {
            type Tracked = Bounded<$t>;
            #[inline(always)]
            fn track(self) -> Bounded<$t> {
                Bounded::rounded(self)
            }
            #[inline(always)]
            fn track_within(self, error: $t) -> Bounded<$t> {
                Bounded { value: self, error }
            }
            #[inline(always)]
            fn value_and_error(tracked: Bounded<$t>) -> ($t, $t) {
                (tracked.value, tracked.error)
            }
        }

        impl Real for $t {
            type Mask = bool;
            type Lane = $t;
            const LANES: usize = 1;
            const ZERO: $t = 0.0;
            const ONE: $t = 1.0;
            const EPSILON: $t = $t::EPSILON;
            const INFINITY: $t = $t::INFINITY;
            const MIN_POSITIVE: $t = $t::MIN_POSITIVE;
            #[inline(always)]
            fn lane(self, _: usize) -> $t {
                self
            }
            #[inline(always)]
            fn with_lane(self, _: usize, value: $t) -> $t {
                value
            }
            #[inline(always)]
            fn of(x: f64) -> $t {
                x as $t
            }
            #[inline(always)]
            fn to_f64(self) -> f64 {
                f64::from(self)
            }
            #[inline(always)]
            fn lt(self, other: $t) -> bool {
                self < other
            }
            #[inline(always)]
            fn le(self, other: $t) -> bool {
                self <= other
            }
            #[inline(always)]
            fn select(mask: bool, yes: $t, no: $t) -> $t {
                if mask { yes } else { no }
            }
            #[inline(always)]
            fn finite(self) -> bool {
                self.is_finite()
            }
            #[inline(always)]
            fn floor(self) -> $t {
                // Where the processor has no instruction for it, the function of the library is called.
                if cfg!(all(target_arch = "x86_64", not(target_feature = "sse4.1"))) {
                    const SHIFT: $t = 1.5 / $t::EPSILON;
                    if self.abs() < 0.25 * SHIFT {
                        // Numbers next to this one are whole, so that the sum is rounded to one.
                        let nearest = (self + SHIFT) - SHIFT;
                        let below = if nearest > self { nearest - 1.0 } else { nearest };
                        return below.copysign(self);
                    }
                }
                <$t>::floor(self)
            }
            forward! { $t: abs(); min(other); max(other); copysign(sign); sqrt(); }
            $($functions)*
        }
    };
}

/// The functions of the standard library, which are those of the host for some of them.
macro_rules! host {
    ($t:ident) => {
        #[inline(always)]
        fn powi(self, exponent: i32) -> $t {
            <$t>::powi(self, exponent)
        }
        forward! { $t:
            cbrt(); exp(); exp_m1(); ln(); ln_1p(); powf(exponent); tan(); asin(); acos(); atan(); sinh();
            cosh(); tanh(); asinh(); acosh(); atanh(); hypot(other);
        }
    };
}

#[cfg(feature = "portable")]
impl_real! { f32; crate::kernels::single_precision! { f32 } }
#[cfg(not(feature = "portable"))]
impl_real! { f32; host! { f32 } forward! { f32: sin(); cos(); atan2(x); }
    #[inline(always)]
    fn sin_cos_pi(self) -> (f32, f32) {
        crate::kernels::sin_cos_pi(self)
    }
}
impl_real! { f64; host! { f64 }
    #[inline(always)]
    fn sin(self) -> f64 {
        crate::kernels::double::sin_cos(self).0
    }
    #[inline(always)]
    fn cos(self) -> f64 {
        crate::kernels::double::sin_cos(self).1
    }
    #[inline(always)]
    fn atan2(self, x: f64) -> f64 {
        crate::kernels::double::atan2(self, x)
    }
    #[inline(always)]
    fn sin_cos_pi(self) -> (f64, f64) {
        crate::kernels::sin_cos_pi_double(self)
    }
}

#[cfg(test)]
mod tests {
    use super::Real;

    #[test]
    fn whole_numbers_below_have_the_bits_of_the_library() {
        let large = 2.0_f64.powi(51);
        let mut numbers = vec![0.0, 0.3, 0.5, 0.7, 1.0, 1.5, 2.5, 1e-300, f64::EPSILON, 1e9 + 0.5];
        numbers.extend([1.0_f64.next_down(), 0.5_f64.next_down(), large - 0.5, 0.75 * large]);
        numbers.extend([0.75 * large - 0.25, large, 4.0 * large + 1.0, f64::MAX, f64::INFINITY]);
        numbers.extend((0..1000).map(|i| f64::from(i) * 0.37 + f64::from(i).powi(5)));
        for x in numbers.into_iter().flat_map(|x| [x, -x]) {
            assert_eq!(Real::floor(x).to_bits(), x.floor().to_bits(), "{x:e}");
            let y = x as f32;
            assert_eq!(Real::floor(y).to_bits(), y.floor().to_bits(), "{y:e}");
        }
        assert!(Real::floor(f64::NAN).is_nan() && Real::floor(f32::NAN).is_nan());
    }
}
