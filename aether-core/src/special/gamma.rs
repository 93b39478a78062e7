//! The gamma function.

use crate::real::Real;

pub(super) fn ln_gamma<R: Real>(x: R) -> R {
    R::from_lanes(|i| R::Lane::of(libm::lgamma(x.lane(i).to_f64())))
}
