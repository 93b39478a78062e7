//! Double-doubles against a table of high precision, identities and special values.

use super::Dd;
use super::constants::{HALF_PI_PARTS, LN_2};
use crate::number::Number;

/// Lines of `function x.hi x.lo y.hi y.lo value.hi value.lo`.
const REFERENCE: &str = include_str!("reference.txt");

/// The largest relative error allowed in the table.
const TOLERANCE: f64 = 1e-30;

const INF: f64 = f64::INFINITY;

type Unary = fn(Dd) -> Dd;
type Binary = fn(Dd, Dd) -> Dd;

const UNARY: [(&str, Unary); 18] = [
    ("sqrt", Dd::sqrt),
    ("cbrt", Dd::cbrt),
    ("exp", Dd::exp),
    ("exp_m1", Dd::exp_m1),
    ("ln", Dd::ln),
    ("ln_1p", Dd::ln_1p),
    ("sin", Dd::sin),
    ("cos", Dd::cos),
    ("tan", Dd::tan),
    ("asin", Dd::asin),
    ("acos", Dd::acos),
    ("atan", Dd::atan),
    ("sinh", Dd::sinh),
    ("cosh", Dd::cosh),
    ("tanh", Dd::tanh),
    ("asinh", Dd::asinh),
    ("acosh", Dd::acosh),
    ("atanh", Dd::atanh),
];

const BINARY: [(&str, Binary); 6] = [
    ("add", |x, y| x + y),
    ("mul", |x, y| x * y),
    ("div", |x, y| x / y),
    ("atan2", Dd::atan2),
    ("hypot", Dd::hypot),
    ("powf", Dd::powf),
];

/// The functions of `special.rs`, which lose a few digits more than the elementary ones.
const SPECIAL: [(&str, Unary); 8] = [
    ("erf", Dd::erf),
    ("erfc", Dd::erfc),
    ("erf_inv", Dd::erf_inv),
    ("erfc_inv", Dd::erfc_inv),
    ("ln_erfc", Dd::ln_erfc),
    ("erfc_inv_exp", Dd::erfc_inv_exp),
    ("lambert_w", Dd::lambert_w),
    ("ln_gamma", Dd::ln_gamma),
];

fn relative_error(value: Dd, expected: Dd) -> f64 {
    ((value - expected) / expected).abs().to_f64()
}

#[track_caller]
fn assert_close(value: Dd, expected: Dd) {
    let error = relative_error(value, expected);
    assert!(error < TOLERANCE, "{value:?} instead of {expected:?}, relative error {error:e}");
}

#[track_caller]
fn assert_is(value: Dd, expected: f64) {
    assert_eq!(value.parts(), (expected, 0.0));
}

fn dd(value: f64) -> Dd {
    Dd::from_f64(value)
}

#[test]
fn agrees_with_the_reference_table() {
    let mut seen = std::collections::BTreeSet::new();
    for line in REFERENCE.lines().filter(|line| !line.starts_with('#')) {
        let (name, numbers) = line.split_once(' ').unwrap();
        let n: Vec<f64> = numbers.split(' ').map(|n| n.parse().unwrap()).collect();
        let [x, y, expected] = [0, 2, 4].map(|i| Dd::sum(n[i], n[i + 1]));
        let unary = UNARY.iter().find(|f| f.0 == name).map(|f| f.1(x));
        let binary = || BINARY.iter().find(|f| f.0 == name).map(|f| f.1(x, y));
        let value = unary.or_else(binary).unwrap();
        let error = relative_error(value, expected);
        assert!(error < TOLERANCE, "{line}: got {value:?}, relative error {error:e}");
        seen.insert(name);
    }
    assert_eq!(seen.len(), UNARY.len() + BINARY.len());
}

#[test]
fn special_functions_agree_with_their_table() {
    let mut seen = std::collections::BTreeSet::new();
    for line in include_str!("special.txt").lines().filter(|line| !line.starts_with('#')) {
        let (name, numbers) = line.split_once(' ').unwrap();
        let n: Vec<f64> = numbers.split(' ').map(|n| n.parse().unwrap()).collect();
        let [x, expected] = [0, 4].map(|i| Dd::sum(n[i], n[i + 1]));
        let value = SPECIAL.iter().find(|f| f.0 == name).map(|f| f.1(x)).unwrap();
        let error = relative_error(value, expected);
        assert!(error < 1e-28, "{line}: got {value:?}, relative error {error:e}");
        seen.insert(name);
    }
    assert_eq!(seen.len(), SPECIAL.len());
}

/// Values of mpmath with 50 digits.
#[test]
fn beta_functions() {
    type Ternary = fn(Dd, Dd, Dd) -> Dd;
    let inc: Ternary = |x, a, b| x.beta_inc(Dd::ONE - x, a, b);
    let inv: Ternary = |p, a, b| p.beta_inc_inv(Dd::ONE - p, a, b);
    let table: [(Ternary, [f64; 3], (f64, f64)); 8] = [
        (inc, [0.125, 1.75, 0.5], (0.010890495185932965, -5.441564451509103e-19)),
        (inc, [0.0009765625, 0.25, 40.0], (0.4856375471878509, 1.3469206109682767e-17)),
        (inc, [0.96875, 40.0, 0.5], (0.11211777942583113, -7.675348023875562e-19)),
        (inc, [0.9990234375, 500.0, 0.5], (0.32305172282851696, -1.1131410539159902e-18)),
        (inv, [9.094947017729282e-13, 1.75, 0.5], (2.2299811612899551e-07, 1.107365788729668e-23)),
        (inv, [0.25, 0.5, 0.25], (0.3497262249233497, -2.0638934186337867e-17)),
        (inv, [0.75, 25.0, 0.5], (0.9979510778549066, -2.8305409343155866e-17)),
        (inv, [0.5, 3.0, 2.5], (0.551334680913763, 5.4511342982839884e-17)),
    ];
    for (f, [x, a, b], (hi, lo)) in table {
        let error = relative_error(f(dd(x), dd(a), dd(b)), Dd::sum(hi, lo));
        assert!(error < 1e-28, "{x} {a} {b}: {error:e}");
    }
    let expected = Dd::sum(-2.5346891063280625, 1.4576678168577982e-16);
    assert!(relative_error(dd(500.0).ln_beta(dd(0.5)), expected) < 1e-28);
    for f in [inc, inv] {
        assert_is(f(dd(0.0), dd(2.0), dd(3.0)), 0.0);
        assert_is(f(dd(1.0), dd(2.0), dd(3.0)), 1.0);
        assert!(f(dd(1.5), dd(2.0), dd(3.0)).is_nan() && f(dd(0.5), dd(0.0), dd(3.0)).is_nan());
    }
    // Too small for a number.
    assert_is(inv(dd(1e-300), dd(0.25), dd(1.0)), 0.0);
}

#[test]
fn special_functions_at_the_ends_of_their_domains() {
    assert_is(dd(1.0).erf_inv(), INF);
    assert_is(dd(0.0).erfc_inv(), INF);
    assert_is(dd(2.0).erfc_inv(), -INF);
    assert_is(dd(INF).erf(), 1.0);
    assert_is(dd(-INF).erfc(), 2.0);
    assert_is(dd(INF).lambert_w(), INF);
    for x in [dd(1.5).erf_inv(), dd(2.5).erfc_inv(), dd(-0.5).erfc_inv(), dd(-0.4).lambert_w()] {
        assert!(x.is_nan());
    }
}

#[test]
fn f64_agrees_with_double_double() {
    // Worst libm errors are a few units in the last place.
    for (x, y) in [(0.7, 0.3), (1.25e-3, 2.0), (0.99, -1.5)] {
        let one: [(f64, Dd); 6] = [
            (Number::sin(x), dd(x).sin()),
            (Number::acos(x), dd(x).acos()),
            (Number::exp_m1(x), dd(x).exp_m1()),
            (Number::atanh(x), dd(x).atanh()),
            (Number::powf(x, y), dd(x).powf(dd(y))),
            (Number::atan2(x, y), dd(x).atan2(dd(y))),
        ];
        for (value, truth) in one {
            assert!(relative_error(dd(value), truth) < 1e-15, "{value} {truth:?}");
        }
    }
    assert_eq!(<f64 as Number>::from_ratio(1, 3), 1.0 / 3.0);
    assert_eq!(Number::powi(2.0, -3), 0.125);
}

#[test]
fn ratios_undo_products() {
    for (n, d) in [(1, 3), (-22, 7), (10i128.pow(30) + 7, 3i128.pow(70))] {
        assert_close(Dd::from_ratio(n, d) * Dd::from_ratio(d, 1), Dd::from_ratio(n, 1));
    }
    assert_is(Dd::from_ratio(1, 0), INF);
}

#[test]
fn identities() {
    for i in -40..=40 {
        let x = Dd::from_ratio(i, 7) + Dd::from_ratio(1, 1000);
        let (s, c) = (x.sin(), x.cos());
        assert_close(s * s + c * c, Dd::ONE);
        assert_close(x.tan() * c, s);
        assert_close(x.abs().exp_m1().ln_1p(), x.abs());
        assert_close(x.sinh().asinh(), x);
        assert_close(x.cbrt().powi(3), x);
        assert_close(x.exp() * (-x).exp(), Dd::ONE);
        // Without cancellation for positive arguments only.
        assert_close(x.abs().cosh() + x.abs().sinh(), x.abs().exp());
        assert_close(x.atan().tan(), x);
        assert_close(x.exp().powf(Dd::from_ratio(1, 3)).powi(3), x.exp());
    }
}

#[test]
fn all_quadrants() {
    for eighth in -7..=7 {
        let angle = Dd::pi() * Dd::from_ratio(eighth, 8) + Dd::from_ratio(1, 100);
        let radius = Dd::from_ratio(5, 3);
        let (x, y) = (radius * angle.cos(), radius * angle.sin());
        assert_close(y.atan2(x), angle);
        assert_close(y.hypot(x), radius);
    }
    let half_pi = Dd::pi() / dd(2.0);
    let quarter = Dd::pi() / dd(4.0);
    let axes = [
        ((0.0, 0.0), Dd::ZERO),
        ((0.0, 2.0), Dd::ZERO),
        ((0.0, -2.0), Dd::pi()),
        ((3.0, 0.0), half_pi),
        ((-3.0, 0.0), -half_pi),
        ((1.0, INF), Dd::ZERO),
        ((1.0, -INF), Dd::pi()),
        ((-INF, 1.0), -half_pi),
        ((INF, INF), quarter),
        ((-INF, -INF), -quarter * dd(3.0)),
    ];
    for ((y, x), angle) in axes {
        assert_eq!(dd(y).atan2(dd(x)), angle, "atan2({y}, {x})");
    }
}

#[test]
fn zeros_of_sine_and_cosine() {
    // The value next to a zero is what the argument misses it by: the third part of π/2.
    let half_pi = Dd::pi() / dd(2.0);
    let third = dd(HALF_PI_PARTS[2]);
    assert!(relative_error(half_pi.cos(), third) < 1e-15);
    assert!(relative_error(Dd::pi().sin(), third * dd(2.0)) < 1e-15);
    // Huge arguments have few correct digits, but are still sines.
    let (s, c) = (dd(1e300).sin(), dd(1e300).cos());
    assert!(relative_error(s * s + c * c, Dd::ONE) < 1e-15);
}

#[test]
fn exponentials_at_the_ends_of_the_range() {
    assert_is(dd(-INF).exp(), 0.0);
    assert_is(dd(INF).exp(), INF);
    assert_is(dd(710.0).exp(), INF);
    assert_is(dd(1e300).exp(), INF);
    assert_is(dd(-746.0).exp(), 0.0);
    assert_is(dd(-INF).exp_m1(), -1.0);
    assert_is(dd(INF).exp_m1(), INF);
    assert_is(dd(710.0).cosh() / dd(710.0).sinh(), 1.0);
    assert!(dd(-744.0).exp().to_f64() > 0.0);
    assert_is(dd(INF).tanh(), 1.0);
    assert_is(dd(-INF).sinh(), -INF);
    assert_is(dd(-INF).cosh(), INF);
    let smallest = f64::from_bits(1);
    assert_close(dd(smallest).ln(), LN_2 * dd(-1074.0));
    assert_close((dd(f64::MAX) / dd(2.0)).ln() + LN_2, dd(f64::MAX).ln());
}

#[test]
fn special_values() {
    assert_is(dd(0.0).ln(), -INF);
    assert_is(dd(INF).ln(), INF);
    assert_is(dd(-1.0).ln_1p(), -INF);
    assert_is(dd(INF).ln_1p(), INF);
    assert_is(dd(0.0).sqrt(), 0.0);
    assert_is(dd(INF).sqrt(), INF);
    assert_is(dd(-INF).cbrt(), -INF);
    assert_is(dd(1.0).atanh(), INF);
    assert_is(dd(1.0).acosh(), 0.0);
    assert_is(dd(1.0).acos(), 0.0);
    assert_is(dd(-INF).asinh(), -INF);
    assert_is(dd(INF).acosh(), INF);
    assert_is(dd(INF).hypot(dd(1.0)), INF);
    assert_is(dd(0.0).hypot(dd(0.0)), 0.0);
    assert_eq!(dd(-1.0).acos(), Dd::pi());
    assert_eq!(dd(INF).atan(), Dd::pi() / dd(2.0));
    for nan in [
        dd(-1.0).sqrt(),
        dd(-1.0).ln(),
        dd(-2.0).ln_1p(),
        dd(1.5).asin(),
        dd(-1.5).acos(),
        dd(0.5).acosh(),
        dd(1.5).atanh(),
        dd(-1.0).powf(dd(0.5)),
        dd(INF).sin(),
        dd(INF) - dd(INF),
        dd(0.0) / dd(0.0),
    ] {
        assert!(nan.is_nan() && !nan.is_finite(), "{nan:?}");
    }
}

#[test]
fn nan_stays_nan_and_nothing_panics() {
    let nan = dd(f64::NAN);
    for (name, f) in UNARY {
        assert!(f(nan).is_nan(), "{name}");
        for x in [0.0, -0.0, INF, -INF, f64::MAX, f64::MIN, f64::MIN_POSITIVE, 5e-324] {
            let value = f(dd(x));
            let (hi, lo) = value.parts();
            assert!(hi.is_finite() || lo == 0.0, "{name}({x}) = {value:?}");
        }
    }
    for (name, f) in BINARY {
        assert!(f(nan, dd(2.5)).is_nan(), "{name}");
        assert!(f(dd(2.5), nan).is_nan(), "{name}");
        assert!(f(nan, nan).is_nan(), "{name}");
    }
    assert_is(nan.max(dd(1.0)), 1.0);
    assert_is(dd(1.0).min(nan), 1.0);
}

#[test]
fn powers() {
    assert_is(dd(0.0).powf(dd(0.0)), 1.0);
    assert_is(dd(0.0).powf(dd(2.5)), 0.0);
    assert_is(dd(0.0).powf(dd(-2.5)), INF);
    assert_is(dd(1.0).powf(dd(INF)), 1.0);
    assert_is(dd(INF).powf(dd(-0.5)), 0.0);
    assert_is(dd(-2.0).powf(dd(3.0)), -8.0);
    assert_is(dd(-1.0).powf(dd(101.0)), -1.0);
    assert_is(dd(-1.0).powf(dd(1e10)), 1.0);
    assert_is(dd(2.0).powi(-1074), 5e-324);
    assert_is(dd(0.0).powi(-1), INF);
    assert_is(dd(0.5).powi(i32::MIN), INF);
    assert_is(dd(7.0).powi(0), 1.0);
    assert_close(dd(3.0).powf(dd(0.5)), dd(3.0).sqrt());
}

#[test]
fn arithmetic_at_infinity_and_overflow() {
    let (inf, max) = (dd(INF), dd(f64::MAX));
    assert_is(dd(1.0) / dd(0.0), INF);
    assert_is(dd(-1.0) / dd(0.0), -INF);
    assert_is(Dd::pi() / inf, 0.0);
    assert_is(inf + Dd::pi(), INF);
    assert_is(Dd::pi() - inf, -INF);
    assert_is(inf * -Dd::pi(), -INF);
    assert_is(inf / Dd::pi(), INF);
    assert_is(max + max, INF);
    assert_is(max * max, INF);
    assert_is(max / dd(0.5), INF);
    assert_is(max - max, 0.0);
    assert_is(max * dd(1.0), f64::MAX);
    assert_is(max.sqrt().powi(3), INF);
}

#[test]
fn floor_order_and_sign() {
    let below = Dd::sum(3.0, -1e-20);
    assert_is(below.floor(), 2.0);
    assert_is(dd(-0.5).floor(), -1.0);
    assert_eq!(Dd::sum(1e20, 0.5).floor(), dd(1e20));
    assert!(below < dd(3.0) && Dd::sum(3.0, 1e-20) > dd(3.0));
    assert_eq!(below.min(dd(3.0)), below);
    assert_is(below.max(dd(3.0)), 3.0);
    assert_is(dd(-2.0).abs(), 2.0);
    assert_is(dd(-0.0).abs(), 0.0);
}
