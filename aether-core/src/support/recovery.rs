//! Uniforms that came out beyond their interval by rounding, or undetermined, and count nevertheless.

use super::manifold::leads_back;
use super::{SLACK, lane, unit};
use crate::real::{Mask, Real, Single};

/// A map of uniforms whose errors are known.
pub type Tracking<'f, T, const N: usize, const M: usize> = &'f dyn Fn(&[T; N]) -> [T; M];

/// Uniforms that count although they came out beyond their interval, and by how much they may be off.
pub type Rounded<R, const N: usize> = ([R; N], [R; N]);

/// The same, and in which lanes they do.
pub type Recovered<R, const N: usize> = Option<(<R as Real>::Mask, Rounded<R, N>)>;

/// Where `wanted` is true: the uniforms that `recover` finds in that lane, if it finds any.
#[inline(always)]
pub fn recovered<R: Real, const N: usize>(
    wanted: R::Mask,
    recover: impl Fn(usize) -> Option<Rounded<R::Lane, N>>,
) -> Recovered<R, N> {
    if wanted.any() { recover_lanes::<R, N>(wanted, recover) } else { None }
}

#[cold]
#[inline(never)]
fn recover_lanes<R: Real, const N: usize>(
    wanted: R::Mask,
    recover: impl Fn(usize) -> Option<Rounded<R::Lane, N>>,
) -> Recovered<R, N> {
    recover_lanes_by(wanted, &recover)
}

fn recover_lanes_by<R: Real, const N: usize>(
    wanted: R::Mask,
    recover: &dyn Fn(usize) -> Option<Rounded<R::Lane, N>>,
) -> Recovered<R, N> {
    let mut found: Recovered<R, N> = None;
    for i in (0..R::LANES).filter(|i| wanted.lane(*i)) {
        if let Some((u, errors)) = recover(i) {
            let none = (R::Mask::FALSE, ([R::ZERO; N], [R::ZERO; N]));
            let (mask, (all, bounds)) = found.unwrap_or(none);
            found = Some((
                mask.with_lane(i, true),
                (with_lane(all, i, u), with_lane(bounds, i, errors)),
            ));
        }
    }
    found
}

/// Numbers with others in lane `i`.
fn with_lane<R: Real, const N: usize>(all: [R; N], i: usize, one: [R::Lane; N]) -> [R; N] {
    core::array::from_fn(|k| all[k].with_lane(i, one[k]))
}

/// The lanes of recovered uniforms.
#[inline(always)]
pub fn lanes_of<R: Real, const N: usize>(recovered: &Recovered<R, N>) -> R::Mask {
    recovered.map_or(R::Mask::FALSE, |(mask, _)| mask)
}

/// Whether the uniforms recovered in lane `i` are these.
pub fn recovered_as<R: Real, const N: usize>(
    recovered: &Recovered<R, N>,
    i: usize,
    u: &Rounded<R::Lane, N>,
) -> bool {
    recovered.is_some_and(|(mask, (v, _))| mask.lane(i) && same(&lane(&v, i), u).any())
}

/// The same where a uniform of zero is also the end of what another piece has.
pub fn recovered_around<R: Real, const N: usize>(
    recovered: &Recovered<R, N>,
    i: usize,
    u: &Rounded<R::Lane, N>,
) -> bool {
    recovered.is_some_and(|(mask, (v, _))| mask.lane(i) && same_around(&lane(&v, i), u).any())
}

/// By how much recovered uniforms may be off; where there are none, by nothing.
#[inline(always)]
pub fn bounds_of<R: Real, const N: usize>(recovered: &Recovered<R, N>) -> [R; N] {
    recovered.map_or([R::ZERO; N], |(_, (_, errors))| errors)
}

/// The recovered uniforms in their lanes, others where they lie plainly inside.
#[inline(always)]
pub fn merged<R: Real, const N: usize>(
    recovered: Recovered<R, N>,
    inside: R::Mask,
    plain: impl FnOnce() -> [R; N],
) -> [R; N] {
    match recovered {
        None => plain(),
        Some((_, (u, _))) if !inside.any() => u,
        Some((mask, (u, _))) => selected(mask, u, plain()),
    }
}

/// The numbers of one list in some lanes, of the other elsewhere.
#[inline(always)]
fn selected<R: Real, const N: usize>(mask: R::Mask, yes: [R; N], no: [R; N]) -> [R; N] {
    core::array::from_fn(|k| R::select(mask, yes[k], no[k]))
}

/// By how much the uniforms of two preimages may differ at most, to be taken as one.
const MOST: f64 = 1.0 / 256.0;

/// Whether recovered uniforms lie in [0, 1) to within their error bounds; those that do are clamped.
/// A uniform that comes out undetermined (0/0 at a pole, an axis, a corner) is legal if the map leads back to the point
/// whatever its value, or from those that points next to it have (`beside`); one that lies outside and may be anything, if the
/// map leads back from the nearest end.
#[cold]
pub fn recover<R: Single, const N: usize, const M: usize>(
    u: [R::Tracked; N],
    x: &[R; M],
    beside: &dyn Fn() -> [R::Tracked; N],
    forward: Tracking<'_, R::Tracked, N, M>,
) -> Option<Rounded<R, N>> {
    let nearest = clamped::<R, N>(u)?;
    let leads = |found: &Clamped<R, N>| leads_back::<R, N, M>(found.tracked, x, forward);
    if !nearest.undetermined || leads(&nearest) {
        return Some(nearest.rounded);
    }
    if u.iter().all(|u| is_told::<R>(*u)) {
        return None;
    }
    let limits = beside();
    let told = core::array::from_fn(|i| if is_told::<R>(u[i]) { u[i] } else { limits[i] });
    clamped::<R, N>(told).filter(leads).map(|found| found.rounded)
}

/// Whether anything is known of a uniform.
fn is_told<R: Single>(u: R::Tracked) -> bool {
    let (value, error) = R::value_and_error(u);
    let (v, e) = (value.to_f64(), error.to_f64());
    !v.is_nan() && (v.is_finite() || e.is_finite())
}

/// Recovered uniforms, moved into [0, 1).
struct Clamped<R: Single, const N: usize> {
    rounded: Rounded<R, N>,
    /// Them, with what is known of their errors.
    tracked: [R::Tracked; N],
    /// Whether there is one that may be anything.
    undetermined: bool,
}

/// Uniforms that lie in [0, 1) to within their error bounds.
fn clamped<R: Single, const N: usize>(u: [R::Tracked; N]) -> Option<Clamped<R, N>> {
    let mut undetermined = false;
    let mut tracked = u;
    let (mut clamped, mut bounds) = ([R::ZERO; N], [R::ZERO; N]);
    for i in 0..N {
        let (value, error) = R::value_and_error(u[i]);
        let (v, e) = (value.to_f64(), error.to_f64());
        if !is_told::<R>(u[i]) {
            undetermined = true;
            tracked[i] = R::Tracked::ZERO;
            continue;
        }
        if !v.is_finite() || v < -SLACK * e || v > 1.0 + SLACK * e {
            return None;
        }
        clamped[i] = unit(value);
        // A bound that allows for a uniform far outside says nothing: next to a divisor of zero it is none.
        if !(-1.0..=2.0).contains(&v) {
            undetermined = true;
            tracked[i] = clamped[i].track();
        }
        // Without a bound nothing is known.
        bounds[i] = if e.is_finite() { R::of((SLACK * e).min(MOST)) } else { R::ZERO };
    }
    Some(Clamped { rounded: (clamped, bounds), tracked, undetermined })
}

/// How often the step that leads across a border is doubled.
const BESIDE: usize = 8;

/// Uniforms that are as good as recovered ones with these bounds, for which `lands` holds: rounding may have carried them
/// over a border at which the map jumps.
#[cold]
pub fn beside<R: Single, const N: usize>(
    u: &[R; N],
    bounds: &[R; N],
    lands: &dyn Fn(&[R; N]) -> bool,
) -> Option<[R; N]> {
    // As little as leads across, up to what the bounds allow.
    let steps =
        core::iter::successors(Some(R::EPSILON), |step| Some(R::of(2.0) * *step)).take(BESIDE);
    let sides = steps.flat_map(|step| [-step, step]);
    sides.flat_map(|step| (0..N).map(move |i| (i, step))).find_map(|(i, step)| {
        let mut moved = *u;
        moved[i] = unit(u[i] + step);
        let allowed = step.abs().to_f64() <= bounds[i].max(R::EPSILON).to_f64();
        (allowed && lands(&moved)).then_some(moved)
    })
}

/// Two recovered preimages that are one: equal to within rounding in every uniform.
pub fn coincide<R: Real, const N: usize>(a: &[R; N], b: &[R; N]) -> R::Mask {
    same(a, &(*b, [R::ZERO; N]))
}

/// The same where one of them is known to within bounds.
pub fn same<R: Real, const N: usize>(a: &[R; N], (b, bounds): &Rounded<R, N>) -> R::Mask {
    let near = R::of(64.0) * R::EPSILON;
    let gap = |i: usize| (a[i] - b[i]).abs();
    (0..N).fold(R::Mask::TRUE, |m, i| m.and(gap(i).le(near + bounds[i])))
}

/// The same where a uniform of zero is also the end of what another piece has.
pub fn coincide_around<R: Real, const N: usize>(a: &[R; N], b: &[R; N]) -> R::Mask {
    same_around(a, &(*b, [R::ZERO; N]))
}

/// The same where one of them is known to within bounds.
pub fn same_around<R: Real, const N: usize>(a: &[R; N], (b, bounds): &Rounded<R, N>) -> R::Mask {
    let near = R::of(64.0) * R::EPSILON;
    let gap = |i: usize| {
        let gap = (a[i] - b[i]).abs();
        gap.min((R::ONE - gap).abs())
    };
    (0..N).fold(R::Mask::TRUE, |m, i| m.and(gap(i).le(near + bounds[i])))
}

/// The largest difference between the numbers of two points.
#[inline(always)]
pub fn distance<R: Real, const N: usize>(a: &[R; N], b: &[R; N]) -> R {
    a.iter().zip(b).fold(R::ZERO, |m, (a, b)| m.max((*a - *b).abs()))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bounded::Bounded;
    use crate::support::track;

    /// The uniforms of a triangle with the sides (0, 1) and (1, 0) from its corner at (1, 0), and the map back.
    fn recovered_in_triangle(x: [f64; 2]) -> Option<Rounded<f64, 2>> {
        let [a, b] = track(&x);
        let s = Bounded::ONE - a;
        recover::<f64, 2, 2>([s, b / s], &x, &|| [s, b / s], &|u| {
            [Bounded::ONE - u[0], u[0] * u[1]]
        })
    }

    #[test]
    fn what_was_recovered_is_another_preimage_to_within_its_bounds() {
        // A quarter, lost in a difference from a thousand.
        let [x] = track(&[1000.25f64]);
        let place = (x - Bounded::of(1000.0)) * Bounded::of(-4.0) + Bounded::of(1.0);
        let (u, bounds) = recover::<f64, 1, 1>([place], &[0.0], &|| [place], &|u| *u).unwrap();
        assert!(u[0] == 0.0 && bounds[0] > 1e-12 && bounds[0] < 1e-10, "{bounds:?}");
        assert!(same(&[1e-12], &(u, bounds)) && !coincide(&[1e-12], &u));
        assert!(!same(&[1e-9], &(u, bounds)));
    }

    #[test]
    fn next_to_a_corner_a_quotient_over_zero_is_as_good_as_undetermined() {
        assert!(recovered_in_triangle([0.5, 0.2]).is_some());
        assert!(recovered_in_triangle([0.5, 0.6]).is_none());
        // 1 - x is rounded to zero, and what is over it is no zero.
        assert!(recovered_in_triangle([1.0, 1e-20]).is_some());
        assert!(recovered_in_triangle([1.0, 1e-12]).is_none());
        // An error as large as the divisor allows for any quotient, but the point is far off.
        assert!(recovered_in_triangle([1.0 - f64::EPSILON, 1e-3]).is_none());
        // An infinite number that is known to be one is outside.
        let infinite = [Bounded::exact(f64::INFINITY)];
        assert!(
            recover::<f64, 1, 1>(infinite, &[0.0], &|| infinite, &|_| [Bounded::ZERO]).is_none()
        );
    }
}
