//! Quotients of integers, rounded once.

use super::dd::two_prod;

/// Integers below this are exact in an `f64`.
const EXACT: u128 = 1 << 53;

/// `numerator / denominator` as an unevaluated sum: its nearest `f64`, and the `f64` nearest to
/// what is then missing (of which at least 127 bits of the quotient are kept).
///
/// Over zero the first part is infinite or, for 0/0, NaN.
pub(super) fn quotient(numerator: i128, denominator: i128) -> (f64, f64) {
    let sign = if (numerator < 0) == (denominator < 0) { 1.0 } else { -1.0 };
    let (n, d) = (numerator.unsigned_abs(), denominator.unsigned_abs());
    if n == 0 || d == 0 {
        return (n as f64 / d as f64 * sign, 0.0);
    }
    let (hi, lo) = if n < EXACT && d < EXACT { short(n as f64, d as f64) } else { long(n, d) };
    (sign * hi, sign * lo)
}

/// The quotient of two positive integers exact in `f64`; the remainder is then exact as well.
fn short(n: f64, d: f64) -> (f64, f64) {
    let hi = n / d;
    let (product, error) = two_prod(hi, d);
    (hi, ((n - product) - error) / d)
}

/// The quotient of two positive integers of at most 2¹²⁷, by long division to 127 bits.
fn long(n: u128, d: u128) -> (f64, f64) {
    let (mut bits, mut rest) = (n / d, n % d);
    let mut exponent = 0;
    while bits >> 126 == 0 {
        // d is at most 2^127, so twice the remainder fits.
        rest <<= 1;
        let bit = u128::from(rest >= d);
        rest -= bit * d;
        bits = bits << 1 | bit;
        exponent -= 1;
    }
    // A sticky last bit makes the conversions below round as the exact quotient would.
    bits |= u128::from(rest != 0);
    let hi = bits as f64;
    let missing = bits.wrapping_sub(hi as u128) as i128;
    (libm::scalbn(hi, exponent), libm::scalbn(missing as f64, exponent))
}

#[cfg(test)]
mod tests {
    use super::quotient;

    #[test]
    fn simple_quotients_are_exact() {
        assert_eq!(quotient(3, 4), (0.75, 0.0));
        assert_eq!(quotient(-3, 4), (-0.75, 0.0));
        assert_eq!(quotient(3, -4), (-0.75, 0.0));
        assert_eq!(quotient((1 << 60) + 1, 1), (1152921504606846976.0, 1.0));
        assert_eq!(quotient(i128::MIN, i128::MIN), (1.0, 0.0));
        assert_eq!(quotient(i128::MIN, 1), (-(2f64.powi(127)), 0.0));
        assert_eq!(quotient(0, 5), (0.0, 0.0));
    }

    #[test]
    fn over_zero() {
        assert_eq!(quotient(1, 0).0, f64::INFINITY);
        assert_eq!(quotient(-1, 0).0, f64::NEG_INFINITY);
        assert!(quotient(0, 0).0.is_nan());
    }

    #[test]
    fn short_and_long_division_agree() {
        for (n, d) in [(1, 3), (2, 7), (355, 113), (123_456_789, 1_000_000_007), (10, 1 << 40)] {
            // The scaled fraction is the same number but too large for the short way.
            assert_eq!(quotient(n, d), quotient(n << 64, d << 64), "{n}/{d}");
        }
    }

    #[test]
    fn rounds_once() {
        // 1 + 2^-53 + 2^-120 lies just above a tie; rounding the integers first would lose that.
        let d = 1i128 << 120;
        let n = d + (1 << 67) + 1;
        assert_eq!(quotient(n, d).0, 1.0 + f64::EPSILON);
        assert_eq!(quotient(n - 1, d), (1.0, f64::EPSILON / 2.0));
    }
}
