//! Elementary functions of `f32` on sweeps over all numbers, against double precision.

use aether_core::Real;

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

fn assert_close(name: &str, f: fn(f32) -> f32, exact: fn(f64) -> f64) {
    let (mut worst, mut at) = (0.0, 0.0);
    for x in sweep() {
        let error = ulps(f(x), exact(f64::from(x)));
        if error > worst {
            (worst, at) = (error, x);
        }
    }
    println!("{name}: {worst:.4} ulp at {at:e}");
    assert!(worst <= BOUND, "{name}({at:e}) is {:e}: {worst} ulp", f(at));
}

macro_rules! functions {
    ($($name:ident $exact:path;)*) => {
        $(#[test]
        fn $name() {
            assert_close(stringify!($name), <f32 as Real>::$name, $exact);
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

/// That of the crate `libm` is some number below one.
fn acosh_or_nan(x: f64) -> f64 {
    if x < 1.0 { f64::NAN } else { libm::acosh(x) }
}

/// Pairs of numbers of all sizes, and those of similar size.
fn pairs() -> impl Iterator<Item = (f32, f32)> {
    let special: Vec<f32> = sweep().take(64).collect();
    let all = special
        .clone()
        .into_iter()
        .flat_map(move |x| special.clone().into_iter().map(move |y| (x, y)));
    let mut state = 1u64;
    let mut next = move || {
        state =
            state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (state >> 32) as u32
    };
    let random = (0..2_000_000).map(move |i| {
        let (x, y) = (f32::from_bits(next()), next());
        let near = f32::from_bits(x.to_bits() & 0xFF80_0000 | y >> 9);
        (x, if i % 2 == 0 { f32::from_bits(y) } else { near })
    });
    all.chain(random)
}

fn assert_close_2(
    name: &str,
    f: fn(f32, f32) -> f32,
    exact: fn(f64, f64) -> f64,
    map: fn(f32) -> f32,
) {
    let (mut worst, mut at) = (0.0, (0.0, 0.0));
    for (x, y) in pairs() {
        let y = map(y);
        let error = ulps(f(x, y), exact(f64::from(x), f64::from(y)));
        if error > worst {
            (worst, at) = (error, (x, y));
        }
    }
    println!("{name}: {worst:.4} ulp at {at:?}");
    assert!(worst <= BOUND, "{name}{at:?} is {:e}: {worst} ulp", f(at.0, at.1));
}

#[test]
fn of_two_numbers() {
    assert_close_2("atan2", <f32 as Real>::atan2, libm::atan2, |x| x);
    assert_close_2("hypot", <f32 as Real>::hypot, libm::hypot, |x| x);
    assert_close_2("powf", <f32 as Real>::powf, libm::pow, |x| x);
    // Exponents for which powers are not all zero or infinite.
    assert_close_2("powf", <f32 as Real>::powf, libm::pow, |x| (x.abs() + 1.0).log2().copysign(x));
    assert_close_2("powf", <f32 as Real>::powf, libm::pow, |x| x.abs().log2().round() * 0.5);
}

#[test]
fn whole_powers() {
    for x in sweep().step_by(16) {
        for n in [-7, -2, -1, 0, 1, 2, 3, 5, 8, 13] {
            let exact = f64::from(x).powi(n);
            let y = x.powi(n);
            let tiny = exact.abs() < 1e-30 || exact.abs() > 1e30;
            // Each multiplication rounds.
            assert!(
                tiny || ulps(y, exact) <= 13.0 || y.is_nan() && x.is_nan(),
                "{x:e}^{n} is {y:e}"
            );
            assert_eq!(Real::powi(x, n).is_nan(), x.is_nan() && n != 0);
        }
    }
}
