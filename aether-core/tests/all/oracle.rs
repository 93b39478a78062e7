//! What tests compare distributions with: counts, and quadrature that knows nothing of samplers.

#![allow(dead_code)] // Each test uses a part of it.

/// Standard score of Pearson's statistic, by the approximation of Wilson and Hilferty, for cells with
/// the `expected` counts; cells with fewer than five are pooled.
pub fn chi_square(counts: &[f64], expected: &[f64]) -> f64 {
    let (mut statistic, mut degrees) = (0.0, -1.0);
    let (mut rest, mut rest_expected) = (0.0, 0.0);
    for (count, expected) in counts.iter().zip(expected) {
        if *expected < 5.0 {
            (rest, rest_expected) = (rest + count, rest_expected + expected);
        } else {
            statistic += (count - expected).powi(2) / expected;
            degrees += 1.0;
        }
    }
    if rest_expected >= 5.0 {
        statistic += (rest - rest_expected).powi(2) / rest_expected;
        degrees += 1.0;
    }
    let spread = 2.0 / (9.0 * degrees);
    ((statistic / f64::max(degrees, 1.0)).cbrt() - (1.0 - spread)) / spread.sqrt()
}

/// The score that a right density exceeds once in a million.
pub const LIMIT: f64 = 4.75;

/// The integral of `f` from a to b by the midpoint rule.
pub fn midpoint(a: f64, b: f64, n: usize, f: impl Fn(f64) -> f64) -> f64 {
    let h = (b - a) / n as f64;
    (0..n).map(|k| f(a + h * (k as f64 + 0.5))).sum::<f64>() * h
}
