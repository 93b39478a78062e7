//! What emitted code calls. Not part of the public interface.

mod limits;
mod manifold;

use crate::real::{Mask, Real, Single};
pub use crate::root::{before_pole, place_of_root, root_inside, root_or_beyond, root_or_fold};
use limits::tiny_beside;
pub use limits::{
    closed, density_at, finite, limit, limit_at, own_limit, plain, positive, rare_sample,
    rare_sample_of_pieces, where_finite,
};
pub use manifold::{leads_back, member, near, near_or_far, near_or_far_multiple, on_or_off};

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
#[inline(always)]
pub fn root<R: Real>(sum: R, scaled: impl Fn(R) -> R) -> R {
    let usual = sum.ge(R::MIN_POSITIVE / R::EPSILON).and(sum.lt(R::INFINITY));
    if usual.all() { sum.sqrt() } else { scaled_root(sum, scaled) }
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

/// A mask with all lanes alike.
#[inline(always)]
pub fn mask<M: Mask>(all: bool) -> M {
    if all { M::TRUE } else { M::FALSE }
}

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

/// The power of a base as `value`, which is by way of another power of it, or by itself where that one has left the
/// range of normal numbers.
#[inline(always)]
pub fn by_power<R: Real>(other: R, value: R, base: R, exponent: R) -> R {
    let usable = other.gt(R::MIN_POSITIVE).and(other.lt(R::INFINITY));
    if usable.all() { value } else { R::select(usable, value, rare_power(base, exponent)) }
}

/// A function of its own, so that it is not computed in advance.
#[cold]
#[inline(never)]
fn rare_power<R: Real>(base: R, exponent: R) -> R {
    base.powf(exponent)
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
    use crate::bounded::Bounded;

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
    fn what_rounding_explains_is_not_far_from_an_interval() {
        let far = |x: f64| far_from(x, -2.0, 1.0);
        assert!(!far(-2.0) && !far(0.3) && !far(1.0 + 1e-5) && !far(f64::NAN));
        assert!(far(1.001) && far(-2.001) && far(f64::INFINITY));
        // An end of zero is as uncertain as the other one is large.
        assert!(!far_from(-1e-3_f32, 0.0, 1.0) && far_from(-1.0_f32, 0.0, 1.0));
    }

    #[test]
    fn what_rounding_made_negative_is_so_by_what_was_added_up() {
        // 3² + 4² - 5² a million times as large, where the last root is rounded.
        assert_eq!(not_negative(-1e-4_f64, || 5e13), 0.0);
        assert_eq!(not_negative(-1e-14_f64, || 1e-8), -1e-14);
        assert_eq!(not_negative(0.25_f64, || f64::NAN), 0.25);
        assert!(not_negative(f64::NAN, || 1.0).is_nan());
    }

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
