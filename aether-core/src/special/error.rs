//! The error function, its complement, and their inverses.

use super::coefficients::{ERF, ERF_INV, ERFC, ERFC_INV, ERFC_INV_VARIABLE, ERFC_VARIABLE};
use crate::real::Real;
use crate::support::either;

/// c[0] + c[1] t + c[2] t² + …
#[inline(always)]
pub(super) fn polynomial<R: Real>(c: &[f64], t: R) -> R {
    c.iter().rev().fold(R::ZERO, |sum, &c| sum * t + R::of(c))
}

/// 1 / (x + 4), scaled to [-1, 1].
#[inline(always)]
fn scaled<R: Real>(x: R, (middle, scale): (f64, f64)) -> R {
    (R::ONE / (x + R::of(4.0)) - R::of(middle)) * R::of(scale)
}

/// x², rounded, and its rounding error by the splitting of Dekker (1971).
#[inline(always)]
fn square<R: Real>(x: R) -> (R, R) {
    // 2^27 + 1 or 2^12 + 1: half the bits of the number and one more.
    let splitter = if R::EPSILON.to_f64() < 1e-10 { R::of(134_217_729.0) } else { R::of(4097.0) };
    let t = splitter * x;
    let hi = t - (t - x);
    let lo = x - hi;
    let s = x * x;
    (s, ((hi * hi - s) + R::of(2.0) * hi * lo) + lo * lo)
}

/// `small` where |x| is at most `border`, else `large`; NaN where x is.
#[inline(always)]
fn pieces<R: Real>(x: R, border: f64, small: R, large: R) -> R {
    let inside = x.abs().le(R::of(border));
    let number = x.le(x);
    R::select(inside, small, R::select(number, large, x))
}

/// erf(x) for |x| <= 1/2.
#[inline(always)]
fn erf_small<R: Real>(x: R) -> R {
    x * polynomial(&ERF, R::of(8.0) * x * x - R::ONE)
}

/// (a + 4) exp(a²) erfc(a) for 0.46 <= a <= 28.
#[inline(always)]
fn tail_polynomial<R: Real>(a: R) -> R {
    polynomial(&ERFC, scaled(a, ERFC_VARIABLE))
}

/// exp(a²) erfc(a) for a >= 0.46; far out by its asymptotic series, in powers of -1 / (2 a²).
#[inline(always)]
fn scaled_tail<R: Real>(a: R) -> R {
    const SERIES: [f64; 8] = [1.0, 1.0, 3.0, 15.0, 105.0, 945.0, 10_395.0, 135_135.0];
    let root_pi = R::of(core::f64::consts::PI.sqrt());
    let inverse = a.recip();
    let far = polynomial(&SERIES, R::of(-0.5) * inverse * inverse) * inverse / root_pi;
    R::select(a.lt(R::of(FAR)), tail_polynomial(a) / (a + R::of(4.0)), far)
}

/// erfc(a) for a >= 0.46, where exp(-a²) = exp(-(square + rest)): the rest is the rounding error of
/// the square, which the exponential would magnify.
#[inline(always)]
fn erfc_tail<R: Real>(a: R, (square, rest): (R, R)) -> R {
    let e = (-square).exp();
    let e = e - e * rest;
    e * tail_polynomial(a) / (a + R::of(4.0))
}

/// Where erfc is zero at any precision; keeps squares finite.
const FAR: f64 = 28.0;

pub(super) fn erf<R: Real>(x: R) -> R {
    let a = x.abs().min(R::of(FAR));
    let large = (R::ONE - erfc_tail(a, square(a))).copysign(x);
    pieces(x, 0.5, erf_small(x), large)
}

pub(super) fn erfc<R: Real>(x: R) -> R {
    let a = x.abs().min(R::of(FAR));
    let tail = erfc_tail(a, square(a));
    let large = R::select(x.lt(R::ZERO), R::of(2.0) - tail, tail);
    pieces(x, 0.5, R::ONE - erf_small(x), large)
}

/// The largest number whose square is one.
#[inline(always)]
fn largest_squared<R: Real>() -> R {
    R::MIN_POSITIVE.sqrt().recip()
}

pub(super) fn ln_erfc<R: Real>(x: R) -> R {
    let half = R::of(0.5);
    let a = x.max(half).min(largest_squared());
    let (square, rest) = square(a);
    let tail = (scaled_tail(a).ln() - rest) - square;
    R::select(x.ge(half), tail, (-erf(x)).ln_1p())
}

pub(super) fn normal_cdf<R: Real>(x: R) -> R {
    let half = R::of(0.5);
    let root = R::of(core::f64::consts::FRAC_1_SQRT_2);
    let a = x.abs().min(R::of(FAR * 1.5));
    // Halving is exact: the exponential sees x² / 2 and not the square of a rounded x / √2.
    let (s, rest) = square(a);
    let tail = half * erfc_tail(a * root, (half * s, half * rest));
    let large = R::select(x.lt(R::ZERO), tail, R::ONE - tail);
    pieces(x, 0.7, half + half * erf_small(x * root), large)
}

/// erf⁻¹(x) for |x| <= 0.625.
#[inline(always)]
fn erf_inv_small<R: Real>(x: R) -> R {
    x * polynomial(&ERF_INV, R::of(2.0 / (0.625 * 0.625)) * x * x - R::ONE)
}

/// erfc⁻¹(y) for 0 <= y <= 0.375.
#[inline(always)]
fn erfc_inv_tail<R: Real>(y: R) -> R {
    let s = (-y.ln()).sqrt();
    s * polynomial(&ERFC_INV, scaled(s, ERFC_INV_VARIABLE))
}

pub(super) fn erf_inv<R: Real>(x: R) -> R {
    let tail = erfc_inv_tail(R::ONE - x.abs()).copysign(x);
    pieces(x, 0.625, erf_inv_small(x), tail)
}

pub(super) fn erfc_inv<R: Real>(y: R) -> R {
    let x = R::ONE - y;
    let upper = y.gt(R::ONE);
    let tail = erfc_inv_tail(R::select(upper, R::of(2.0) - y, y));
    pieces(x, 0.625, erf_inv_small(x), R::select(upper, -tail, tail))
}

/// The inverse of ln erfc below -600, where exp(l) is next to the smallest numbers: by Newton's method.
#[inline(always)]
fn erfc_inv_exp_far<R: Real>(l: R) -> R {
    let half_root_pi = R::of(0.5 * core::f64::consts::PI.sqrt());
    let start = -l - R::of(0.5) * (-l * R::of(core::f64::consts::PI)).ln();
    let step = |w: R| w + (ln_erfc(w) - l) * scaled_tail(w) * half_root_pi;
    step(step(start.sqrt()))
}

pub(super) fn erfc_inv_exp<R: Real>(l: R) -> R {
    let far = R::of(-600.0);
    let s = (-l.min(R::ZERO).max(far)).sqrt();
    let tail = s * polynomial(&ERFC_INV, scaled(s, ERFC_INV_VARIABLE));
    let tail = either(l.lt(far), || erfc_inv_exp_far(l.min(far)), || tail);
    // What is left of two.
    let rest = R::of(-2.0) * (l - R::of(core::f64::consts::LN_2)).exp_m1();
    let tail = R::select(l.gt(R::ZERO), -erfc_inv_tail(rest), tail);
    let x = -l.exp_m1();
    pieces(x, 0.625, erf_inv_small(x), tail)
}

pub(super) fn normal_quantile<R: Real>(u: R) -> R {
    // 2u is exact, and so is 2u - 1 wherever it is close to zero.
    let x = (u - R::of(0.5)) * R::of(2.0);
    let upper = u.gt(R::of(0.5));
    let tail = erfc_inv_tail(R::of(2.0) * R::select(upper, R::ONE - u, u));
    let root = R::of(core::f64::consts::SQRT_2);
    root * pieces(x, 0.625, erf_inv_small(x), R::select(upper, tail, -tail))
}

#[cfg(test)]
mod tests {
    use crate::special::{erf, erf_inv, erfc, erfc_inv, normal_cdf, normal_quantile};

    #[test]
    fn ends_of_the_domains() {
        for x in [f64::INFINITY, 1e300, 40.0] {
            assert_eq!((erf(x), erf(-x)), (1.0, -1.0));
            assert_eq!((erfc(x), erfc(-x)), (0.0, 2.0));
            assert_eq!((normal_cdf(x), normal_cdf(-x)), (0.0 + 1.0, normal_cdf(-x)));
        }
        assert_eq!(normal_cdf(f64::NEG_INFINITY), 0.0);
        assert_eq!((erf_inv(1.0), erf_inv(-1.0)), (f64::INFINITY, f64::NEG_INFINITY));
        assert_eq!((erfc_inv(0.0), erfc_inv(2.0)), (f64::INFINITY, f64::NEG_INFINITY));
        assert_eq!(
            (normal_quantile(0.0), normal_quantile(1.0)),
            (f64::NEG_INFINITY, f64::INFINITY)
        );
        assert_eq!((erf(0.0), erf_inv(0.0), normal_quantile(0.5)), (0.0, 0.0, 0.0));
    }

    #[test]
    fn outside_the_domain_is_not_a_number() {
        for f in [erf_inv, erfc_inv, normal_quantile] {
            assert!(f(-1.1f64).is_nan() && f(2.1f64).is_nan());
        }
        for f in [erf, erfc, normal_cdf, erf_inv, erfc_inv, normal_quantile] {
            assert!(f(f64::NAN).is_nan());
        }
    }
}
