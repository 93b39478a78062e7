//! What emitted code calls. Not part of the public interface.

mod intervals;
mod limits;
mod manifold;
mod recovery;
mod stable;
mod tracked;

use crate::real::{Mask, Real};
pub use crate::root::{before_pole, place_of_root, root_inside, root_or_beyond, root_or_fold};
pub use intervals::{
    about_unit, all_at_least, at_end, far_from, far_from_both, in_unit, none_below, rounded_end,
    to_unit, undetermined, unit, within,
};
pub use limits::{
    closed, copied, finite, limit, limit_at, own_limit, plain, positive, rare_density,
    rare_density_if_finite, rare_sample, rare_sample_of_pieces, where_finite,
};
pub use manifold::{
    leads_back, member, near, near_one, near_or_far, near_or_far_multiple, on_or_off,
};
pub use recovery::{
    Recovered, Rounded, Tracking, beside, bounds_of, coincide, coincide_around, distance, lanes_of,
    merged, recover, recovered, recovered_around, recovered_as, same, same_around,
};
pub use stable::{
    add_logs, beside_zero, by_power, by_small_power, exp_and_m1, large_root, log_density,
    not_negative, root, root_or_infinite,
};
pub use tracked::{admits, errors_of, off_zero, track, track_some, track_unit, widened};

/// Multiple of an error bound that counts as rounding: bounds are first order, and the one who made
/// a point may have rounded a few times more than the map that is asked about it.
const SLACK: f64 = 8.0;

/// Whether a number is one of `std::f64::consts`, of single precision or more.
pub const fn is_about(found: f64, number: f64) -> bool {
    let off = found - number;
    off < 1e-6 && off > -1e-6
}

/// An angle brought into [0, 2π) by adding or subtracting whole turns.
#[inline(always)]
pub fn turn<R: Real>(angle: R) -> R {
    let tau = R::of(core::f64::consts::TAU);
    let out = angle.lt(R::ZERO).or(angle.ge(tau));
    if !out.any() {
        return angle;
    }
    R::select(out, angle - tau * (angle / tau).floor(), angle)
}

/// An angle brought to within half a turn of another one by adding or subtracting whole turns; one that is, is not rounded.
#[inline(always)]
pub fn turn_to<R: Real>(angle: R, middle: R) -> R {
    let tau = R::of(core::f64::consts::TAU);
    // Less than half a turn, whatever is rounded.
    if (angle - middle).abs().lt(R::of(3.125)).all() {
        return angle;
    }
    let turns = ((angle - middle) / tau + R::of(0.5)).floor();
    R::select(turns.lt(R::ZERO).or(turns.gt(R::ZERO)), angle - tau * turns, angle)
}

/// `yes` where the mask is true, `no` elsewhere; a side that no lane takes is not computed.
#[inline(always)]
pub fn either<R: Real>(mask: R::Mask, yes: impl FnOnce() -> R, no: impl FnOnce() -> R) -> R {
    if !mask.any() {
        no()
    } else if mask.all() {
        yes()
    } else {
        R::select(mask, yes(), no())
    }
}

/// A mask with all lanes alike.
#[inline(always)]
pub fn mask<M: Mask>(all: bool) -> M {
    if all { M::TRUE } else { M::FALSE }
}

/// The numbers of an array whose length its type does not tell.
#[inline]
pub fn numbers<R: Real, const M: usize>(list: impl AsRef<[R]>) -> [R; M] {
    let list = list.as_ref();
    core::array::from_fn(|i| list[i])
}

/// The coordinates of several points, one after the other.
#[inline(always)]
pub fn flat<R: Real, P: crate::point::Point<R>, const M: usize>(point: &P) -> [R; M] {
    numbers(point.coordinates())
}

/// The numbers in lane `i`.
#[inline]
pub fn lane<R: Real, const N: usize>(x: &[R; N], i: usize) -> [R::Lane; N] {
    x.map(|x| x.lane(i))
}
