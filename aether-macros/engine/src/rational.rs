//! Exact rational numbers with checked arithmetic.

pub mod matrix;

use std::cmp::Ordering;
use std::fmt;

/// A rational number in lowest terms with a positive denominator.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
pub struct Q {
    num: i128,
    den: i128,
}

/// Numerators and denominators stay below this, so that products never overflow an `i128`.
const LIMIT: i128 = 1 << 62;

/// The greatest common divisor, not negative.
pub fn gcd(a: i128, b: i128) -> i128 {
    let (a, b) = (a.unsigned_abs(), b.unsigned_abs());
    match (u64::try_from(a), u64::try_from(b)) {
        // Short ones are the rule, and divided much faster.
        (Ok(mut a), Ok(mut b)) => {
            while b != 0 {
                (a, b) = (b, a % b);
            }
            i128::from(a)
        }
        _ => gcd_of_long(a, b) as i128,
    }
}

fn gcd_of_long(mut a: u128, mut b: u128) -> u128 {
    while b != 0 {
        (a, b) = (b, a % b);
    }
    a
}

// Checked, so not the operators.
#[allow(clippy::should_implement_trait)]
impl Q {
    /// Zero.
    pub const ZERO: Q = Q { num: 0, den: 1 };
    /// One.
    pub const ONE: Q = Q { num: 1, den: 1 };
    /// One half.
    pub const HALF: Q = Q { num: 1, den: 2 };

    /// The integer `n`.
    pub const fn int(n: i64) -> Q {
        Q { num: n as i128, den: 1 }
    }

    /// `num / den`, or `None` if `den` is zero or the result does not fit.
    pub fn new(num: i128, den: i128) -> Option<Q> {
        if den == 0 {
            return None;
        }
        if den == 1 {
            return (num.abs() < LIMIT).then_some(Q { num, den });
        }
        let g = gcd(num, den).max(1);
        let sign = if den < 0 { -1 } else { 1 };
        let (num, den) =
            if g == 1 { (sign * num, sign * den) } else { (sign * num / g, sign * den / g) };
        (num.abs() < LIMIT && den < LIMIT).then_some(Q { num, den })
    }

    /// The exact value of a decimal literal such as `0.25` or `1e-3`, if it fits.
    pub fn decimal(text: &str) -> Option<Q> {
        let text = text.replace('_', "");
        let (mantissa, exponent) = match text.split_once(['e', 'E']) {
            Some((m, e)) => (m.to_owned(), e.parse::<i32>().ok()?),
            None => (text, 0),
        };
        let (whole, fraction) = mantissa.split_once('.').unwrap_or((&mantissa, ""));
        let digits: i128 = format!("{whole}{fraction}").parse().ok()?;
        let exponent = exponent - i32::try_from(fraction.len()).ok()?;
        let power = 10i128.checked_pow(exponent.unsigned_abs().min(40))?;
        if exponent >= 0 { Q::new(digits.checked_mul(power)?, 1) } else { Q::new(digits, power) }
    }

    /// Numerator.
    pub fn num(self) -> i128 {
        self.num
    }
    /// Denominator, positive.
    pub fn den(self) -> i128 {
        self.den
    }
    /// Sum, if it fits.
    pub fn add(self, o: Q) -> Option<Q> {
        if self.den == o.den {
            return Q::new(self.num + o.num, self.den);
        }
        Q::new(self.num * o.den + o.num * self.den, self.den * o.den)
    }
    /// Product, if it fits.
    pub fn mul(self, o: Q) -> Option<Q> {
        Q::new(self.num * o.num, self.den * o.den)
    }
    /// The negative.
    pub fn neg(self) -> Q {
        Q { num: -self.num, den: self.den }
    }
    /// The reciprocal; `None` for zero.
    pub fn recip(self) -> Option<Q> {
        Q::new(self.den, self.num)
    }
    /// Integer power, if it fits.
    pub fn powi(self, n: i64) -> Option<Q> {
        let base = if n < 0 { self.recip()? } else { self };
        (0..n.unsigned_abs().min(200)).try_fold(Q::ONE, |p, _| p.mul(base))
    }
    /// The rational square root, if there is one.
    pub fn sqrt(self) -> Option<Q> {
        let root = |n: i128| {
            let r = (n as f64).sqrt().round() as i128;
            (r * r == n).then_some(r)
        };
        if self.num < 0 {
            return None;
        }
        Q::new(root(self.num)?, root(self.den)?)
    }
    /// The rational cube root, if there is one.
    pub fn cbrt(self) -> Option<Q> {
        let root = |n: i128| (n as f64).cbrt().round() as i128;
        let root = Q::new(root(self.num), root(self.den))?;
        (root.powi(3) == Some(self)).then_some(root)
    }
    /// Whether this is an integer.
    pub fn is_int(self) -> bool {
        self.den == 1
    }
    /// The value as a machine integer, if it is a small one.
    pub fn to_i32(self) -> Option<i32> {
        if self.den == 1 { i32::try_from(self.num).ok() } else { None }
    }
    /// Whether this is an even integer.
    pub fn is_even(self) -> bool {
        self.den == 1 && self.num % 2 == 0
    }
    /// Nearest double.
    pub fn to_f64(self) -> f64 {
        self.num as f64 / self.den as f64
    }
    /// Whether this is less than zero.
    pub fn is_negative(self) -> bool {
        self.num < 0
    }
    /// Whether this is zero.
    pub fn is_zero(self) -> bool {
        self.num == 0
    }
    /// Absolute value.
    pub fn abs(self) -> Q {
        Q { num: self.num.abs(), den: self.den }
    }
}

impl PartialOrd for Q {
    fn partial_cmp(&self, o: &Q) -> Option<Ordering> {
        Some(self.cmp(o))
    }
}
impl Ord for Q {
    fn cmp(&self, o: &Q) -> Ordering {
        (self.num * o.den).cmp(&(o.num * self.den))
    }
}
impl fmt::Display for Q {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if self.den == 1 {
            write!(f, "{}", self.num)
        } else {
            write!(f, "{}/{}", self.num, self.den)
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn decimals_are_exact() {
        assert_eq!(Q::decimal("0.25"), Q::new(1, 4));
        assert_eq!(Q::decimal("1e-3"), Q::new(1, 1000));
        assert_eq!(Q::decimal("2.5e2"), Q::new(250, 1));
        assert_eq!(Q::decimal("1e300"), None);
    }

    #[test]
    fn roots_and_powers() {
        assert_eq!(Q::new(9, 4).unwrap().sqrt(), Q::new(3, 2));
        assert_eq!(Q::int(2).sqrt(), None);
        assert_eq!(Q::new(8, 27).unwrap().cbrt(), Q::new(2, 3));
        assert_eq!(Q::int(4).cbrt(), None);
        assert_eq!(Q::new(2, 3).unwrap().powi(-2), Q::new(9, 4));
    }
}
