//! Ordinary Rust that has been read as something else than Rust does.

use aether_core::prelude::*;

/// Asserts that the sample of a uniform is this one, with this density, by itself and at the point.
#[track_caller]
fn sampled<S: Sampler<f64, Uniforms = [f64; 1], Point = f64>>(sampler: &S, u: f64, x: f64, p: f64) {
    let sample = sampler.sample([u]);
    assert!(sample.is_valid(), "{u} has no sample");
    let close = |found: f64, expected: f64| (found - expected).abs() <= 1e-14 * expected.abs();
    assert!(close(sample.value(), x), "{u}: {} for {x}", sample.value());
    for found in [sample.pdf().value(), sampler.pdf(&x).value()] {
        assert!(close(found, p), "{u}: density {found} for {p}");
    }
}

#[sampler]
fn logarithm_of_a_square(u: [Uniform; 1]) -> f64 {
    let x = 2.0 * u[0] - 0.7;
    (x * x).ln()
}

#[sampler(k in -4.0..=4.0)]
fn by_a_squared_parameter(u: [Uniform; 1], k: f64) -> f64 {
    (k * k).ln() * u[0]
}

#[sampler]
fn size_by_logarithm(u: [Uniform; 1]) -> f64 {
    let x = 2.0 * u[0] - 0.75;
    (0.5 * (x * x).ln()).exp()
}

#[sampler]
fn flat(u: [Uniform; 1]) -> f64 {
    4.0 * u[0] - 2.0
}

#[map]
fn squared_logarithm(x: f64) -> f64 {
    (x * x).ln()
}

/// ln(x²) is 2 ln |x|.
#[test]
fn even_powers_have_logarithms_on_both_sides_of_zero() {
    // |x| = 0.5 has two preimages, |x| = 1 one; dx / d ln(x²) = |x| / 2, and a uniform for two of x.
    sampled(&logarithm_of_a_square(), 0.1, 0.25_f64.ln(), 2.0 * 0.5 * 0.25);
    sampled(&logarithm_of_a_square(), 0.85, 0.0, 0.25);
    for k in [-2.0, 2.0, -0.5] {
        let sampler = by_a_squared_parameter(k).unwrap();
        sampled(&sampler, 0.5, 0.5 * (k * k).ln(), 1.0 / (k * k).ln().abs());
    }
    sampled(&size_by_logarithm(), 0.125, 0.5, 1.0);
    sampled(&size_by_logarithm(), 0.875, 1.0, 0.5);
    let chain = Sampler::<f64>::then(flat(), squared_logarithm());
    sampled(&chain, 0.25, 0.0, 0.25);
    sampled(&chain, 0.75, 0.0, 0.25);
}

#[sampler(k in 0.0..=2.0)]
fn rotated(u: [Uniform; 1], k: f64) -> f64 {
    (u[0] + k).fract()
}

#[sampler]
fn _1(u: [Uniform; 1]) -> f64 {
    2.0 * u[0]
}

#[test]
fn what_is_left_of_a_number() {
    for (k, u, x) in [(0.25, 0.5, 0.75), (0.75, 0.5, 0.25), (1.5, 0.75, 0.25)] {
        sampled(&rotated(k).unwrap(), u, x, 1.0);
    }
    sampled(&_1(), 0.25, 0.5, 0.5);
}

#[sampler]
fn square_of_a_sum(u: [Uniform; 1], j: f64) -> f64 {
    (u[0] + j).powi(2)
}

/// Of an undeclared parameter no sign is taken for granted: which root of a square is meant depends on it.
#[test]
fn undeclared_parameters_have_both_signs() {
    for j in [2.0, -3.0, -1.0, 0.0] {
        for u in [0.125, 0.75] {
            let x = u + j;
            sampled(&square_of_a_sum(j), u, x * x, 1.0 / (2.0 * f64::abs(x)));
        }
    }
    // Where both roots lie within, both count.
    sampled(&square_of_a_sum(-0.5), 0.25, 0.0625, 4.0);
}

#[sampler]
fn root_of_any_sign(u: [Uniform; 1]) -> f64 {
    (1.0 - 2.0 * u[0]).sqrt()
}

#[sampler]
fn ring(u: [Uniform; 2], z: f64) -> Direction {
    let (h, phi) = (z * u[0], TAU * u[1]);
    let r = (1.0 - h * h).sqrt();
    Direction::new(r * phi.cos(), r * phi.sin(), h)
}

/// A root of a negative number is no sample, as no logarithm of one is.
#[test]
fn without_a_root_there_is_no_sample() {
    sampled(&root_of_any_sign(), 0.375, 0.5, 0.5);
    let outside = Sampler::<f64>::sample(&root_of_any_sign(), [0.75]);
    assert!(!outside.is_valid() && outside.pdf().value() == 0.0);
    for (u, valid) in [(0.125, true), (0.375, false)] {
        let sample = Sampler::<f64>::sample(&ring(4.0), [u, 0.25]);
        assert_eq!(sample.is_valid(), valid);
        assert!((sample.pdf().value() > 0.0) == valid);
    }
}

#[sampler]
fn power_by_integers(u: [Uniform; 1]) -> f64 {
    u[0].powi(7 / 2 * 2)
}

#[sampler]
fn rest_of_a_negative_period(u: [Uniform; 1]) -> f64 {
    (3.0 * u[0]).rem_euclid(-2.0)
}

/// Integers divide without a rest, and the rest of a division is not negative: as in Rust.
#[test]
fn integers_and_rests_are_those_of_rust() {
    sampled(&power_by_integers(), 0.5, 0.5_f64.powi(6), 32.0 / 6.0);
    sampled(&rest_of_a_negative_period(), 0.5, 1.5, 1.0 / 3.0);
    sampled(&rest_of_a_negative_period(), 0.75, 0.25, 2.0 / 3.0);
}
