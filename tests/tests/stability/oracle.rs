//! The numbers of 31 digits that errors are measured with.

use aether_core::{Real, Sampler};
use core::f64::consts::{PI, TAU};
use tests::catalogue::{hyperexponential, kepler};
use tests::checks::right;
use tests::precise::{Dual, Precise, exactly};
use tests::registry::items;
use tests::stability::exact;

#[test]
fn constants_are_what_is_meant_and_parameters_what_they_are() {
    let third = Precise::of(1.0 / 3.0) * Precise::of(3.0) - Precise::ONE;
    assert!(third.to_f64().abs() < 1e-30);
    assert!(Precise::of(PI).sin().to_f64().abs() < 1e-30);
    assert!((exactly::<Precise>(PI).sin().to_f64() - 1.2246467991473532e-16).abs() < 1e-30);
    for x in [TAU, 0.1, -1e-300, 1e300, 5e-324, 0.9999999999999999, 1.0 / 3.0] {
        assert_eq!(exactly::<Precise>(x), Precise::f64(x));
    }
}

#[test]
fn derivatives() {
    let x = Dual::variable(Precise::f64(0.3));
    let near = |found: Dual, slope: f64| {
        assert!((found.slope.to_f64() - slope).abs() < 1e-15, "{found:?} has not slope {slope}");
    };
    near(x.sin() * x.exp(), 0.3f64.exp() * (0.3f64.sin() + 0.3f64.cos()));
    near(x.powf(x), 0.3f64.powf(0.3) * (0.3f64.ln() + 1.0));
    near(x.atan2(x * x), -1.0 / 1.09);
    near((x / (Dual::ONE - x)).sqrt(), 0.5 * (0.7f64 / 0.3).sqrt() / 0.49);
}

/// Each function undoes its inverse to 28 digits, and so do their derivatives.
#[test]
fn special_functions_have_all_digits() {
    use aether_core::special::{
        beta_inc, beta_inc_inv, erf, erf_inv, erfc, erfc_inv, erfc_inv_exp, lambert_w, ln_erfc,
        normal_cdf, normal_quantile,
    };
    let x = Dual::variable(Precise::f64(0.3));
    let [a, b] = [0.5, 7.0].map(|x| Dual::constant(Precise::f64(x)));
    for (name, y) in [
        ("erf", erf(erf_inv(x))),
        ("erfc", erfc(erfc_inv(x))),
        ("ln_erfc", -ln_erfc(erfc_inv_exp(-x))),
        ("normal_cdf", normal_cdf(normal_quantile(x))),
        ("lambert_w", lambert_w(x) * lambert_w(x).exp()),
        ("beta_inc", beta_inc(a, b, beta_inc_inv(a, b, x))),
    ] {
        let off = [(y.value - x.value).to_f64(), (y.slope - Precise::ONE).to_f64()];
        assert!(off.iter().all(|e| e.abs() < 1e-26), "{name}: {off:?}");
    }
    // I(x; 1/2, 1) = √x.
    let root = beta_inc(a, Dual::ONE, x);
    let off = [root.value - x.value.sqrt(), root.slope - Precise::of(0.5) / x.value.sqrt()];
    assert!(off.iter().all(|e| e.to_f64().abs() < 1e-26), "{off:?}");
}

/// Next to the border of a piece the other preimage may have no digits left, and lines in the plane of an opening have
/// columns that are parallel to three hundred digits.
#[test]
fn what_31_digits_do_not_tell_is_no_density() {
    let items = items();
    let density = |name: &str, numbers: &[f64], u: &[f64]| {
        let item = items.iter().find(|item| item.name == name).expect("it is registered");
        let u: Vec<Precise> = u.iter().map(|u| Precise::f64(*u)).collect();
        exact(item, numbers, &u).expect("there is a sample").density.to_f64()
    };
    assert!(density("mixture", &[5e-7, 8.0], &[1e-300, 0.3]).is_nan());
    assert!(density("mixture", &[5e-7, 8.0], &[1e-8, 0.3]) > 0.0);
    let portal = [1e-3, 0.0, 0.0, 100.0, 0.6, 0.0, 0.8, 0.0, 0.0, -0.01, 0.28, 0.0, 0.96];
    assert!(
        density("tilted_portal", &portal, &[0.999999999, 0.999999999, 1e-300, 0.999999999])
            .is_nan()
    );
    assert!(density("tilted_portal", &portal, &[0.3, 0.6, 0.5, 0.7]) > 0.0);
}

/// A step of a sampler that is solved for has them too, and so has its derivative, by the last step of Newton's method.
#[test]
fn solved_equations_have_all_digits() {
    let (u, e) = (Precise::f64(0.3), Precise::f64(0.6));
    let turn = Precise::of(TAU);
    let (x, _) = right(kepler(e)).forward([u]);
    assert!((x - e * x.sin() - turn * u).to_f64().abs() < 1e-29, "{x:?}");
    let (y, _) = right(kepler(Dual::constant(e))).forward([Dual::variable(u)]);
    let slope = turn / (Precise::ONE - e * x.cos());
    assert!(
        (y.value - x).to_f64().abs() < 1e-29 && (y.slope - slope).to_f64().abs() < 1e-27,
        "{y:?}"
    );
    // In a unit without an upper end, next to both of its ends.
    for u in [1e-300, 0.5, 0.999] {
        let u = Precise::f64(u);
        let [p, l, m] = [0.3, 2.0, 0.1].map(Precise::f64);
        let (x, _) = right(hyperexponential(p, l, m)).forward([u]);
        let found = -p * (-l * x).exp_m1() - (Precise::ONE - p) * (-m * x).exp_m1();
        assert!(((found - u) / u).to_f64().abs() < 1e-28, "{x:?}");
    }
}
