//! The special functions against values of high precision.

use std::collections::BTreeMap;

use aether_core::Scalar;
use aether_core::prelude::*;
use aether_core::special;

/// Lines of `function bits parameters argument value.hi value.lo`, made by `reference/make_special.py`.
const REFERENCE: &str = include_str!("reference/special.txt");

/// Worst errors in units in the last place, in `f64` and `f32`: a little above what is found.
const LIMITS: [(&str, f64, f64); 13] = [
    ("erf", 1.8, 1.8),
    ("erfc", 4.2, 5.1),
    ("normal_cdf", 5.1, 5.0),
    ("erf_inv", 1.4, 1.4),
    ("erfc_inv", 2.6, 2.8),
    ("normal_quantile", 4.0, 2.5),
    ("ln_erfc", 4.6, 4.0),
    ("erfc_inv_exp", 2.6, 2.0),
    ("lambert_w", 2.4, 2.3),
    ("ln_gamma", 1.5, 0.6),
    ("ln_beta", 28.0, 0.6),
    ("beta_inc", 540.0, 0.6),
    ("beta_inc_inv", 240.0, 0.6),
];

/// The value of a function at its arguments.
fn value<R: Scalar>(name: &str, arguments: &[f64]) -> R {
    let x = |i: usize| R::of(arguments[i]);
    match name {
        "erf" => erf(x(0)),
        "erfc" => erfc(x(0)),
        "normal_cdf" => normal_cdf(x(0)),
        "erf_inv" => erf_inv(x(0)),
        "erfc_inv" => erfc_inv(x(0)),
        "normal_quantile" => normal_quantile(x(0)),
        "ln_erfc" => special::ln_erfc(x(0)),
        "erfc_inv_exp" => special::erfc_inv_exp(x(0)),
        "lambert_w" => lambert_w(x(0)),
        "ln_gamma" => ln_gamma(x(0)),
        "ln_beta" => ln_beta(x(0), x(1)),
        "beta_inc" => beta_inc(x(0), x(1), x(2)),
        "beta_inc_inv" => beta_inc_inv(x(0), x(1), x(2)),
        name => panic!("no function {name}"),
    }
}

/// The error in units in the last place of the result's precision.
fn error_in_ulp<R: Scalar>(found: R, hi: f64, lo: f64) -> f64 {
    let exponent = R::of(hi).to_f64().abs().log2().floor();
    let ulp = R::EPSILON.to_f64() * exponent.exp2();
    (((found.to_f64() - hi) - lo) / ulp).abs()
}

#[test]
fn errors_are_a_few_units_in_the_last_place() {
    let mut worst: BTreeMap<&str, [(f64, Vec<f64>); 2]> = BTreeMap::new();
    for line in REFERENCE.lines().filter(|line| !line.starts_with('#')) {
        let parts: Vec<&str> = line.split(' ').collect();
        let n: Vec<f64> = parts[1..].iter().map(|n| n.parse().unwrap()).collect();
        let [bits, arguments @ .., hi, lo] = &n[..] else { panic!("{line}") };
        let entry = worst.entry(parts[0]).or_default();
        let mut note = |i: usize, e: f64| {
            if e.is_nan() || e > entry[i].0 {
                entry[i] = (e, arguments.to_vec());
            }
        };
        note(0, error_in_ulp(value::<f64>(parts[0], arguments), *hi, *lo));
        let fits = *bits == 32.0 && (1.2e-38..3e38).contains(&hi.abs());
        if fits {
            note(1, error_in_ulp(value::<f32>(parts[0], arguments), *hi, *lo));
        }
    }
    println!("worst error in ulp, and where: {worst:#?}");
    for (name, double, single) in LIMITS {
        let [d, s] = &worst[name];
        assert!(d.0 < double && s.0 < single, "{name}: {d:?} in f64, {s:?} in f32");
    }
}
