//! The functions of lanes on sweeps over all numbers, against double precision.

use aether_core::{Lanes, Real};

/// One number in this many is tried; a prime, so that mantissas of all kinds occur.
const STRIDE: usize = 1021;

/// Numbers of all sizes and signs, the special ones included.
fn sweep() -> impl Iterator<Item = f32> {
    let special = [0.0, 1.0, 0.5, 2.0, f32::MAX, f32::MIN_POSITIVE, f32::INFINITY, f32::NAN];
    let special = special.into_iter().flat_map(|x: f32| {
        [x, -x, x.next_up(), x.next_down(), -x.next_up(), -x.next_down(), x * 3.0, x / 7.0]
    });
    special.chain((0..=u32::MAX).step_by(STRIDE).map(f32::from_bits))
}

/// Distance from the exact value in units of the last place there.
fn ulps(found: f32, exact: f64) -> f64 {
    let rounded = exact as f32;
    if found == rounded || found.is_nan() && exact.is_nan() {
        let same_sign = found.is_nan() || found.is_sign_negative() == exact.is_sign_negative();
        if !same_sign {
            return f64::INFINITY;
        }
        if !rounded.is_normal() {
            return 0.0;
        }
    }
    let ulp = f64::from(rounded.abs().max(f32::MIN_POSITIVE).next_up())
        - f64::from(rounded.abs().max(f32::MIN_POSITIVE));
    let ulp = if ulp.is_finite() { ulp } else { 2.0f64.powi(104) };
    let error = (f64::from(found) - exact).abs() / ulp;
    if error.is_nan() { f64::INFINITY } else { error }
}

/// Error of a result that is rounded once, from a kernel that is off by 2^-35.
const BOUND: f64 = 0.502;

fn assert_close(name: &str, f: fn(Lanes) -> Lanes, exact: fn(f64) -> f64) {
    let (mut worst, mut at) = (0.0, (0.0, 0.0));
    let numbers: Vec<f32> = sweep().collect();
    for x in numbers.as_chunks::<8>().0 {
        for (x, y) in x.iter().zip(f(Lanes::new(*x)).to_array()) {
            let error = ulps(y, exact(f64::from(*x)));
            if error > worst {
                (worst, at) = (error, (*x, y));
            }
        }
    }
    println!("{name}: {worst:.4} ulp at {at:?}");
    assert!(worst <= BOUND, "{name}({:e}) is {:e}: {worst} ulp", at.0, at.1);
}

macro_rules! functions {
    ($($name:ident $exact:path;)*) => {
        $(#[test]
        fn $name() {
            assert_close(stringify!($name), <Lanes as Real>::$name, $exact);
        })*
    };
}

functions! {
    exp libm::exp;
    exp_m1 libm::expm1;
    ln libm::log;
    ln_1p libm::log1p;
    cbrt libm::cbrt;
    sin libm::sin;
    cos libm::cos;
    tan libm::tan;
    asin libm::asin;
    acos libm::acos;
    atan libm::atan;
    sinh libm::sinh;
    cosh libm::cosh;
    tanh libm::tanh;
    asinh libm::asinh;
    acosh acosh_or_nan;
    atanh libm::atanh;
}

#[test]
fn fractions_of_a_turn() {
    // Reduced to an eighth of a turn without rounding, in double precision.
    let quarters = |x: f64, quarter: f64| {
        let x = x % 2.0;
        let n = (2.0 * x).round();
        let angle = core::f64::consts::PI * (x - 0.5 * n);
        match (n + quarter).rem_euclid(4.0) {
            0.0 => libm::sin(angle),
            1.0 => libm::cos(angle),
            2.0 => -libm::sin(angle),
            3.0 => -libm::cos(angle),
            _ => f64::NAN,
        }
    };
    for (quarter, function) in
        [(0.0, <Lanes as Real>::sin_pi as fn(Lanes) -> Lanes), (1.0, Lanes::cos_pi)]
    {
        for eight in sweep().collect::<Vec<f32>>().as_chunks::<8>().0 {
            for (x, y) in eight.iter().zip(function(Lanes::new(*eight)).to_array()) {
                let exact = quarters(f64::from(*x), quarter);
                // The sign of zero is that of the side that rounding would have to come from.
                let error = if exact == 0.0 { f64::from(y) } else { ulps(y, exact) };
                assert!(error <= BOUND, "{x:e} at {quarter}: {y:e}, {exact:e}: {error} ulp");
                // A single number has the bits of a lane.
                let (sine, cosine) = x.sin_cos_pi();
                let one = if quarter == 0.0 { sine } else { cosine };
                assert!(one.to_bits() == y.to_bits() || one.is_nan() && y.is_nan(), "{x:e}");
            }
        }
    }
}

/// That of the crate `libm` is some number below one.
fn acosh_or_nan(x: f64) -> f64 {
    if x < 1.0 { f64::NAN } else { libm::acosh(x) }
}

/// Pairs of numbers of all sizes, and those of similar size.
fn pairs() -> Vec<(f32, f32)> {
    let special: Vec<f32> = sweep().take(64).collect();
    let all = special.iter().flat_map(|x| special.iter().map(|y| (*x, *y)));
    let mut state = 1u64;
    let mut next = || {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963);
        (state >> 32) as u32
    };
    let random = (0..2_000_000).map(|i| {
        let (x, y) = (f32::from_bits(next()), next());
        let near = f32::from_bits(x.to_bits() & 0xFF80_0000 | y >> 9);
        (x, if i % 2 == 0 { f32::from_bits(y) } else { near })
    });
    all.chain(random).collect()
}

/// Eight pairs as a pair of lanes.
fn lanes(pairs: &[(f32, f32); 8]) -> (Lanes, Lanes) {
    (Lanes::new(pairs.map(|p| p.0)), Lanes::new(pairs.map(|p| p.1)))
}

fn assert_close_2(
    name: &str,
    f: fn(Lanes, Lanes) -> Lanes,
    exact: fn(f64, f64) -> f64,
    second: fn(f32) -> f32,
) {
    let (mut worst, mut at) = (0.0, (0.0, 0.0, 0.0));
    let pairs: Vec<(f32, f32)> = pairs().into_iter().map(|(x, y)| (x, second(y))).collect();
    for eight in pairs.as_chunks::<8>().0 {
        let (x, y) = lanes(eight);
        for ((x, y), found) in eight.iter().zip(f(x, y).to_array()) {
            let error = ulps(found, exact(f64::from(*x), f64::from(*y)));
            if error > worst {
                (worst, at) = (error, (*x, *y, found));
            }
        }
    }
    println!("{name}: {worst:.4} ulp at {at:?}");
    assert!(worst <= BOUND, "{name}: {worst} ulp at {at:?}");
}

#[test]
fn of_two_numbers() {
    assert_close_2("atan2", Real::atan2, libm::atan2, |x| x);
    assert_close_2("hypot", Real::hypot, libm::hypot, |x| x);
    assert_close_2("powf", Real::powf, libm::pow, |x| x);
    // Exponents for which powers are not all zero or infinite.
    assert_close_2("powf", Real::powf, libm::pow, |x| (x.abs() + 1.0).log2().copysign(x));
    assert_close_2("powf", Real::powf, libm::pow, |x| x.abs().log2().round() * 0.5);
}

/// Equal to the bit, or both NaN; zeros may differ in sign where IEEE 754 leaves it open.
fn same(a: f32, b: f32, zeros: bool) -> bool {
    a.to_bits() == b.to_bits() || a.is_nan() && b.is_nan() || zeros && a == 0.0 && b == 0.0
}

/// Arithmetic, comparisons and what else is exact or rounded once: those of `f32`, to the bit.
#[test]
fn arithmetic_is_that_of_the_scalar() {
    type Two<R> = fn(R, R) -> R;
    let functions: [(Two<Lanes>, Two<f32>, bool); 13] = [
        (|x, y| x + y, |x, y| x + y, false),
        (|x, y| x - y, |x, y| x - y, false),
        (|x, y| x * y, |x, y| x * y, false),
        (|x, y| x / y, |x, y| x / y, false),
        (|x, _| -x, |x, _| -x, false),
        (|x, _| x.sqrt(), |x, _| x.sqrt(), false),
        (|x, _| x.floor(), |x, _| x.floor(), false),
        (|x, _| Real::abs(x), |x, _| x.abs(), false),
        (|x, y| x.copysign(y), |x, y| x.copysign(y), false),
        (|x, y| x.min(y), |x, y| x.min(y), true),
        (|x, y| x.max(y), |x, y| x.max(y), true),
        (|x, _| x.powi(5), |x, _| x * ((x * x) * (x * x)), false),
        (|x, _| x.powi(-3), |x, _| 1.0 / (x * (x * x)), false),
    ];
    for (k, (wide, scalar, zeros)) in functions.into_iter().enumerate() {
        for eight in pairs().as_chunks::<8>().0 {
            let (x, y) = lanes(eight);
            for ((x, y), found) in eight.iter().zip(wide(x, y).to_array()) {
                let expected = scalar(*x, *y);
                assert!(same(found, expected, zeros), "{k}: {x:e}, {y:e}: {found:e}, {expected:e}");
            }
        }
    }
}

#[test]
fn comparisons_are_those_of_the_scalar() {
    for eight in pairs().as_chunks::<8>().0 {
        let (x, y) = lanes(eight);
        let each = |f: fn(f32, f32) -> bool| eight.map(|(x, y)| f(x, y));
        assert_eq!(x.lt(y).to_array(), each(|x, y| x < y));
        assert_eq!(x.le(y).to_array(), each(|x, y| x <= y));
        assert_eq!(Real::gt(x, y).to_array(), each(|x, y| x > y));
        assert_eq!(Real::ge(x, y).to_array(), each(|x, y| x >= y));
        assert_eq!(Real::finite(x).to_array(), each(|x, _| x.is_finite()));
        let smaller = Lanes::select(x.lt(y), x, y).to_array();
        assert_eq!(
            smaller.map(f32::to_bits),
            eight.map(|(x, y)| if x < y { x } else { y }.to_bits())
        );
    }
}
