//! Extremes: any bit pattern into every sampler of the registry, and logarithms of densities that no
//! number holds. The binaries `fuzz` and `stability` try more.

use aether_core::prelude::*;
use aether_core::uniform::clamped;
use aether_core::{DomainError, coin, mixture};
use tests::catalogue::*;
use tests::fuzz::fuzz;
use tests::registry::items;

#[test]
fn any_bit_pattern_is_survived_in_f64() {
    let found = fuzz::<f64>(&items(), 500_000, 1);
    assert_eq!(found.failures, 0, "{:#?}", found.examples);
}

#[test]
fn any_bit_pattern_is_survived_in_f32() {
    let found = fuzz::<f32>(&items(), 500_000, 2);
    assert_eq!(found.failures, 0, "{:#?}", found.examples);
}

#[test]
fn any_number_is_a_uniform() {
    assert_eq!(clamped(f32::NAN), 0.0);
    assert_eq!(clamped(f32::NEG_INFINITY), 0.0);
    assert_eq!(clamped(-0.0f32).to_bits(), 0);
    assert_eq!(clamped(f32::INFINITY), 1.0 - f32::EPSILON / 2.0);
    assert_eq!(clamped(1e-300), 1e-300);
}

fn near(found: f64, expected: f64) {
    assert!((found - expected).abs() <= 1e-12 * expected.abs(), "{found} is not {expected}");
}

#[test]
fn densities_below_every_number_have_a_logarithm() -> Result<(), DomainError> {
    near(exponential(2.0).log_pdf(&1e4), 2f64.ln() - 2e4);
    near(laplace(0.5)?.log_pdf(&-1e4), -2e4);
    near(gumbel(0.0, 1.0).log_pdf(&-7.0), 7.0 - 7f64.exp());
    near(weibull(1.0, 2.0).log_pdf(&100.0), 200f64.ln() - 1e4);
    let normal = bivariate_normal(1.0, 0.0, 2.0)?;
    near(normal.log_pdf(&Vec2::new(60.0, 160.0)), -5000.0 - (2.0 * TAU).ln());
    let aside = Direction::new(1.0, 0.0, 0.0);
    near(von_mises_fisher(1e5)?.log_pdf(&aside), (1e5 / TAU).ln() - 1e5);
    let slanted = Direction::new(0.8, 0.0, 0.6);
    near(power_cosine(1e6).log_pdf(&slanted), ((1e6 + 1.0) / TAU).ln() + 1e6 * 0.6f64.ln());
    assert_eq!(exponential(2.0).pdf(&1e4).value(), 0.0);
    assert_eq!(exponential(2.0).log_pdf(&-1.0), f64::NEG_INFINITY);
    let single = exponential(2.0f32).log_pdf(&1e3);
    assert!((single - (2f32.ln() - 2e3)).abs() < 1e-3);
    Ok(())
}

/// Stretches a line.
#[map(a in 1e-3..)]
fn stretched(x: f64, a: f64) -> f64 {
    a * x
}

#[test]
fn logarithms_of_compositions_and_mixtures() -> Result<(), DomainError> {
    let far = exponential(1.0).then(stretched(4.0)?);
    near(far.log_pdf(&8000.0), -2000.0 - 4f64.ln());
    let both = mixture((exponential(1.0), exponential(2.0)), coin(0.25)).expect("there are two");
    near(both.log_pdf(&2000.0), 0.75f64.ln() - 2000.0);
    let x = normal_sample();
    near(x.log_pdf(), x.pdf().value().ln());
    Ok(())
}

fn normal_sample() -> aether_core::Sample<Exponential<f64>, f64> {
    exponential(3.0).sample([0.3])
}
