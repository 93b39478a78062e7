//! Whether numbers lie in [0, 1) as uniforms do, in other intervals, or but for rounding.

use crate::real::{Mask, Real};

/// Whether every number is in [0, 1).
#[inline(always)]
pub fn in_unit<R: Real, const N: usize>(u: &[R; N]) -> R::Mask {
    u.iter().fold(R::Mask::TRUE, |m, u| m.and(u.ge(R::ZERO)).and(u.lt(R::ONE)))
}

/// Where `mask` is true and no number below `least`, nor undetermined.
#[inline(always)]
pub fn all_at_least<R: Real, const N: usize>(mask: R::Mask, x: &[R; N], least: R) -> R::Mask {
    x.iter().fold(mask, |m, x| m.and(x.ge(least)))
}

/// Where `mask` is true and no number below `least`; undetermined ones count as not below.
#[inline(always)]
pub fn none_below<R: Real, const N: usize>(mask: R::Mask, x: &[R; N], least: R) -> R::Mask {
    x.iter().fold(mask, |m, x| m.and(x.lt(least).not()))
}

/// Whether no number is so far outside [0, 1) that rounding cannot have put it there. An undetermined
/// one may be anywhere, and so may one next to an end of another: at a pole, or a corner of a triangle,
/// it is as good as undetermined. What passes is decided by error bounds, which cost more.
#[inline(always)]
pub fn about_unit<R: Real, const N: usize>(u: &[R; N]) -> R::Mask {
    let slack = rounding_slack::<R>();
    let outside = |u: &R| u.lt(-slack).or(u.gt(R::ONE + slack));
    let inside = u.iter().fold(R::Mask::TRUE, |m, u| m.and(outside(u).not()));
    if N == 1 || inside.all() {
        return inside;
    }
    let end = R::of(1.0 / 256.0);
    let at_end = |u: &R| u.abs().lt(end).or((*u - R::ONE).abs().lt(end));
    inside.or(u.iter().fold(R::Mask::FALSE, |m, u| m.or(at_end(u))))
}

/// Whether a number is so far outside of an interval that rounding cannot have put it there.
#[inline(always)]
pub fn far_from<R: Real>(x: R, low: R, high: R) -> R::Mask {
    let slack = rounding_slack::<R>() * (low.abs() + high.abs());
    x.lt(low - slack).or(x.gt(high + slack))
}

/// The same of an interval whose ends come in any order.
#[inline(always)]
pub fn far_from_both<R: Real>(x: R, one: R, other: R) -> R::Mask {
    far_from(x, one.min(other), one.max(other))
}

/// What is no rounding error any more, relative to one: 2³⁷ roundings, or an eighth.
#[inline(always)]
fn rounding_slack<R: Real>() -> R {
    (R::EPSILON * R::of((1_u64 << 37) as f64)).min(R::of(0.125))
}

/// Whether some number is undetermined: 0/0 at a pole, an axis, a corner.
pub fn undetermined<R: Real, const N: usize>(u: &[R; N]) -> bool {
    u.iter().any(|u| u.ge(*u).not().any())
}

/// Whether a place within a segment lies so near to one of its ends that rounding may have put it on either
/// side.
#[inline(always)]
pub fn at_end<R: Real>(t: R) -> R::Mask {
    let end = R::of(1.0 / 1024.0);
    t.lt(end).or(t.gt(R::ONE - end))
}

/// A point of the half-open interval of this width from `low`, by its place in [0, 1).
#[inline(always)]
pub fn within<R: Real>(low: R, width: R, place: R) -> R {
    let u = low + width * place;
    // Rounded up to the other end: stay below it.
    let end = low + width;
    R::select(u.lt(end).or(width.le(R::ZERO)), u, end - end * (R::EPSILON * R::of(0.5)))
}

/// The next number within a domain, of one that is an end of it but for rounding: 0.99 in single precision is larger than
/// 0.99. An end that is no number is none.
#[cold]
pub fn rounded_end<R: Real>(value: R, [low, high]: [f64; 2]) -> Option<R> {
    let is = |end: f64| value.to_f64() == R::of(end).to_f64();
    let step = value.abs() * R::EPSILON;
    let inner = if is(high) {
        value - step
    } else if is(low) {
        value + step
    } else {
        return None;
    };
    let high = if high.is_nan() { f64::INFINITY } else { high };
    (low..=high).contains(&inner.to_f64()).then_some(inner)
}

/// Numbers beyond the ends of [0, 1] moved to them, with what is known of their errors.
#[inline]
pub fn to_unit<R: Real, const N: usize>(u: [R; N]) -> [R; N] {
    // A number that is undetermined stays so.
    u.map(|u| R::select(u.ge(u), u.max(R::ZERO).min(R::ONE), u))
}

/// The number, if it lies in [0, 1); else the nearest one that does.
#[inline(always)]
pub fn unit<R: Real>(u: R) -> R {
    u.max(R::ZERO).min(R::ONE - R::EPSILON * R::of(0.5))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_rounding_explains_is_not_far_from_an_interval() {
        let far = |x: f64| far_from(x, -2.0, 1.0);
        assert!(!far(-2.0) && !far(0.3) && !far(1.0 + 1e-5) && !far(f64::NAN));
        assert!(far(1.001) && far(-2.001) && far(f64::INFINITY));
        // An end of zero is as uncertain as the other one is large.
        assert!(!far_from(-1e-3_f32, 0.0, 1.0) && far_from(-1.0_f32, 0.0, 1.0));
    }
}
