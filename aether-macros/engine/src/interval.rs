//! Intervals: what the domains of uniforms and parameters say about the sign of an expression.

use std::f64::consts::FRAC_PI_2;

use crate::expr::Fun;
use crate::number::Number;

/// A little less than 1/e, where Lambert's W begins.
const INVERSE_E: f64 = 0.367_879_441_171_442_3;

/// A closed interval of the extended real line that contains every value of an expression.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Interval {
    /// Lower end.
    pub lo: f64,
    /// Upper end.
    pub hi: f64,
}

// Outward to the hull of what is possible, which the operators would hide.
#[allow(clippy::should_implement_trait)]
impl Interval {
    /// The whole line: nothing is known.
    pub const ALL: Interval = Interval { lo: f64::NEG_INFINITY, hi: f64::INFINITY };
    /// All numbers from zero up.
    pub const POSITIVE: Interval = Interval { lo: 0.0, hi: f64::INFINITY };

    /// The interval from `lo` to `hi`; the whole line if an end is NaN.
    pub fn new(lo: f64, hi: f64) -> Interval {
        if lo.is_nan() || hi.is_nan() { Interval::ALL } else { Interval { lo, hi } }
    }
    /// A single number.
    pub fn point(x: f64) -> Interval {
        Interval::new(x, x)
    }
    /// Whether no value is negative.
    pub fn nonnegative(self) -> bool {
        self.lo >= 0.0
    }
    /// Whether no value is positive.
    pub fn nonpositive(self) -> bool {
        self.hi <= 0.0
    }
    /// Whether no value is above one, but for the rounding of interval arithmetic.
    pub fn at_most_one(self) -> bool {
        self.hi <= 1.0 + 1e-14
    }
    /// Whether no value is outside of [0, 1], but for that rounding.
    pub fn within_one(self) -> bool {
        self.nonnegative() && self.at_most_one()
    }
    /// What is in both; this one if nothing is.
    pub fn intersection(self, o: Interval) -> Interval {
        let (lo, hi) = (self.lo.max(o.lo), self.hi.min(o.hi));
        if lo > hi { self } else { Interval { lo, hi } }
    }
    /// The smallest interval that contains both.
    pub fn hull(self, o: Interval) -> Interval {
        Interval::new(self.lo.min(o.lo), self.hi.max(o.hi))
    }
    /// Distance between the ends.
    pub fn width(self) -> f64 {
        self.hi - self.lo
    }
    /// Sums.
    pub fn add(self, o: Interval) -> Interval {
        Interval::new(self.lo + o.lo, self.hi + o.hi)
    }
    /// Multiples.
    pub fn scale(self, k: f64) -> Interval {
        self.mul(Interval::point(k))
    }
    /// Products, with zero times infinity taken as zero (a bound that is not attained).
    pub fn mul(self, o: Interval) -> Interval {
        let times = |a: f64, b: f64| if a == 0.0 || b == 0.0 { 0.0 } else { a * b };
        let ends = [
            times(self.lo, o.lo),
            times(self.lo, o.hi),
            times(self.hi, o.lo),
            times(self.hi, o.hi),
        ];
        hull(&ends)
    }
    /// Powers with a fixed exponent; the base is taken as nonnegative unless the exponent is an integer.
    pub fn pow(self, e: f64) -> Interval {
        let even = e.fract() == 0.0 && e % 2.0 == 0.0;
        if e.fract() == 0.0 && !even {
            if e < 0.0 && self.lo < 0.0 && self.hi > 0.0 {
                return Interval::ALL;
            }
            let f = |x: f64, side: f64| if x == 0.0 && e < 0.0 { side } else { libm::pow(x, e) };
            return hull(&[f(self.lo, f64::INFINITY), f(self.hi, f64::NEG_INFINITY)]);
        }
        let (mut lo, mut hi) = (self.lo.max(0.0), self.hi.max(0.0));
        if even {
            hi = self.lo.abs().max(self.hi.abs());
            lo = if self.lo <= 0.0 && self.hi >= 0.0 {
                0.0
            } else {
                self.lo.abs().min(self.hi.abs())
            };
        }
        hull(&[libm::pow(lo, e), libm::pow(hi, e)])
    }
    /// Powers of a base that is not negative, with exponents from an interval.
    pub fn powers(self, e: Interval) -> Interval {
        // Powers of what is at most one tend to zero; zero to the power of zero is one.
        let unbounded = e.hi == f64::INFINITY && e.lo < 0.0;
        if self.lo < 0.0 || !e.lo.is_finite() || e.hi.is_nan() || unbounded {
            return Interval::POSITIVE;
        }
        // Monotone in the base and in the exponent, so that the corners are extreme.
        let (lo, hi) = (self.lo, self.hi);
        hull(&[(lo, e.lo), (lo, e.hi), (hi, e.lo), (hi, e.hi)].map(|(b, e)| libm::pow(b, e)))
    }
    /// (c + Σ aᵢ tᵢ) / (d + Σ bᵢ tᵢ), if the denominator is not negative where the tᵢ (with aᵢ, bᵢ and
    /// their ranges) are at the ends that make it smallest. With sᵢ >= 0 for the distances from these ends
    /// the quotient lies between those of the coefficients.
    pub fn quotient_of_sums(
        (mut c, mut d): (f64, f64),
        terms: Vec<(f64, f64, Interval)>,
    ) -> Option<Interval> {
        let mut ratios = Vec::new();
        for (a, b, t) in terms {
            let (end, sign) = if b > 0.0 { (t.lo, 1.0) } else { (t.hi, -1.0) };
            if !end.is_finite() {
                return None;
            }
            (c, d) = (c + a * end, d + b * end);
            ratios.push(sign * a / b.abs());
        }
        match (c == 0.0, d == 0.0) {
            (true, true) => {}
            (_, false) if d > 0.0 => ratios.push(c / d),
            _ => return None,
        }
        Some(hull(&ratios))
    }
    /// The angles atan2(y, x) of points to the right of the ordinate.
    pub fn quadrants(y: Interval, x: Interval) -> Interval {
        // At the origin the angle is zero; it grows with y, and shrinks towards zero with x.
        let end = |y: f64, x: f64| if y == 0.0 { 0.0 } else { libm::atan2(y, x) };
        let lo = end(y.lo, if y.lo < 0.0 { x.lo } else { x.hi });
        let hi = end(y.hi, if y.hi > 0.0 { x.lo } else { x.hi });
        // The origin belongs to the angles if it may be met.
        let origin = x.lo == 0.0 && y.lo <= 0.0 && y.hi >= 0.0;
        if origin { Interval::new(lo.min(0.0), hi.max(0.0)) } else { Interval::new(lo, hi) }
    }
    /// The image under a function of one argument.
    pub fn call(self, f: Fun) -> Interval {
        let monotone = |g: fn(f64) -> f64| Interval::new(g(self.lo), g(self.hi));
        let falling = |g: fn(f64) -> f64| Interval::new(g(self.hi), g(self.lo));
        let within = |lo: f64, hi: f64| self.lo >= lo && self.hi <= hi;
        match f {
            Fun::Exp => monotone(libm::exp),
            Fun::ExpM1 => monotone(libm::expm1),
            Fun::Ln if self.lo >= 0.0 => {
                monotone(|x| if x == 0.0 { f64::NEG_INFINITY } else { libm::log(x) })
            }
            Fun::Ln1p if self.lo >= -1.0 => {
                monotone(|x| if x == -1.0 { f64::NEG_INFINITY } else { libm::log1p(x) })
            }
            Fun::Sinh => monotone(libm::sinh),
            Fun::Tanh => monotone(libm::tanh),
            Fun::Asinh => monotone(libm::asinh),
            Fun::Atan => monotone(libm::atan),
            Fun::Cosh => Interval::new(1.0, f64::INFINITY),
            Fun::Acosh if self.lo >= 1.0 => monotone(libm::acosh),
            Fun::Acosh => Interval::POSITIVE,
            Fun::Atanh if within(-1.0, 1.0) => monotone(libm::atanh),
            Fun::Cbrt => monotone(libm::cbrt),
            Fun::Erf => monotone(libm::erf),
            Fun::Erfc => falling(libm::erfc),
            Fun::ErfInv if within(-1.0, 1.0) => monotone(Number::erf_inv),
            Fun::ErfcInv if within(0.0, 2.0) => falling(Number::erfc_inv),
            Fun::LnErfc => falling(Number::ln_erfc),
            Fun::LambertW if self.lo >= -INVERSE_E => monotone(Number::lambert_w),
            Fun::LambertW => Interval::new(-1.0, f64::INFINITY),
            Fun::Acos if within(-1.0, 1.0) => falling(libm::acos),
            Fun::Asin if within(-1.0, 1.0) => monotone(libm::asin),
            Fun::Acos => Interval::new(0.0, std::f64::consts::PI),
            Fun::Asin => Interval::new(-std::f64::consts::FRAC_PI_2, std::f64::consts::FRAC_PI_2),
            Fun::Sin if self.lo >= 0.0 && self.hi <= std::f64::consts::PI => {
                Interval::new(0.0, 1.0)
            }
            Fun::Cos
                if self.lo >= -std::f64::consts::FRAC_PI_2
                    && self.hi <= std::f64::consts::FRAC_PI_2 =>
            {
                Interval::new(0.0, 1.0)
            }
            Fun::SinPi if self.lo >= 0.0 && self.hi <= 1.0 => Interval::new(0.0, 1.0),
            Fun::SinPi | Fun::CosPi | Fun::Sin | Fun::Cos | Fun::Sign => Interval::new(-1.0, 1.0),
            Fun::Tan if within(-FRAC_PI_2, FRAC_PI_2) => {
                let end =
                    |x: f64, pole: f64| if x.abs() >= FRAC_PI_2 { pole } else { libm::tan(x) };
                Interval::new(end(self.lo, f64::NEG_INFINITY), end(self.hi, f64::INFINITY))
            }
            Fun::Abs => {
                let hi = self.lo.abs().max(self.hi.abs());
                let lo = if self.lo <= 0.0 && self.hi >= 0.0 {
                    0.0
                } else {
                    self.lo.abs().min(self.hi.abs())
                };
                Interval::new(lo, hi)
            }
            Fun::Turn => Interval::new(0.0, std::f64::consts::TAU),
            _ => Interval::ALL,
        }
    }
}

fn hull(ends: &[f64]) -> Interval {
    let lo = ends.iter().copied().fold(f64::INFINITY, f64::min);
    let hi = ends.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    if ends.iter().any(|x| x.is_nan()) { Interval::ALL } else { Interval::new(lo, hi) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn functions_of_several_arguments() {
        let i = Interval::new;
        assert_eq!(i(0.25, 2.0).powers(i(-1.0, 2.0)), i(0.0625, 4.0));
        assert_eq!(i(0.0, 2.0).powers(i(-1.0, 1.0)), i(0.0, f64::INFINITY));
        assert_eq!(i(-1.0, 2.0).powers(i(0.0, 1.0)), Interval::POSITIVE);
        let quarter = std::f64::consts::FRAC_PI_4;
        assert_eq!(Interval::quadrants(i(-1.0, 1.0), i(1.0, 5.0)), i(-quarter, quarter));
        assert_eq!(Interval::quadrants(i(1.0, 2.0), i(0.0, 1.0)), i(quarter, FRAC_PI_2));
        assert!(Interval::quadrants(i(0.0, 1.0), Interval::POSITIVE).lo == 0.0);
    }

    #[test]
    fn quotients_of_sums() {
        let i = Interval::new;
        let of = |constants, terms: &[(f64, f64, Interval)]| {
            Interval::quotient_of_sums(constants, terms.to_vec())
        };
        // (t - s) / (t + s), with both ends where numerator and denominator vanish.
        let u = i(0.0, 1.0);
        assert_eq!(of((0.0, 0.0), &[(1.0, 1.0, u), (-1.0, 1.0, u)]), Some(i(-1.0, 1.0)));
        assert_eq!(of((0.0, 2.0), &[(1.0, -1.0, u), (-1.0, -1.0, u)]), Some(i(-1.0, 1.0)));
        // (3 + t) / (1 + t) falls from 3 towards 1.
        assert_eq!(of((3.0, 1.0), &[(1.0, 1.0, u)]), Some(i(1.0, 3.0)));
        // A pole, and a denominator without a sign.
        assert_eq!(of((1.0, 0.0), &[(1.0, 1.0, u)]), None);
        assert_eq!(of((1.0, -1.0), &[(1.0, 1.0, u)]), None);
    }

    #[test]
    fn signs() {
        let u = Interval::new(0.0, 1.0);
        assert!(Interval::point(1.0).add(u.scale(-1.0)).nonnegative());
        assert!(u.call(Fun::Ln).nonpositive());
        assert!(u.scale(-1.0).call(Fun::Ln1p).nonpositive());
        assert!(Interval::new(-1.0, 1.0).pow(2.0).nonnegative());
        assert!(!Interval::new(-1.0, 1.0).pow(3.0).nonnegative());
        assert_eq!(Interval::new(-1.0, 2.0).pow(-1.0), Interval::ALL);
    }
}
