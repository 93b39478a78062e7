//! Numbers with error bounds.

use super::SLACK;
use super::limits::tiny_beside;
use crate::real::{Real, Single};

/// Numbers with error bounds of one rounding.
#[inline]
pub fn track<R: Single, const N: usize>(x: &[R; N]) -> [R::Tracked; N] {
    x.map(R::track)
}

/// The coordinates of a direction with error bounds: rotations round them relative to one, not to
/// each coordinate.
#[inline]
pub fn track_unit<R: Single, const N: usize>(x: &[R; N]) -> [R::Tracked; N] {
    let rounding = R::ONE.track() - R::ONE.track();
    x.map(|x| x.track() + rounding)
}

/// The same where only some of the coordinates are those of directions.
#[inline]
pub fn track_some<R: Single, const N: usize>(x: &[R; N], unit: &[bool; N]) -> [R::Tracked; N] {
    let (plain, unit_vector) = (track(x), track_unit(x));
    core::array::from_fn(|i| if unit[i] { unit_vector[i] } else { plain[i] })
}

/// Numbers that are off by `errors` more, if there are any.
#[inline]
pub fn widened<R: Single, const N: usize>(
    x: [R::Tracked; N],
    errors: Option<[R; N]>,
) -> [R::Tracked; N] {
    let Some(errors) = errors else { return x };
    core::array::from_fn(|i| x[i] + R::ZERO.track_within(errors[i]))
}

/// What is known of the errors of numbers that `tracked` computes for each lane. They are handed on to somebody who
/// allows for `SLACK` times the errors that he is told of.
#[inline]
pub fn errors_of<R: Real, const N: usize>(
    tracked: impl Fn(usize) -> [<R::Lane as Single>::Tracked; N],
) -> [R; N] {
    let share = R::Lane::of(1.0 / SLACK);
    (0..R::LANES).fold([R::ZERO; N], |errors, i| {
        let lane = tracked(i);
        core::array::from_fn(|k| {
            let error = share * R::Lane::value_and_error(lane[k]).1;
            // Without a bound nothing is known.
            errors[k].with_lane(i, R::Lane::select(error.finite(), error, R::Lane::ZERO))
        })
    })
}

/// A point next to one that has coordinates of exactly zero, at which formulas that are 0/0 there give their limit.
#[cold]
pub fn off_zero<R: Single, const M: usize>(x: &[R::Tracked; M]) -> [R::Tracked; M] {
    let numbers = x.map(|x| R::value_and_error(x).0);
    let tiny = tiny_beside(&numbers).track_within(R::ZERO);
    core::array::from_fn(|i| if numbers[i].abs().gt(R::ZERO) { x[i] } else { tiny })
}

/// Whether margins are positive, but for their error bounds.
#[cold]
pub fn admits<R: Single, const N: usize>(margins: [R::Tracked; N]) -> bool {
    margins.into_iter().all(|margin| {
        let (value, error) = R::value_and_error(margin);
        // What depends on an undetermined uniform says nothing.
        value.to_f64().is_nan() || value.to_f64() >= -SLACK * error.to_f64()
    })
}
