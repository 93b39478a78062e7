//! Functions that keep their digits where the plain formula loses them.

use crate::real::{Mask, Real};

/// exp(x) and exp(x) - 1, the one from the other: next to zero the first one is the second one and one, elsewhere the second
/// one is the first one less one. Nothing cancels in either.
#[inline(always)]
pub fn exp_and_m1<R: Real>(x: R) -> (R, R) {
    let from_less = || {
        let less = x.exp_m1();
        (R::ONE + less, less)
    };
    let from_whole = || {
        let whole = x.exp();
        (whole, whole - R::ONE)
    };
    let is_near = x.abs().lt(R::of(core::f64::consts::LN_2));
    if is_near.all() {
        return from_less();
    }
    let (whole, less) = from_whole();
    if !is_near.any() {
        return (whole, less);
    }
    let near = from_less();
    (R::select(is_near, near.0, whole), R::select(is_near, near.1, less))
}

/// The square root of a sum of squares. Where the squares underflow or overflow, `scaled` computes the sum
/// again with the numbers that are squared multiplied by what it is given.
///
/// The root is taken first: several functions that ask for it, one after another, then share it.
#[inline(always)]
pub fn root<R: Real>(sum: R, scaled: impl Fn(R) -> R) -> R {
    let root = sum.sqrt();
    let usual = sum.ge(R::MIN_POSITIVE / R::EPSILON).and(sum.lt(R::INFINITY));
    if usual.all() { root } else { scaled_root(sum, scaled) }
}

/// The same where it is looked afterwards whether what the root is a factor of is a number: of what overflows it is none.
#[inline(always)]
pub fn root_or_infinite<R: Real>(sum: R, scaled: impl Fn(R) -> R) -> R {
    if sum.ge(R::MIN_POSITIVE / R::EPSILON).all() { sum.sqrt() } else { scaled_root(sum, scaled) }
}

/// The same of a sum with a positive number among its terms, which only overflows.
#[inline(always)]
pub fn large_root<R: Real>(sum: R, scaled: impl Fn(R) -> R) -> R {
    if sum.lt(R::INFINITY).all() { sum.sqrt() } else { scaled_root(sum, scaled) }
}

/// Takes the closure by value, as what is rare does, and hands it on as one of any type: what follows is compiled once.
#[cold]
#[inline(never)]
fn scaled_root<R: Real>(sum: R, scaled: impl Fn(R) -> R) -> R {
    scaled_root_by(sum, &scaled)
}

fn scaled_root_by<R: Real>(sum: R, scaled: &dyn Fn(R) -> R) -> R {
    let small = sum.lt(R::MIN_POSITIVE / R::EPSILON);
    // Large numbers overflow, if they are multiplied by what brings the smallest ones, or squares of small ones
    // with small factors, up to one.
    let up = R::MIN_POSITIVE.sqrt().recip();
    let mut roots = [R::MIN_POSITIVE.recip(), up, up.sqrt(), up.recip()];
    for root in &mut roots {
        *root = scaled(*root).sqrt() / *root;
    }
    let [least, most, less, large] = roots;
    let root = R::select(less.finite(), less, sum.sqrt());
    let root = R::select(most.finite(), most, root);
    let root = R::select(small, R::select(least.finite(), least, root), sum.sqrt());
    R::select(sum.ge(R::INFINITY), large, root)
}

/// The power of a base as `value`, which is by way of another power of it, or by itself where that one has left the
/// range of normal numbers.
#[inline(always)]
pub fn by_power<R: Real>(other: R, value: R, base: R, exponent: R) -> R {
    let usable = other.gt(R::MIN_POSITIVE).and(other.lt(R::INFINITY));
    if usable.all() { value } else { R::select(usable, value, rare_power(base, exponent)) }
}

/// The same by way of a power that is at most one.
#[inline(always)]
pub fn by_small_power<R: Real>(other: R, value: R, base: R, exponent: R) -> R {
    let usable = other.gt(R::MIN_POSITIVE);
    if usable.all() { value } else { R::select(usable, value, rare_power(base, exponent)) }
}

/// A function of its own, so that it is not computed in advance.
#[cold]
#[inline(never)]
fn rare_power<R: Real>(base: R, exponent: R) -> R {
    base.powf(exponent)
}

/// A number that is not negative, unless rounding made it so: `scale` is how large what was added up to it is together. One
/// that is plainly negative stays: its root is no number.
#[inline(always)]
pub fn not_negative<R: Real>(x: R, scale: impl FnOnce() -> R) -> R {
    let negative = x.lt(R::ZERO);
    if !negative.any() {
        return x;
    }
    let rounded = negative.and(x.gt(R::of(-256.0) * R::EPSILON * scale()));
    R::select(rounded, R::ZERO, x)
}

/// A parameter of exactly zero, moved by so little that formulas that are 0/0 there give their limit.
#[inline(always)]
pub fn beside_zero<R: Real>(x: R) -> R {
    let zero = x.le(R::ZERO).and(x.ge(R::ZERO));
    if zero.any() { moved_from_zero(x, zero) } else { x }
}

/// A function of its own, so that nothing is selected where no number is zero.
#[cold]
#[inline(never)]
fn moved_from_zero<R: Real>(x: R, zero: R::Mask) -> R {
    R::select(zero, R::EPSILON * R::EPSILON, x)
}

/// The logarithm of a density, which `beyond` computes where the density is no normal number.
#[inline]
pub fn log_density<R: Real>(density: R, beyond: impl FnOnce() -> R) -> R {
    let normal = density.ge(R::MIN_POSITIVE).and(density.lt(R::INFINITY));
    let plain = density.ln();
    if normal.all() { plain } else { R::select(normal, plain, beyond()) }
}

/// ln(exp(a) + exp(b)) without overflow.
#[inline]
pub fn add_logs<R: Real>(a: R, b: R) -> R {
    let (larger, smaller) = (a.max(b), a.min(b));
    let sum = larger + (smaller - larger).exp().ln_1p();
    R::select(larger.finite(), sum, larger)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn exponentials_tell_what_they_are_more_than_one() {
        let close = |found: f32, exact: f64| {
            let unit = f64::from(f32::EPSILON) * exact.abs();
            assert!((f64::from(found) - exact).abs() <= 1.5 * unit, "{found:e} {exact:e}");
        };
        let around = (-1000..=1000).map(|i| 0.01 * i as f32);
        let border = core::f32::consts::LN_2;
        for x in around.chain([1e-30, -1e-7, 80.0, -80.0, border, -border]) {
            let (whole, less) = exp_and_m1(x);
            close(whole, f64::from(x).exp());
            close(less, f64::from(x).exp_m1());
        }
        assert_eq!(exp_and_m1(f64::INFINITY), (f64::INFINITY, f64::INFINITY));
        assert_eq!(exp_and_m1(f64::NEG_INFINITY), (0.0, -1.0));
        assert_eq!(exp_and_m1(-0.0_f64), (1.0, -0.0));
        assert!(exp_and_m1(f64::NAN).0.is_nan() && exp_and_m1(f64::NAN).1.is_nan());
    }

    #[test]
    fn roots_are_found_on_another_scale_unless_they_may_be_infinite() {
        let length = |root: fn(f32, &dyn Fn(f32) -> f32) -> f32, x: f32| {
            let scaled = move |up: f32| (x * up) * (x * up) + (x * up) * (x * up);
            root(x * x + x * x, &scaled)
        };
        let both = |x: f32| {
            [
                length(|sum, scaled| root(sum, scaled), x),
                length(|sum, scaled| root_or_infinite(sum, scaled), x),
            ]
        };
        let [small, large] = [1e-30, 1e30].map(|x| (both(x), x * core::f32::consts::SQRT_2));
        assert!(small.0.iter().all(|found| (found / small.1 - 1.0).abs() < 1e-6));
        assert!((large.0[0] / large.1 - 1.0).abs() < 1e-6 && large.0[1] == f32::INFINITY);
        assert!(both(f32::NAN).iter().all(|found| found.is_nan()));
    }

    #[test]
    fn what_rounding_made_negative_is_so_by_what_was_added_up() {
        // 3² + 4² - 5² a million times as large, where the last root is rounded.
        assert_eq!(not_negative(-1e-4_f64, || 5e13), 0.0);
        assert_eq!(not_negative(-1e-14_f64, || 1e-8), -1e-14);
        assert_eq!(not_negative(0.25_f64, || f64::NAN), 0.25);
        assert!(not_negative(f64::NAN, || 1.0).is_nan());
    }
}
