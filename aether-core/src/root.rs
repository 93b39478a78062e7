//! Roots of monotone functions, where there is no closed form.
//!
//! In the body of a sampler or a map, [`solve`] is a part of the language: the compiler proves that the
//! function is monotone, finds the inverse and the density (by the implicit function), and emits its
//! own code. It calls the other functions of this module, which are not part of the public interface.

use core::ops::{Bound, RangeBounds};

use crate::real::{Mask, Real};

/// Steps after which a root is as good as it gets; bisection alone needs fewer.
const MAX_STEPS: usize = 160;

/// The number t in `range` for which `body(t)` is `target`, to full precision.
///
/// `body` must increase, or decrease, over the whole range, which may be infinite (`0.0..`), and have
/// the value `target` somewhere in it; if it does not, the nearer end is returned. NaN for a target that
/// is NaN.
///
/// In the body of a `#[sampler]` or `#[map]`, write the closure in place. A step of sampling that is
/// only known implicitly, such as the inverse of a cumulative distribution, is then
///
/// ```
/// use aether_core::prelude::*;
///
/// /// Kepler's equation: the eccentric anomaly of a planet at a random time.
/// #[sampler(e in 0.0..=0.9)]
/// fn anomaly(u: [Uniform; 1], e: f64) -> f64 {
///     solve(|a| a - e * a.sin(), 0.0..TAU, TAU * u[0])
/// }
///
/// let a = anomaly(0.5).expect("0.5 lies in the declared domain").sample([0.25]);
/// assert!((a.value() - 0.5 * a.value().sin() - 0.25 * TAU).abs() < 1e-15);
/// ```
pub fn solve(body: impl Fn(f64) -> f64, range: impl RangeBounds<f64>, target: f64) -> f64 {
    let end = |b: Bound<&f64>, open: f64| match b {
        Bound::Included(x) | Bound::Excluded(x) => *x,
        Bound::Unbounded => open,
    };
    let (lo, hi) =
        (end(range.start_bound(), f64::NEG_INFINITY), end(range.end_bound(), f64::INFINITY));
    let (a, b) = (lo.max(-1e300), hi.min(1e300));
    let sign = if body(a) <= body(b) { 1.0 } else { -1.0 };
    // Without a derivative, each step is a bisection.
    root_inside(|t: f64| (sign * body(t), f64::NAN), sign * target, lo, hi)
}

/// The root of an increasing function, given with its slope, whose values from `lo` to `hi` include
/// `target`; the nearer end if rounding has moved the target beyond them.
#[doc(hidden)]
pub fn root_inside<R: Real>(f: impl Fn(R) -> (R, R), target: R, lo: R, hi: R) -> R {
    let ((at_lo, up_lo), (at_hi, up_hi)) = (f(lo), f(hi));
    let (below, above) = (at_lo.ge(target), at_hi.le(target));
    let ended = below.or(above);
    let root = if ended.not().any() { bracketed(f, target, lo, hi) } else { lo };
    if !ended.any() {
        return root;
    }
    let first = uncertain(lo, at_lo - target, up_lo);
    let last = uncertain(hi, at_hi - target, up_hi);
    R::select(below, first, R::select(above, last, root))
}

/// On which side of the ends the root of an increasing function lies: beyond them what [`root_or_beyond`]
/// finds, between them a number that is between them too.
#[doc(hidden)]
#[inline(always)]
pub fn place_of_root<R: Real>(f: impl Fn(R) -> R, target: R, lo: R, hi: R) -> R {
    let (at_lo, at_hi) = (f(lo), f(hi));
    let scale = (hi - lo) / (at_hi - at_lo);
    let usable = scale.gt(R::ZERO).and(scale.finite());
    let scale = R::select(usable, scale, hi - lo);
    R::select(at_hi.le(target), hi + (target - at_hi) * scale, lo + (target - at_lo) * scale)
}

/// The last number before a pole at an end of the range of an increasing function: of the end and the numbers next to it the
/// one that rounding has not put beyond the pole, where values have the sign of the other side.
#[doc(hidden)]
pub fn before_pole<R: Real>(f: impl Fn(R) -> R, end: R, other: R) -> R {
    let (from, width) = (end.exact(), (other - end).exact());
    let unit = (from.abs().max(width.abs()) * R::EPSILON * R::of(0.5)).copysign(width);
    let upper = width.lt(R::ZERO);
    let (mut best, mut at_best) = (from, f(from).exact());
    for roundings in [0.5, 1.0, 2.0, 4.0, 8.0] {
        let next = from + unit * R::of(roundings);
        let at_next = f(next).exact();
        let better = R::select(upper, at_next - at_best, at_best - at_next).gt(R::ZERO);
        best = R::select(better, next, best);
        at_best = R::select(better, at_next, at_best);
    }
    best
}

/// The same where the target may lie beyond the values: then the root lies beyond the ends, as far
/// outside as the target is on the scale of the function.
#[doc(hidden)]
pub fn root_or_beyond<R: Real>(f: impl Fn(R) -> (R, R), target: R, lo: R, hi: R) -> R {
    let (at_lo, at_hi) = (f(lo).0, f(hi).0);
    let (below, above) = (at_lo.ge(target), at_hi.le(target));
    let scale = (hi - lo) / (at_hi - at_lo).exact();
    let usable = scale.gt(R::ZERO).and(scale.finite());
    let scale = R::select(usable, scale, hi - lo);
    let beyond = R::select(below, lo - (at_lo - target) * scale, hi + (target - at_hi) * scale);
    if !below.or(above).not().any() {
        return beyond;
    }
    R::select(below.or(above), beyond, bracketed(f, target, lo, hi))
}

/// The same for a function that may turn back at an end: there the root of a target beyond its values is as far outside as
/// that of one within them is inside, by the square root of the difference.
#[doc(hidden)]
pub fn root_or_fold<R: Real>(f: impl Fn(R) -> (R, R), target: R, lo: R, hi: R) -> R {
    let ((at_lo, from), (at_hi, to)) = (f(lo), f(hi));
    let (below, above) = (at_lo.ge(target), at_hi.le(target));
    let root = if below.or(above).all() { lo } else { bracketed(&f, target, lo, hi) };
    if !below.or(above).any() {
        return root;
    }
    let known = |x: R| R::select(x.gt(R::ZERO).and(x.finite()), x, R::ONE);
    let (width, height) = (known((hi - lo).exact()), known((at_hi - at_lo).exact()));
    // A target at a fold may have been rounded to it: else it would be next to it, and its density not infinite.
    let rounding = target.exact().abs() * R::EPSILON * R::of(0.25);
    // By the parabola with the slope at the end, and the curvature that the other one tells.
    let distance = |excess: R, slope: R| {
        let slope = R::select(slope.finite(), slope.abs(), R::ZERO);
        let off = R::select(excess.gt(rounding), excess, rounding + (excess - excess.exact()));
        let square = slope * slope + R::of(4.0) * off * (height / (width * width));
        // Exact, so that bounds allow for as much as they do of the value.
        let distance = R::of(2.0) * off / (slope + square.sqrt()).exact();
        R::select(square.gt(R::ZERO), distance, off)
    };
    let first = lo - distance(at_lo - target, from);
    let last = hi + distance(target - at_hi, to);
    R::select(below, first, R::select(above, last, root))
}

/// Newton's method inside a bracket that only shrinks, with a step of bisection wherever Newton's
/// would leave it or is slow. For tracked numbers, the error of the root is that of the equation over
/// the slope.
fn bracketed<R: Real>(f: impl Fn(R) -> (R, R), target: R, lo: R, hi: R) -> R {
    let goal = target.exact();
    let huge = R::MIN_POSITIVE.recip();
    let (mut a, mut b) = (lo.exact().max(-huge), hi.exact().min(huge));
    let mut t = first(a, b).exact();
    let mut last = b - a;
    let mut done = goal.le(goal).not();
    for _ in 0..MAX_STEPS {
        let (y, slope) = f(t);
        let (y, slope) = (y.exact(), slope.exact());
        // Where the function is no number (infinity less infinity), it is the outer end that moves.
        let known = y.le(y);
        let over = y.gt(goal).or(known.not().and(b.abs().gt(a.abs())));
        // A lane that is done stays as it is while others go on.
        b = R::select(over.and(done.not()), t, b);
        a = R::select(over.or(done), a, t);
        done = done.or(y.le(goal).and(y.ge(goal)));
        let newton = step(t, y, goal, slope);
        let size = (newton - t).abs();
        let steady = size.le(last * R::of(0.75));
        // Close to the root, steps shrink quadratically until they are rounding: those no longer do.
        let rounding = steady.not().and(size.le(t.abs() * R::EPSILON.sqrt()));
        let settled = rounding.or(size.le(t.abs() * R::EPSILON * R::of(4.0)));
        let within = newton.gt(a).and(newton.lt(b));
        let usable = within.and(steady.or(settled));
        let next = R::select(usable, newton, middle(a, b)).exact();
        let moved = (next - t).abs();
        // A step beyond the bracket tells that the root is near its end, but not that it is here.
        let settled = settled.and(within.or(size.le(t.abs() * R::EPSILON * R::of(4.0))));
        t = R::select(done.or(settled.and(within.not())), t, next);
        done = done.or(settled);
        done = done.or((b - a).le(a.abs().max(b.abs()) * R::EPSILON * R::of(0.5)));
        if !done.not().any() {
            break;
        }
        last = moved;
    }
    // Once more with errors: the root is known as well as target and function are.
    let (y, slope) = f(t);
    let polished = t - (y - target) / slope;
    let usable = slope.gt(R::ZERO).and(polished.ge(a)).and(polished.le(b));
    R::select(goal.le(goal), R::select(usable, polished, uncertain(t, y - target, slope)), goal)
}

/// A number at which the equation is off by `excess`, as uncertain as that is.
fn uncertain<R: Real>(t: R, excess: R, slope: R) -> R {
    let error = (excess - excess.exact()) / slope.exact();
    R::select(slope.gt(R::ZERO).and(error.finite()), t + error, t)
}

/// A step of Newton's method; where the value is far off and has the sign of the target, one on
/// logarithmic scales, which is exact for powers.
#[inline]
fn step<R: Real>(t: R, y: R, goal: R, slope: R) -> R {
    let (ratio, exponent) = (goal / y, y / (slope * t));
    let far = ratio.gt(R::of(2.0)).or(ratio.lt(R::of(0.5)));
    // At zero itself the exponent is infinite.
    let power = exponent.gt(R::ZERO).and(exponent.finite());
    let scaled = power.and(ratio.gt(R::ZERO)).and(ratio.finite()).and(far);
    let plain = t - (y - goal) / slope;
    if scaled.any() { R::select(scaled, t * ratio.powf(exponent), plain) } else { plain }
}

/// Where to start: in the middle, or near a finite end.
fn first<R: Real>(a: R, b: R) -> R {
    let huge = R::MIN_POSITIVE.recip();
    let (down, up) = (a.le(-huge), b.ge(huge));
    let right = R::select(up, a + a.abs().max(R::ONE), (a + b) * R::of(0.5));
    let left = R::select(up, R::ZERO, b - b.abs().max(R::ONE));
    R::select(down, left, right)
}

/// Between a and b: zero if they have different signs, and on a logarithmic scale if they differ
/// much.
fn middle<R: Real>(a: R, b: R) -> R {
    let small = a.abs().min(b.abs()).max(R::MIN_POSITIVE);
    let large = a.abs().max(b.abs());
    let size = small.sqrt() * large.sqrt();
    let geometric = R::select(b.gt(R::ZERO), size, -size);
    let arithmetic = a + (b - a) * R::of(0.5);
    let m = R::select(large.gt(small * R::of(4.0)), geometric, arithmetic);
    R::select(a.lt(R::ZERO).and(b.gt(R::ZERO)), R::ZERO, m)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bounded::Bounded;
    use core::f64::consts::TAU;
    use std::cell::Cell;

    fn smoothstep<R: Real>(t: R) -> (R, R) {
        let two = R::of(2.0);
        (t * t * t * (two - t), t * t * (R::of(6.0) - R::of(4.0) * t))
    }

    #[test]
    fn full_precision_with_a_vanishing_slope() {
        for u in [1e-300, 1e-18, 1e-9, 0.1, 0.5, 0.99, 1.0 - 1e-15] {
            let steps = Cell::new(0);
            let counted = |t: f64| {
                steps.set(steps.get() + 1);
                smoothstep(t)
            };
            let t = root_inside(counted, u, 0.0, 1.0);
            assert!((smoothstep(t).0 / u - 1.0).abs() < 1e-15, "{u}: {t}");
            assert!(steps.get() < 40, "{u}: {} steps", steps.get());
            let single = root_inside(smoothstep::<f32>, u as f32, 0.0, 1.0);
            let back = smoothstep(single).0;
            assert!((back - u as f32).abs() <= 1e-6 * u as f32, "{u}: {back}");
        }
        assert_eq!(root_inside(smoothstep::<f64>, 0.0, 0.0, 1.0), 0.0);
        assert_eq!(root_inside(smoothstep::<f64>, 1.0 + 1e-15, 0.0, 1.0), 1.0);
    }

    #[test]
    fn infinite_ranges() {
        let tail = |t: f64| (-(-t).exp_m1(), (-t).exp());
        for u in [1e-300, 1e-12, 0.5, 1.0 - 1e-15] {
            let t = root_inside(tail, u, 0.0, f64::INFINITY);
            assert!((tail(t).0 / u - 1.0).abs() < 4e-16, "{u}: {t}");
        }
        let cube = |t: f64| (t * t * t, 3.0 * t * t);
        for x in [-1e90f64, -8.0, 0.0, 1e-60, 27.0] {
            let t = root_inside(cube, x, f64::NEG_INFINITY, f64::INFINITY);
            assert!((t - x.cbrt()).abs() <= 1e-15 * x.cbrt().abs(), "{x}: {t}");
        }
    }

    #[test]
    fn beyond_the_ends() {
        assert_eq!(root_or_beyond(smoothstep::<f64>, -0.25, 0.0, 1.0), -0.25);
        assert_eq!(root_or_beyond(smoothstep::<f64>, 1.5, 0.0, 1.0), 1.5);
        assert!(root_or_beyond(smoothstep::<f64>, f64::NAN, 0.0, 1.0).is_nan());
        assert!(root_inside(smoothstep::<f64>, f64::NAN, 0.0, 1.0).is_nan());
    }

    #[test]
    fn beyond_a_fold() {
        // t (1 - t) rises up to a half.
        let fold = |t: f64| (t * (1.0 - t), 1.0 - 2.0 * t);
        let root = |target: f64| root_or_fold(fold, target, 0.0, 0.5);
        for distance in [0.25, 1e-3, 1e-7] {
            let off = root(0.25 - distance * distance) - (0.5 - distance);
            assert!(off.abs() <= 1e-16 / distance, "{distance}: {off}");
            let beyond = root(0.25 + distance * distance) - (0.5 + distance);
            assert!(beyond.abs() <= 1e-15 / distance, "{distance}: {beyond}");
        }
        // At the other end it goes on as it did.
        assert!((root(-1e-9) + 1e-9).abs() < 1e-16 && root(-0.5) < -0.3);
        assert!((root(0.25) - 0.5) > 1e-9 && (root(0.25) - 0.5) < 1e-8);
        assert!(root(f64::NAN).is_nan());
        // A piece without width has its root where it is, or beyond it.
        let none = root_or_fold(fold, 0.2, 0.5, 0.5);
        assert!(none < 0.5 && root_or_fold(fold, 0.3, 0.5, 0.5) > 0.5);
        // Rounding of the value explains a distance of the root of that.
        let track = |x: f64| Bounded { value: x, error: 1e-16 };
        let tracked = |t: Bounded<f64>| (t * (Bounded::ONE - t), Bounded::ONE - t - t);
        let [lo, hi] = [0.0, 0.5].map(Bounded::exact);
        let near = root_or_fold(tracked, track(0.25 + 1e-16), lo, hi);
        assert!((near.value - 0.5) < 8.0 * near.error && near.error < 1e-7, "{near:?}");
        let far = root_or_fold(tracked, track(0.25 + 1e-14), lo, hi);
        assert!((far.value - 0.5) > 8.0 * far.error, "{far:?}");
    }

    #[test]
    fn the_error_of_the_equation_over_the_slope() {
        let target = Bounded { value: 0.5, error: 1e-9 };
        let root = root_or_beyond(
            smoothstep::<Bounded<f64>>,
            target,
            Bounded::exact(0.0),
            Bounded::exact(1.0),
        );
        let slope = smoothstep(root.value).1;
        assert!((root.error * slope / 1e-9 - 1.0).abs() < 1e-3, "{root:?}");
    }

    #[test]
    fn an_end_that_is_rounded_beyond_a_pole() {
        let end = core::f32::consts::FRAC_PI_2;
        let tan = |t: f32| (t + t.tan(), 1.0 + t.cos().powi(-2));
        assert!(tan(end).0 < 0.0);
        let [first, last] =
            [[-end, end], [end, -end]].map(|[a, b]| before_pole(|t| tan(t).0, a, b));
        assert_eq!((first, last), (-end.next_down(), end.next_down()));
        // Nothing is beyond a pole in double precision, nor is an end without one.
        let end = core::f64::consts::FRAC_PI_2;
        assert_eq!(before_pole(f64::tan, end, 0.0), end);
        assert_eq!(before_pole(f64::exp, 1.0, 0.0), 1.0);
    }

    #[test]
    fn the_function_of_the_language() {
        let e = 0.999;
        let a = solve(|a| a - e * a.sin(), 0.0..TAU, 1e-6 * TAU);
        assert!((a - e * a.sin() - 1e-6 * TAU).abs() < 1e-17);
        let t = solve(|t| -t.exp(), ..=0.0, -0.25);
        assert!((t - 0.25f64.ln()).abs() < 1e-15);
    }
}
