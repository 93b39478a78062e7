//! Parameters that are integers, truth values and arrays: in bodies, constructors, domains, compositions and drawn at random.

use aether_core::prelude::*;
use aether_core::proptest::samplers;
use aether_core::{DomainError, battery};
use proptest::strategy::{Strategy, ValueTree};
use proptest::test_runner::TestRunner;

/// One of a few formulas.
#[sampler(n in 1..=4)]
fn power(u: [Uniform; 1], n: u32) -> f64 {
    let mut x = u[0];
    if n == 2 {
        x *= x;
    } else if n > 2 {
        x = x * x * x;
    }
    x + n as f64
}

/// As many strata as there are.
#[sampler(n in 1..=6, scale in 0.1..=10.0)]
fn strata(u: [Uniform; 1], n: usize, scale: f64) -> f64 {
    let n = n as f64;
    let k = (n * u[0]).floor();
    let t = n * u[0] - k;
    scale * (k + 0.5 * (t + t * t))
}

/// Up or down, as far as an array says.
#[sampler(where w[0] > 0.0)]
fn either_way(u: [Uniform; 1], w: [f64; 3], up: bool) -> f64 {
    let total: f64 = w.iter().map(|x| x * x + 0.5).sum();
    if up { total * u[0] } else { -w[0] * u[0] }
}

/// A triangle by the coordinates of its corners.
#[sampler]
fn corners(u: [Uniform; 2], v: [f64; 6]) -> Vec2 {
    let p = |i: usize| Vec2::new(v[2 * i], v[2 * i + 1]);
    let s = u[0].sqrt();
    p(0) * (1.0 - s) + p(1) * (s * (1.0 - u[1])) + p(2) * (s * u[1])
}

/// Integers and truth values alone: no parameter has a precision.
#[sampler]
fn shifted(u: [Uniform; 1], n: i32, twice: bool) -> f64 {
    let x = u[0] + f64::from(n);
    if twice { 2.0 * x } else { x }
}

/// As many turns of a loop as a parameter says, and the element of an array that another one says.
#[sampler(n in 1..=3, i in 0..=1)]
fn repeated(u: [Uniform; 1], n: usize, i: usize) -> f64 {
    let scale = [2.0, 3.0];
    let mut x = u[0];
    for _ in 1..n {
        x += scale[i] * x;
    }
    x
}

#[map]
fn doubled(x: f64) -> f64 {
    2.0 * x
}

/// A composition that hands them on.
#[sampler]
fn shifted_and_doubled(u: [Uniform; 1], n: i32, twice: bool) -> f64 {
    doubled().apply(&shifted(n, twice).sample(u))
}

#[test]
fn they_choose_formulas() -> Result<(), DomainError> {
    assert_eq!(power(2)?.pdf(&2.25f64).value(), 1.0);
    assert_eq!(power(1)?.pdf(&1.25f64).value(), 1.0);
    assert!((power(4)?.pdf(&4.125f64).value() - 1.0 / 0.75).abs() < 1e-14);
    for n in [1, 2, 3, 5, 6] {
        battery::check(&strata(n, 2.0)?).assert_ok();
    }
    assert!(strata(7, 2.0).is_err());
    // Each turn multiplies by one more than the element.
    assert!((repeated(3, 1)?.pdf(&1.5f64).value() - 1.0 / 16.0).abs() < 1e-15);
    assert!((repeated(2, 0)?.pdf(&1.5f64).value() - 1.0 / 3.0).abs() < 1e-15);
    assert_eq!(repeated(1, 0)?.pdf(&1.5f64).value(), 0.0);
    let x = strata(3, 2.0)?.sample([0.5]);
    assert!((x.value() - 2.75).abs() < 1e-14 && (x.pdf().value() - 1.0 / 6.0).abs() < 1e-14);
    Ok(())
}

#[test]
fn arrays_are_numbers() -> Result<(), DomainError> {
    let up = either_way([1.0, 2.0, 0.5], true)?;
    assert!((up.pdf(&1.0).value() - 1.0 / 6.75).abs() < 1e-15);
    let down = either_way([1.0f32, 2.0, 0.5], false)?;
    assert_eq!(down.pdf(&-0.5).value(), 1.0);
    assert_eq!(either_way([-1.0, 2.0, 0.5], true).unwrap_err().requirement, "w [0] > 0.0");
    let triangle = corners([1.0, 1.0, 3.0, 1.5, 1.0, 4.0]);
    battery::check(&triangle).assert_ok();
    assert!((triangle.pdf(&Vec2::new(1.5, 2.0)).value() - 1.0 / 3.0).abs() < 1e-14);
    Ok(())
}

#[test]
fn without_any_other_the_precision_is_that_of_the_point() {
    let sampler = shifted(-2, true);
    assert_eq!(sampler.pdf(&-3.0f64).value(), 0.5);
    assert_eq!(sampler.pdf(&-3.0f32).value(), 0.5);
    battery::check(&sampler).assert_ok();
}

#[test]
fn they_are_drawn_and_handed_on() {
    let mut runner = TestRunner::deterministic();
    for _ in 0..16 {
        let drawn = samplers::<Repeated>().new_tree(&mut runner).expect("is drawn").current();
        battery::check(&drawn).assert_ok();
    }
    let chain = shifted_and_doubled(1, true);
    assert_eq!(chain.pdf(&5.0f64).value(), 0.25);
}
