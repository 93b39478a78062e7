//! The gamma function.

use crate::real::Real;

pub(super) fn ln_gamma<R: Real>(x: R) -> R {
    R::of(libm::lgamma(x.to_f64()))
}
