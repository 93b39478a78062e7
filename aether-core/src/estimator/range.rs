//! What keeps quotients in the range of numbers.

use crate::estimator::Value;
use crate::path_density::PathDensity;
use crate::real::Scalar;

/// Whether a density is neither zero nor infinite.
#[inline(always)]
pub(super) fn is_regular<R: Scalar>(p: R) -> bool {
    // Infinity times zero is no number. Compared with infinity, this would become a test of bits.
    p > R::ZERO && p * R::ZERO == R::ZERO
}

/// f / p; zero where the density is none that a sample can have.
#[inline(always)]
pub(super) fn per<R: Scalar, T: Value<R>>(f: T, p: R) -> T {
    if is_regular(p) { f.over(p) } else { T::zero() }
}

/// The same value times the same scale, where neither it nor a product with a factor of ordinary size leaves the range of numbers.
#[inline]
pub(super) fn moderate<R: Scalar, T: Value<R>>(
    value: T,
    scale: PathDensity<R>,
) -> (T, PathDensity<R>) {
    let step = R::of((1_u64 << 48) as f64);
    if value.times(R::MIN_POSITIVE * step).is_zero() {
        return (value.times(step), scale * step.recip());
    }
    let is_large = !is_usable(value.times((R::MIN_POSITIVE * step).recip()));
    if is_large { (value.over(step), scale * step) } else { (value, scale) }
}

/// Whether a value is in the range of numbers, and not zero.
#[inline(always)]
pub(super) fn is_usable<R: Scalar, T: Value<R>>(value: T) -> bool {
    value.times(R::ZERO).is_zero() && !value.is_zero()
}
