//! Values of formulas where they have only a limit, or none. What is mostly true is told by few comparisons; the rare
//! cases are functions of their own, which take all they need by value, so that the usual way keeps its numbers in registers.
//! What these do is compiled once for all formulas (`dyn`).

use crate::real::{Mask, Real};
use crate::sampler::Sampler;

/// A map of parameters and uniforms.
type Forward<'f, R, const P: usize, const N: usize, const M: usize> =
    &'f dyn Fn(&[R; P], &[R; N]) -> [R; M];

/// Whether every number is finite: of any other, the difference from itself is no zero.
#[inline(always)]
pub fn finite<R: Real, const M: usize>(x: &[R; M]) -> R::Mask {
    let told = together(x);
    // A sum of finite numbers may be none.
    if told.all() {
        return told;
    }
    each_finite(copied(x))
}

/// The same numbers in a place of their own, to be handed on to what is seldom called: that of the array itself would have to
/// be in memory on every way.
#[inline(always)]
pub fn copied<R: Real, const M: usize>(x: &[R; M]) -> [R; M] {
    let mut copy = [R::ZERO; M];
    // By numbers, for iterators and `core::array::from_fn` are not inlined where they are seldom reached, and take that place.
    let mut i = 0;
    while i < M {
        copy[i] = x[i];
        i += 1;
    }
    copy
}

/// What `value` finds where it is told which lanes have finite numbers.
#[inline(always)]
pub fn where_finite<R: Real, const M: usize>(x: &[R; M], value: impl Fn(R::Mask) -> R) -> R {
    if together(x).all() { value(R::Mask::TRUE) } else { rarely_finite(*x, value) }
}

/// Apart from what is usual, so that the compiler does not let both end in one place.
#[cold]
#[inline(never)]
fn rarely_finite<R: Real, const M: usize>(x: [R; M], value: impl Fn(R::Mask) -> R) -> R {
    value(each_finite(x))
}

/// Whether numbers are finite by their sum, which may overflow.
#[inline(always)]
fn together<R: Real, const M: usize>(x: &[R; M]) -> R::Mask {
    is_number(sum(x))
}

#[inline(always)]
fn sum<R: Real, const M: usize>(x: &[R; M]) -> R {
    let Some((first, rest)) = x.split_first() else { return R::ZERO };
    rest.iter().fold(*first, |sum, x| sum + *x)
}

#[cold]
#[inline(never)]
#[allow(clippy::eq_op)]
fn each_finite<R: Real, const M: usize>(x: [R; M]) -> R::Mask {
    x.iter().fold(R::Mask::TRUE, |all, x| all.and(is_number(*x)))
}

/// Whether a number is finite.
#[inline(always)]
#[allow(clippy::eq_op)]
fn is_number<R: Real>(x: R) -> R::Mask {
    let zero = x - x;
    zero.le(zero)
}

/// Whether a number is positive and finite.
#[inline(always)]
#[allow(clippy::eq_op)]
pub fn positive<R: Real>(x: R) -> R::Mask {
    (x - x).lt(x)
}

/// Whether a sample is as nearly all are: its coordinates are finite, its density `d` is so too and positive. Where this
/// does not hold they may still be.
#[inline(always)]
#[allow(clippy::eq_op)]
pub fn plain<R: Real, const M: usize>(x: &[R; M], d: R) -> R::Mask {
    let sum = x.iter().fold(d, |sum, x| sum + *x);
    (sum - sum).lt(d)
}

/// The sample of uniforms `u` that is not plain, and its density, which is `d` in `inner`; elsewhere roots in it may have
/// overflowed that are found on another scale by the density of the uniforms alone.
#[cold]
#[inline(never)]
pub fn rare_sample<R: Real, S: Sampler<R>>(
    sampler: S,
    u: S::Uniforms,
    d: R,
    inner: R::Mask,
) -> (S::Point, R::Mask, R) {
    let (point, exists) = sampler.forward(u);
    if inner.all() {
        return (point, exists, d);
    }
    // A lane that is plain keeps what it has alone.
    (point, exists, R::select(inner, d, sampler.pdf_of_uniforms(u).value()))
}

/// The same of a map of several pieces, of which one has the density `d`.
#[cold]
#[inline(never)]
pub fn rare_sample_of_pieces<R: Real, S: Sampler<R>>(
    sampler: S,
    u: S::Uniforms,
    d: R,
    inner: R::Mask,
) -> (S::Point, R::Mask, R) {
    let (point, exists) = sampler.forward(u);
    // At an end of a piece the map may only have a limit; the density at the point knows it.
    let untold = exists.and(inner.not()).any();
    let density = if untold { R::select(inner, d, sampler.pdf_of_uniforms(u).value()) } else { d };
    (point, exists, R::select(exists, density, R::ZERO))
}

/// The density of the sample of uniforms `u` where that by the uniforms, `d`, is zero, infinite or undetermined outside of
/// `inner`.
#[cold]
#[inline(never)]
pub fn own_limit<R: Real, S: Sampler<R>>(sampler: S, u: S::Uniforms, d: R, inner: R::Mask) -> R {
    let at_point = sampler.pdf(&sampler.forward(u).0).value();
    // If the point does not tell, an infinite density stays.
    let untold = d.ge(R::INFINITY).and(at_point.gt(R::ZERO).not());
    R::select(inner.or(untold), d, at_point)
}

/// The density at the point of a sample, where its uniforms do not tell it.
#[cold]
#[inline(never)]
pub fn limit_at<R: Real, S: Sampler<R>>(sampler: S, point: S::Point) -> R {
    sampler.pdf(&point).value()
}

/// A density that is 0/0 at a point, by its values beside it.
#[inline(always)]
pub fn limit<R: Real, const P: usize, const M: usize>(
    wanted: R::Mask,
    p: &[R; P],
    x: &[R; M],
    density: impl Fn(&[R; P], &[R; M]) -> R,
) -> R {
    let d = density(p, x);
    let undefined = wanted.and(d.ge(d).not());
    if undefined.any() { beside(d, *p, *x, density) } else { d }
}

/// The density `d` of a point where a formula tells no positive number: its limit where that is 0/0, and otherwise zero.
pub fn rare_density<R: Real, const P: usize, const M: usize>(
    d: R,
    p: &[R; P],
    x: &[R; M],
    density: impl Fn(&[R; P], &[R; M]) -> R,
) -> R {
    let d = if d.ge(d).all() { d } else { beside_by(d, p, *x, &density) };
    R::select(d.gt(R::ZERO), d, R::ZERO)
}

/// The same where coordinates that are not finite make the formula zero or no number.
pub fn rare_density_if_finite<R: Real, const P: usize, const M: usize>(
    d: R,
    p: &[R; P],
    x: &[R; M],
    density: impl Fn(&[R; P], &[R; M]) -> R,
) -> R {
    let finite = each_finite(*x);
    if finite.any() { R::select(finite, rare_density(d, p, x, density), R::ZERO) } else { R::ZERO }
}

#[cold]
#[inline(never)]
fn beside<R: Real, const P: usize, const M: usize>(
    d: R,
    p: [R; P],
    x: [R; M],
    density: impl Fn(&[R; P], &[R; M]) -> R,
) -> R {
    beside_by(d, &p, x, &density)
}

/// The size of the largest coordinate.
fn largest<R: Real, const M: usize>(x: &[R; M]) -> R {
    x.iter().fold(R::ZERO, |m, x| m.max(x.abs()))
}

/// A number that is tiny next to the coordinates of a point.
pub(super) fn tiny_beside<R: Real, const M: usize>(x: &[R; M]) -> R {
    let (size, tiny) = (largest(x), R::EPSILON * R::EPSILON);
    R::select(size.gt(R::ZERO), size * tiny, tiny)
}

fn beside_by<R: Real, const P: usize, const M: usize>(
    d: R,
    p: &[R; P],
    x: [R; M],
    density: &dyn Fn(&[R; P], &[R; M]) -> R,
) -> R {
    let tiny = tiny_beside(&x);
    // Mostly it is a coordinate of exactly zero, else some coincidence of the parameters.
    let mut moved = x;
    for x in &mut moved {
        *x = R::select(x.lt(R::ZERO).or(x.gt(R::ZERO)), *x, tiny);
    }
    let mut first = density(p, &moved);
    let size = largest(&x);
    // Away from the origin, or towards it, as where the height of a direction is one.
    for side in [8.0, -8.0] {
        if first.ge(first).all() {
            break;
        }
        let step = R::of(side) * R::EPSILON;
        let beside = core::array::from_fn(|i| {
            let outwards = R::select(moved[i].lt(R::ZERO), -size, size);
            moved[i] + R::of(i as f64 + 1.0) * step * outwards
        });
        first = R::select(first.ge(first), first, density(p, &beside));
    }
    R::select(d.ge(d), d, first)
}

/// The map at `u`, as its value `x` there, and whether it has one; where a uniform of exactly zero leads to 0/0, its
/// limit from inside. What comes out where `wanted` is false does not matter. In a space that is `bounded`, as where a
/// direction is part of the point, what is infinite is no value.
///
/// The value is given because it is computed in place then, which a function that is called again here might not be.
#[inline(always)]
pub fn closed<R: Real, const P: usize, const N: usize, const M: usize>(
    wanted: R::Mask,
    bounded: bool,
    (p, u): (&[R; P], &[R; N]),
    x: [R; M],
    forward: impl Fn(&[R; P], &[R; N]) -> [R; M],
) -> ([R; M], R::Mask) {
    // Elsewhere what is infinite stays so; a sum of such numbers may be none.
    let sum = sum(&x);
    let told = if bounded { is_number(sum) } else { sum.ge(sum) };
    if told.all() { (x, R::Mask::TRUE) } else { rarely_closed(wanted, bounded, *p, *u, x, forward) }
}

#[cold]
#[inline(never)]
fn rarely_closed<R: Real, const P: usize, const N: usize, const M: usize>(
    wanted: R::Mask,
    bounded: bool,
    p: [R; P],
    u: [R; N],
    x: [R; M],
    forward: impl Fn(&[R; P], &[R; N]) -> [R; M],
) -> ([R; M], R::Mask) {
    let (x, known) = closed_by(wanted, &p, &u, x, &forward);
    (x, if bounded { known.and(each_finite(x)) } else { known })
}

fn closed_by<R: Real, const P: usize, const N: usize, const M: usize>(
    wanted: R::Mask,
    p: &[R; P],
    u: &[R; N],
    x: [R; M],
    forward: Forward<'_, R, P, N, M>,
) -> ([R; M], R::Mask) {
    if finite(&x).or(wanted.not()).all() {
        return (x, R::Mask::TRUE);
    }
    let x = from_inside(p, u, x, forward);
    // A flight that escapes, say, has no value, and so no sample.
    (x, x.iter().fold(R::Mask::TRUE, |known, x| known.and(x.ge(*x))))
}

/// The limit of a map from inside, where its value `x` is 0/0.
pub(super) fn from_inside<R: Real, const P: usize, const N: usize, const M: usize>(
    p: &[R; P],
    u: &[R; N],
    x: [R; M],
    forward: Forward<'_, R, P, N, M>,
) -> [R; M] {
    // Far below any uniform that a generator makes, far above what underflows when squared.
    let tiny = R::EPSILON * R::EPSILON;
    // In the middle of its range a uniform cannot be moved by less than its rounding.
    let small = R::EPSILON.sqrt();
    let smaller = small * small.sqrt();
    let below_one = R::ONE - R::EPSILON * R::of(0.5);
    let zero = u.iter().fold(R::Mask::FALSE, |m, u| m.or(u.gt(R::ZERO).not()));
    let mut images = [x; 3];
    let steps = [(tiny, small), (tiny * tiny, smaller), (tiny, -smaller)];
    for (image, (at_zero, inside)) in images.iter_mut().zip(steps) {
        let mut moved = *u;
        for (i, u) in moved.iter_mut().enumerate() {
            let inner = *u * (R::ONE - R::of(i as f64 + 1.0) * inside);
            *u = R::select(zero, R::select(u.gt(R::ZERO), *u, at_zero), inner.min(below_one));
        }
        *image = forward(p, &moved);
    }
    let [near, mut limits, beyond] = images;
    for (k, limit) in limits.iter_mut().enumerate() {
        // What still shrinks with the uniform, by whatever power, tends to zero.
        let vanishes = limit.abs().lt(near[k].abs() * R::of(1e-3));
        *limit = R::select(vanishes, R::ZERO, *limit);
        // Where there is nothing on the other side either, the map has ended.
        let limited = x[k].ge(x[k]).not().and(beyond[k].ge(beyond[k]));
        *limit = R::select(limited, *limit, x[k]);
    }
    limits
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_density_without_a_value_is_its_limit() {
        let ratio = |_: &[f64; 0], x: &[f64; 1]| x[0].sin() / x[0];
        let density = |x: f64| rare_density(ratio(&[], &[x]), &[], &[x], ratio);
        assert_eq!([density(0.0), density(3.5), density(1.0)], [1.0, 0.0, 1.0_f64.sin()]);
        let faded = |x: f64| rare_density_if_finite(ratio(&[], &[x]), &[], &[x], ratio);
        assert_eq!([faded(0.0), faded(f64::INFINITY), faded(f64::NAN)], [1.0, 0.0, 0.0]);
    }

    #[test]
    fn large_numbers_are_finite_together() {
        let large = f64::MAX;
        assert!(finite(&[large, large]) && finite(&[-large, large, 1.0]) && finite::<f64, 0>(&[]));
        assert!(!finite(&[f64::INFINITY, -f64::INFINITY]) && !finite(&[0.0, f64::NAN]));
        // Together they need another look.
        assert!(!plain(&[large, large], 1.0) && plain(&[large, -1.0], 1.0));
        let (x, known) = closed(true, true, (&[large], &[0.5]), [large; 2], |p, _| [p[0], p[0]]);
        assert!(known && x == [large; 2]);
        let far = f64::INFINITY;
        let infinite =
            |bounded| closed(true, bounded, (&[far], &[0.5]), [far, -far], |p, _| [p[0], -p[0]]);
        assert!(infinite(false).1 && !infinite(true).1);
        // Nor is a direction two coordinates of which are infinite alike.
        let alike = |bounded| {
            closed(true, bounded, (&[far], &[0.5]), [far, far, 0.2], |p, _| [p[0], p[0], 0.2])
        };
        assert!(alike(false).1 && !alike(true).1);
    }

    #[test]
    fn a_sample_is_plain_only_with_a_positive_density() {
        for d in [0.0, -1.0, f64::NAN, f64::INFINITY] {
            assert!(!plain(&[1.0], d) && !positive(d), "{d}");
        }
        for x in [f64::NAN, f64::NEG_INFINITY] {
            assert!(!plain(&[x, 0.0], 1.0), "{x}");
        }
        assert!(plain(&[-5.0, 2.0], 5e-324) && positive(5e-324));
    }
}
