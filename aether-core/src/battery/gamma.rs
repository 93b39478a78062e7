//! The tail of the chi-square distribution.

/// The probability that a chi-square variable with `freedom` degrees of freedom exceeds `x`: the
/// regularised upper incomplete gamma function Q(freedom / 2, x / 2), by its series below the mean
/// and by its continued fraction (Lentz's algorithm) above it.
pub(super) fn chi_square_tail(x: f64, freedom: f64) -> f64 {
    let (a, x) = (0.5 * freedom, 0.5 * x);
    if x.is_nan() || x < 0.0 {
        return f64::NAN;
    }
    if x.is_infinite() {
        return 0.0;
    }
    let scale = (a * x.ln() - x - ln_gamma(a)).exp();
    if x < a + 1.0 {
        let (mut term, mut sum, mut k) = (1.0 / a, 1.0 / a, a);
        while term > sum * 1e-16 {
            k += 1.0;
            term *= x / k;
            sum += term;
        }
        return (1.0 - scale * sum).max(0.0);
    }
    let mut b = x + 1.0 - a;
    let (mut c, mut d) = (1e300, 1.0 / b);
    let mut fraction = d;
    for i in 1..10_000 {
        let i = f64::from(i);
        let numerator = -i * (i - a);
        b += 2.0;
        d = 1.0 / (numerator * d + b);
        c = b + numerator / c;
        fraction *= c * d;
        if (c * d - 1.0).abs() < 1e-15 {
            break;
        }
    }
    scale * fraction
}

/// ln of the gamma function for positive arguments (Stirling's series after shifting above 10).
fn ln_gamma(mut x: f64) -> f64 {
    let mut shift = 0.0;
    while x < 10.0 {
        shift += x.ln();
        x += 1.0;
    }
    let r = 1.0 / (x * x);
    let series = (1.0 / 12.0 - r * (1.0 / 360.0 - r * (1.0 / 1260.0 - r / 1680.0))) / x;
    (x - 0.5) * x.ln() - x + 0.5 * core::f64::consts::TAU.ln() + series - shift
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tabulated_values() {
        // Two degrees of freedom: exp(-x/2). Ten: the 5 % and 0.1 % points of printed tables.
        assert!((chi_square_tail(3.0, 2.0) - (-1.5_f64).exp()).abs() < 1e-11);
        assert!((chi_square_tail(60.0, 2.0) / (-30.0_f64).exp() - 1.0).abs() < 1e-11);
        assert!((chi_square_tail(18.307_038, 10.0) - 0.05).abs() < 1e-8);
        assert!((chi_square_tail(29.588_298, 10.0) - 0.001).abs() < 1e-9);
        assert!((chi_square_tail(3.940_299, 10.0) - 0.95).abs() < 1e-7);
        assert_eq!(chi_square_tail(f64::INFINITY, 3.0), 0.0);
    }
}
