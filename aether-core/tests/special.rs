//! The special functions against values of high precision.

use std::collections::BTreeMap;

use aether_core::Scalar;
use aether_core::prelude::*;

/// Lines of `function bits argument value.hi value.lo`, made by `reference/make_special.py`.
const REFERENCE: &str = include_str!("reference/special.txt");

/// Worst errors in units in the last place, in `f64` and `f32`: a little above what is found.
const LIMITS: [(&str, f64, f64); 8] = [
    ("erf", 1.8, 1.8),
    ("erfc", 4.2, 5.1),
    ("normal_cdf", 5.1, 5.0),
    ("erf_inv", 1.4, 1.4),
    ("erfc_inv", 2.6, 2.8),
    ("normal_quantile", 4.0, 2.5),
    ("lambert_w", 2.4, 2.3),
    ("ln_gamma", 1.5, 0.6),
];

fn function<R: Scalar>(name: &str) -> fn(R) -> R {
    match name {
        "erf" => erf,
        "erfc" => erfc,
        "normal_cdf" => normal_cdf,
        "erf_inv" => erf_inv,
        "erfc_inv" => erfc_inv,
        "normal_quantile" => normal_quantile,
        "lambert_w" => lambert_w,
        "ln_gamma" => ln_gamma,
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
    let mut worst: BTreeMap<&str, [(f64, f64); 2]> = BTreeMap::new();
    for line in REFERENCE.lines().filter(|line| !line.starts_with('#')) {
        let parts: Vec<&str> = line.split(' ').collect();
        let n: Vec<f64> = parts[1..].iter().map(|n| n.parse().unwrap()).collect();
        let (x, hi, lo) = (n[1], n[2], n[3]);
        let entry = worst.entry(parts[0]).or_default();
        let mut note = |i: usize, e: f64| {
            if e.is_nan() || e > entry[i].0 {
                entry[i] = (e, x);
            }
        };
        note(0, error_in_ulp(function::<f64>(parts[0])(x), hi, lo));
        let fits = n[0] == 32.0 && (1.2e-38..3e38).contains(&hi.abs());
        if fits {
            note(1, error_in_ulp(function::<f32>(parts[0])(x as f32), hi, lo));
        }
    }
    println!("worst error in ulp, and where: {worst:#?}");
    for (name, double, single) in LIMITS {
        let [d, s] = worst[name];
        assert!(d.0 < double && s.0 < single, "{name}: {d:?} in f64, {s:?} in f32");
    }
}
