//! Elementary functions in double precision, against 31 digits.

use core::f64::consts::FRAC_PI_2;

use super::*;

/// The error of `found` in units in the last place of the exact value, and in `f64::EPSILON` of it, which is what running
/// error bounds allow for.
fn errors(found: f64, exact: Precise) -> [f64; 2] {
    let size = exact.to_f64().abs();
    let error = (Precise::f64(found) - exact).to_f64().abs();
    [error / (size.next_up() - size), error / (size * f64::EPSILON)]
}

/// Numbers that fill [-1, 1], some of them small.
fn numbers() -> impl Iterator<Item = f64> {
    (0..60_000).flat_map(|i| {
        let even = (f64::from(i) * 0.618_033_988_749_894_9).fract() * 2.0 - 1.0;
        [even, even * (-f64::from(i % 80)).exp()]
    })
}

/// The largest errors of a function at some arguments.
fn worst(
    arguments: impl Iterator<Item = f64>,
    function: fn(f64) -> f64,
    exact: fn(Precise) -> Precise,
) -> [f64; 2] {
    arguments.fold([0.0f64; 2], |worst, x| {
        let errors = errors(function(x), exact(Precise::f64(x)));
        [worst[0].max(errors[0]), worst[1].max(errors[1])]
    })
}

#[test]
fn functions_in_double_precision() {
    let angles = || {
        numbers().flat_map(|x| {
            // Anywhere, in the first turns, and next to the quarters of turns.
            let quarters = (20.0 * x).round() * FRAC_PI_2;
            [x, 7.0 * x, 2900.0 * x, quarters + x * x * x * 1e-6, quarters * (1.0 + 1e-15 * x)]
        })
    };
    // Slopes on both sides of those where the reduction changes.
    let slopes = || numbers().flat_map(|x| [x, 1.0 / x]).filter(|x| x.is_finite());
    let found = [
        worst(angles(), Real::sin, Real::sin),
        worst(angles(), Real::cos, Real::cos),
        worst(
            slopes(),
            |x| Real::atan2(0.7 * x, 0.7),
            |x| (Precise::f64(0.7 * x.to_f64())).atan2(Precise::f64(0.7)),
        ),
        worst(
            slopes(),
            |x| Real::atan2(0.7 * x, -0.7),
            |x| (Precise::f64(0.7 * x.to_f64())).atan2(Precise::f64(-0.7)),
        ),
    ];
    println!("{found:?}");
    for (ulps, [most, relative]) in [0.8, 0.8, 1.6, 1.6].into_iter().zip(found) {
        assert!(most < ulps && relative < 1.0, "{found:?}");
    }
}

/// What is rare goes to the host; zeros keep their signs.
#[test]
fn functions_in_double_precision_at_the_ends() {
    let functions: [(fn(f64) -> f64, fn(f64) -> f64); 4] = [
        (Real::sin, f64::sin),
        (Real::cos, f64::cos),
        (|x| Real::atan2(x, 1.0), |x| x.atan2(1.0)),
        (|x| Real::atan2(-1.0, x), |x| f64::atan2(-1.0, x)),
    ];
    let ends = [0.0, f64::MIN_POSITIVE, 1e-310, 5e-324, 3000.0, 1e10, 708.0, 1e300];
    let ends = ends.into_iter().chain([f64::MAX, f64::INFINITY, f64::NAN]);
    for x in ends.flat_map(|x| [x, -x]) {
        for (k, (function, host)) in functions.into_iter().enumerate() {
            let (found, known) = (function(x), host(x));
            assert!(
                found.to_bits() == known.to_bits() || found.is_nan() && known.is_nan(),
                "{k}: {x}"
            );
        }
    }
    let numbers = [0.0, 1e-320, 1e-305, 1.0, 1e305, f64::INFINITY, f64::NAN];
    let numbers = || numbers.into_iter().flat_map(|x| [x, -x]);
    for (y, x) in numbers().flat_map(|y| numbers().map(move |x| (y, x))) {
        let (found, known) = (Real::atan2(y, x), f64::atan2(y, x));
        assert!(found.to_bits() == known.to_bits() || found.is_nan() && known.is_nan(), "{y}, {x}");
    }
}

#[test]
fn fractions_of_a_turn_in_double_precision() {
    let mut worst = [0.0f64; 2];
    for i in 0..200_000 {
        // All eighths of a turn, angles next to their ends, and small ones.
        let even = (f64::from(i) * 0.618_033_988_749_894_9).fract() * 4.0 - 2.0;
        let small = even * (-f64::from(i % 600)).exp();
        let near = f64::from(i % 17) / 4.0 - 2.0 + small * 1e-3;
        for x in [even, small, near] {
            let (found, exact) = (x.sin_cos_pi(), Precise::f64(x).sin_cos_pi());
            for (worst, (y, z)) in worst.iter_mut().zip([(found.0, exact.0), (found.1, exact.1)]) {
                *worst = worst.max(errors(y, z)[0]);
            }
        }
    }
    println!("{worst:?} units in the last place");
    assert!(worst[0] < 1.7 && worst[1] < 1.7, "{worst:?}");
}

#[test]
fn fractions_of_a_turn_at_the_ends_of_doubles() {
    for k in -9_i32..9 {
        let x = f64::from(k) / 2.0;
        let (sin, cos) = x.sin_cos_pi();
        let (sine, cosine) =
            [(0.0, 1.0), (1.0, 0.0), (0.0, -1.0), (-1.0, 0.0)][k.rem_euclid(4) as usize];
        assert!(sin == sine && cos == cosine, "{x}: {sin}, {cos}");
    }
    // Odd, even, and with a half, where sums with these are rounded.
    let large = 2f64.powi(50);
    assert_eq!((large + 1.0).sin_cos_pi().1, -1.0);
    assert_eq!((2.0 * large).sin_cos_pi().1, 1.0);
    assert_eq!((large + 0.5).sin_pi(), 1.0);
    assert_eq!((-f64::MAX).cos_pi(), 1.0);
    for x in [f64::INFINITY, f64::NEG_INFINITY, f64::NAN] {
        assert!(x.sin_pi().is_nan() && x.cos_pi().is_nan());
    }
    assert!(
        (-0.0f64).sin_pi().is_sign_negative() && f64::MIN_POSITIVE.sin_pi() > f64::MIN_POSITIVE
    );
}
