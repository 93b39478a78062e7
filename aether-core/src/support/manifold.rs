//! Whether a point lies on the manifold of a map's images, by its image under a preimage.

use super::{SLACK, Tracking, lane, limits, unit};
use crate::real::{Mask, Real, Single};

/// The larger one of a number and another, which may be none: a single comparison.
#[inline(always)]
fn larger<R: Real>(number: R, other: R) -> R {
    R::select(other.gt(number), other, number)
}

/// The size of the largest coordinate; those that are no numbers have none.
#[inline(always)]
fn largest<R: Real, const M: usize>(x: &[R; M]) -> R {
    x.iter().fold(R::ZERO, |m, x| larger(m, x.abs()))
}

/// Whether two points are equal to within a few roundings: the common case of membership, decided
/// without error bounds. Nothing is near to what is not finite.
#[inline(always)]
pub fn near<R: Real, const M: usize>(a: &[R; M], b: &[R; M]) -> R::Mask {
    let size = largest(b);
    // Next to what is infinite all that is finite would be near.
    let tolerance = (R::of(SLACK) * R::EPSILON * size).min(R::EPSILON / R::MIN_POSITIVE);
    a.iter().zip(b).fold(R::Mask::TRUE, |m, (a, b)| m.and((*a - *b).abs().le(tolerance)))
}

/// The same of a point and its multiple by a factor.
#[inline(always)]
pub fn near_one<R: Real>(factor: R) -> R::Mask {
    (factor - R::ONE).abs().le(R::of(SLACK) * R::EPSILON)
}

/// Whether the image of a point is the point to within a few roundings, and whether it is plainly another one, where the
/// image is a multiple: it has the point's offsets from somewhere times √(above / below), and else its coordinates. `sums`
/// are above - below, below, and the sizes of all terms of both, which are even powers of differences of two numbers.
///
/// With s the factor, |s - 1| = |s² - 1| / (s + 1), and s + 1 is at least the smaller one of 2 and 1 + s². Rounding of
/// the point and of the differences changes the offsets times the excess by a few units of the sizes times the largest
/// number among coordinates and offsets; a point is called far where they are many times that.
#[inline(always)]
pub fn near_or_far_multiple<R: Real, const M: usize, const C: usize>(
    x: &[R; M],
    offsets: [R; C],
    sums: [R; 3],
) -> [R::Mask; 2] {
    let [excess, below, sizes] = sums;
    let (size, offset) = (largest(x), largest(&offsets));
    let off = offset * excess.abs();
    // What underflows would be no small part of sums that are as small as this.
    let least = R::MIN_POSITIVE / (R::EPSILON * R::EPSILON);
    let unit = R::of(SLACK) * R::EPSILON;
    let near = off.le(unit * size * (below + below + excess.min(R::ZERO)));
    let far = off.gt(R::of(FAR * SLACK) * unit * larger(size, offset) * sizes);
    [near.and(below.gt(least)), far.and(sizes.gt(least))]
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
    let forward = |t: &[R::Tracked; N]| from_inside::<R, N, M>(t, forward);
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

/// The image of uniforms; where it is 0/0, its limit from inside, as samples have it.
fn from_inside<R: Single, const N: usize, const M: usize>(
    u: &[R::Tracked; N],
    forward: Tracking<'_, R::Tracked, N, M>,
) -> [R::Tracked; M] {
    let image = forward(u);
    if image.iter().all(|y| y.ge(*y)) {
        return image;
    }
    limits::from_inside(&[], u, image, &|_, u| forward(u))
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

    /// Whether a point lies on a sphere, by its height.
    fn on_sphere(centre: [f32; 3], radius: f32, x: [f32; 3]) -> [bool; 2] {
        let [a, b, c] = [0, 1, 2].map(|i| x[i] - centre[i]);
        let (below, above) = (a * a + b * b, radius * radius - c * c);
        near_or_far_multiple(&x, [a, b], [above - below, below, radius * radius + c * c + below])
    }

    #[test]
    fn points_on_and_off_a_sphere_of_any_size() {
        let [on, off, neither] = [[true, false], [false, true], [false, false]];
        let point = |far: f32, size: f32| [0.48, 0.64, 0.6].map(|x: f32| far + size * x);
        for size in [1e-11, 1.0, 1e11] {
            let origin = [0.0; 3];
            assert_eq!(on_sphere(origin, size, point(0.0, size)), on);
            assert_eq!(on_sphere(origin, size, point(0.0, 1.1 * size)), off);
            // More than roundings, but less than nobody need look at closer.
            assert_eq!(on_sphere(origin, size, point(0.0, 1.0001 * size)), neither);
        }
        // What is measured from far away is known as well as coordinates are.
        assert_eq!(on_sphere([1e4; 3], 1.0, point(1e4, 1.0)), on);
        assert_eq!(on_sphere([1e4; 3], 1.0, point(1e4, 1.01)), neither);
        assert_eq!(on_sphere([1e4; 3], 1e3, point(1e4, 1.2e3)), off);
    }

    #[test]
    fn where_squares_leave_the_range_of_numbers_a_sphere_is_left_to_error_bounds() {
        for size in [1e-22, 1e-20, 1e20, f32::INFINITY, f32::NAN] {
            for scale in [1.0, 2.0] {
                let x = [0.48, 0.64, 0.6].map(|x: f32| scale * size * x);
                assert_eq!(on_sphere([0.0; 3], size, x), [false; 2], "{size}");
            }
        }
        // So is a pole, where the offset has no direction.
        assert_eq!(on_sphere([0.0; 3], 1.0, [0.0, 0.0, 1.0]), [false; 2]);
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
    fn what_is_no_number_has_no_size() {
        assert_eq!(largest(&[f64::NAN, -2.0, 1.0]), 2.0);
        assert_eq!(largest(&[1.0, -f64::INFINITY, f64::NAN]), f64::INFINITY);
        assert_eq!(larger(3.0, f64::NAN), 3.0);
    }

    #[test]
    fn roundings_count_relative_to_the_whole_point() {
        assert!(near::<f64, 2>(&[1.0, 1e-16], &[1.0, 0.0]));
        assert!(!near::<f64, 2>(&[1.0, 1e-14], &[1.0, 0.0]));
        assert!(!near::<f64, 2>(&[f64::NAN, 0.0], &[1.0, 0.0]));
    }
}
