//! Lambert's W.

use super::coefficients::LAMBERT_W;
use super::error::polynomial;
use crate::real::Real;

/// 1/e = HI + LO.
const INVERSE_E: (f64, f64) = (0.367_879_441_171_442_33, -1.242_875_367_278_836_4e-17);

/// One step of Fritsch, Shafer and Crowley (1973, "Algorithm 443"), of fourth order. What it
/// corrects is the relative error, which is computed from a logarithm near zero.
#[inline(always)]
fn improve<R: Real>(w: R, x: R) -> R {
    let z = (x / w).ln() - w;
    let one = R::ONE + w;
    let q = R::of(2.0) * one * (one + R::of(2.0 / 3.0) * z);
    w * (R::ONE + z / one * (q - z) / (q - R::of(2.0) * z))
}

pub(super) fn lambert_w<R: Real>(x: R) -> R {
    // The distance from the branch point, with 1/e in two parts so that nothing is lost there.
    let hi = R::of(INVERSE_E.0);
    let lo = R::of((INVERSE_E.0 - hi.to_f64()) + INVERSE_E.1);
    let p = (R::of(2.0 * core::f64::consts::E) * ((x + hi) + lo)).sqrt();
    let near = p + p * p * polynomial(&LAMBERT_W, p) - R::ONE;

    let l = x.ln_1p();
    let start = l * (R::ONE - l.ln_1p() / (R::of(2.0) + l));
    let rough = p + p * p * polynomial(&LAMBERT_W[..4], p) - R::ONE;
    let start = R::select(x.lt(R::of(-0.25)), rough, start);
    let far = improve(improve(start, x), x);

    // At zero and at infinity the steps are 0/0 and ∞ - ∞; W(x) is x to second order.
    let tiny = x.abs().lt(R::EPSILON * R::of(0.125));
    let at_the_end = x.ge(R::INFINITY);
    let w = R::select(p.lt(R::of(0.2)), near, far);
    R::select(tiny, x, R::select(at_the_end, x, w))
}

#[cfg(test)]
mod tests {
    use crate::special::lambert_w;

    #[test]
    fn special_values() {
        assert_eq!(lambert_w(0.0), 0.0);
        assert_eq!(lambert_w(f64::INFINITY), f64::INFINITY);
        assert!(lambert_w(-0.4f64).is_nan() && lambert_w(f64::NAN).is_nan());
        assert!((lambert_w(core::f64::consts::E) - 1.0).abs() < 1e-15);
        assert!((lambert_w(-0.367_879_441_171_442_3f64) + 1.0).abs() < 3e-8);
    }
}
