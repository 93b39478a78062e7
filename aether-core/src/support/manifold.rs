//! Whether a point lies on the manifold of a map's images, by its image under a preimage.

use super::{SLACK, Tracking, lane, unit};
use crate::real::{Mask, Real, Single};

/// Whether two points are equal to within a few roundings: the common case of membership, decided
/// without error bounds.
#[inline(always)]
pub fn near<R: Real, const M: usize>(a: &[R; M], b: &[R; M]) -> R::Mask {
    let size = b.iter().fold(R::ZERO, |m, b| m.max(b.abs()));
    let tolerance = R::of(SLACK) * R::EPSILON * size;
    a.iter().zip(b).fold(R::Mask::TRUE, |m, (a, b)| m.and((*a - *b).abs().le(tolerance)))
}

/// Whether mapping `u` forward gives `x`, to within the error bounds of both.
pub fn leads_back<R: Single, const N: usize, const M: usize>(
    u: [R::Tracked; N],
    x: &[R; M],
    forward: Tracking<'_, R::Tracked, N, M>,
) -> bool {
    let (mut tried, mut unbounded) = (u, false);
    for t in &mut tried {
        // An undetermined uniform may have any value.
        if !t.ge(*t) {
            *t = R::Tracked::ZERO;
        }
        unbounded |= !R::value_and_error(*t).1.to_f64().is_finite();
    }
    if near_or_far::<R, M>(forward(&tried), x).0 {
        return true;
    }
    // So may one without a bound, as next to a corner: the one that it has, then. And next to the end of a uniform that
    // leads to infinity its bounds tell nothing of the image, but the number that it is may lead there.
    let leads = |rounding: R| {
        let numbers = tried.map(|t| {
            let number = unit(R::value_and_error(t).0);
            number.track_within(number * rounding)
        });
        near_or_far::<R, M>(forward(&numbers), x).0
    };
    unbounded && leads(R::EPSILON) || leads(R::ZERO)
}

/// How many times the tolerance of [`leads_back`] a point lies off where nobody need look closer.
const FAR: f64 = 1024.0;

/// Whether a point is its image to within the error bounds of that, and whether it is so far from it that no error
/// bounds explain it.
#[inline]
pub fn near_or_far<R: Single, const M: usize>(image: [R::Tracked; M], x: &[R; M]) -> (bool, bool) {
    let size = x.iter().fold(0.0, |m: f64, x| m.max(x.to_f64().abs()));
    let (mut near, mut far) = (true, false);
    for (y, x) in image.iter().zip(x) {
        let (value, error) = R::value_and_error(*y);
        let tolerance = SLACK * (error.to_f64() + size * R::EPSILON.to_f64());
        let off = (value.to_f64() - x.to_f64()).abs();
        // An unbounded error tells nothing about the point: that is no membership.
        near &= tolerance.is_finite() && off <= tolerance;
        far |= tolerance.is_finite() && off > FAR * tolerance;
    }
    (near, far)
}

/// Where `wanted` is true: whether the test of that lane's parameters and point succeeds.
#[inline(always)]
pub fn member<R: Real, const M: usize, const P: usize>(
    wanted: R::Mask,
    p: &[R; P],
    x: &[R; M],
    test: impl Fn(&[R::Lane; P], &[R::Lane; M]) -> bool,
) -> R::Mask {
    let mut found = R::Mask::FALSE;
    if wanted.any() {
        for i in (0..R::LANES).filter(|i| wanted.lane(*i)) {
            found = found.with_lane(i, test(&lane(p, i), &lane(x, i)));
        }
    }
    found
}

/// Where a test finds that a point lies on a manifold, and where that it plainly does not.
#[inline(always)]
pub fn on_or_off<R: Real, const M: usize, const P: usize>(
    p: &[R; P],
    x: &[R; M],
    test: impl Fn(&[R::Lane; P], &[R::Lane; M]) -> (bool, bool),
) -> [R::Mask; 2] {
    let mut found = [R::Mask::FALSE; 2];
    for i in 0..R::LANES {
        let (on, off) = test(&lane(p, i), &lane(x, i));
        found = [found[0].with_lane(i, on), found[1].with_lane(i, off)];
    }
    found
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The image on the unit circle of a point: the point over its length.
    fn lies(x: [f64; 2]) -> (bool, bool) {
        let [a, b] = x.map(f64::track);
        let length = (a * a + b * b).sqrt();
        near_or_far([a / length, b / length], &x)
    }

    #[test]
    fn points_on_and_off_a_circle() {
        let on = [0.6, 0.8];
        assert_eq!(lies(on), (true, false));
        assert_eq!(lies([on[0] * (1.0 + 4e-16), on[1]]), (true, false));
        assert_eq!(lies([on[0], on[1] + 1e-9]), (false, true));
        // Neither a few roundings nor many: other bounds decide.
        assert_eq!(lies([on[0], on[1] + 4e-14]), (false, false));
        assert_eq!(lies([f64::NAN, 1.0]), (false, false));
        assert_eq!(lies([0.0, 0.0]), (false, false));
    }

    #[test]
    fn uniforms_whose_bounds_tell_nothing_are_tried_as_they_are() {
        // The last uniform before one, which leads far away, and one that is undetermined.
        let last = 1.0 - 0.5 * f64::EPSILON;
        let far = |u: &[<f64 as Single>::Tracked; 2]| {
            let one = <f64 as Single>::Tracked::ONE;
            [one / (one - u[0]), u[1]]
        };
        let x = [1.0 / (1.0 - last), 0.0];
        let [near, zero] = [last, 0.0].map(f64::track);
        let rounded = near + f64::track(0.5) * f64::track(f64::EPSILON);
        let unknown = zero / zero;
        assert!(leads_back::<f64, 2, 2>([rounded, unknown], &x, &far));
        assert!(!leads_back::<f64, 2, 2>([rounded, unknown], &[0.5 * x[0], 0.0], &far));
    }

    #[test]
    fn roundings_count_relative_to_the_whole_point() {
        assert!(near::<f64, 2>(&[1.0, 1e-16], &[1.0, 0.0]));
        assert!(!near::<f64, 2>(&[1.0, 1e-14], &[1.0, 0.0]));
        assert!(!near::<f64, 2>(&[f64::NAN, 0.0], &[1.0, 0.0]));
    }
}
