//! Arithmetic of intervals with ends that are rounded outward.
//!
//! A result that is exact stays exact (a proof that a slope is not negative often ends at a zero that is attained), and other
//! results are widened: by one unit in the last place where IEEE rounds correctly, by several after a function of `libm`.

use crate::expr::Fun;
use crate::interval::Interval;
use crate::rational::Q;

/// A rational number: integers of some size, halves of them and so on are exact.
pub(super) fn rational(q: Q) -> Interval {
    let exact = q.num().unsigned_abs() < 1 << 53 && q.den().count_ones() == 1;
    let x = Interval::point(q.to_f64());
    if exact { x } else { widen(x, 1) }
}

fn down(x: f64, ulps: u8) -> f64 {
    (0..ulps).fold(x, |x, _| x.next_down())
}
fn up(x: f64, ulps: u8) -> f64 {
    (0..ulps).fold(x, |x, _| x.next_up())
}

/// Larger by some units in the last place on both sides; zero and infinity are never results of
/// rounding here, except underflow, which the next number covers.
pub(super) fn widen(a: Interval, ulps: u8) -> Interval {
    let lo = if a.lo.is_infinite() { a.lo } else { down(a.lo, ulps) };
    let hi = if a.hi.is_infinite() { a.hi } else { up(a.hi, ulps) };
    Interval { lo, hi }
}

/// x + y rounded down or up, exact if the sum is.
fn add_end(x: f64, y: f64, upward: bool) -> f64 {
    let s = x + y;
    if s.is_nan() || x.is_infinite() || y.is_infinite() {
        return s;
    }
    if s.is_infinite() {
        return overflow(s, upward);
    }
    // Knuth's two-sum: the rounding error itself.
    let virtual_y = s - x;
    let error = (x - (s - virtual_y)) + (y - virtual_y);
    match (upward, error) {
        (true, e) if e > 0.0 => s.next_up(),
        (false, e) if e < 0.0 => s.next_down(),
        _ => s,
    }
}

/// An infinity that finite numbers made is a bound on one side only.
fn overflow(s: f64, upward: bool) -> f64 {
    match (upward, s > 0.0) {
        (true, false) => f64::MIN,
        (false, true) => f64::MAX,
        _ => s,
    }
}

/// The sum of two intervals.
pub(super) fn add(a: Interval, b: Interval) -> Interval {
    Interval::new(add_end(a.lo, b.lo, false), add_end(a.hi, b.hi, true))
}

/// x · y rounded down or up, exact if the product is; zero times a bound that is not attained is zero.
fn mul_end(x: f64, y: f64, upward: bool) -> f64 {
    if x == 0.0 || y == 0.0 {
        return 0.0;
    }
    let p = x * y;
    if x.is_infinite() || y.is_infinite() {
        return p;
    }
    if p.is_infinite() {
        return overflow(p, upward);
    }
    let error = libm::fma(x, y, -p);
    let exact = error == 0.0 && p.abs() > 1e-290;
    match (exact, upward) {
        (true, _) => p,
        (false, true) => p.next_up(),
        (false, false) => p.next_down(),
    }
}

/// The product of two intervals.
pub(super) fn mul(a: Interval, b: Interval) -> Interval {
    let one = Interval::point(1.0);
    if a == one || b == one {
        return if a == one { b } else { a };
    }
    let (up, down) = (|x, y| mul_end(x, y, true), |x, y| mul_end(x, y, false));
    // By the signs of the factors two ends of each make the product's.
    match [a, b].map(|i| (i.lo >= 0.0, i.hi <= 0.0)) {
        [(true, _), (true, _)] => Interval::new(down(a.lo, b.lo), up(a.hi, b.hi)),
        [(_, true), (_, true)] => Interval::new(down(a.hi, b.hi), up(a.lo, b.lo)),
        [(true, _), (_, true)] => Interval::new(down(a.hi, b.lo), up(a.lo, b.hi)),
        [(_, true), (true, _)] => Interval::new(down(a.lo, b.hi), up(a.hi, b.lo)),
        [(true, _), _] => Interval::new(down(a.hi, b.lo), up(a.hi, b.hi)),
        [(_, true), _] => Interval::new(down(a.lo, b.hi), up(a.lo, b.lo)),
        [_, (true, _)] => Interval::new(down(a.lo, b.hi), up(a.hi, b.hi)),
        [_, (_, true)] => Interval::new(down(a.hi, b.lo), up(a.lo, b.lo)),
        _ => Interval::new(
            down(a.lo, b.hi).min(down(a.hi, b.lo)),
            up(a.lo, b.lo).max(up(a.hi, b.hi)),
        ),
    }
}

/// base^e, where a base with a fractional exponent is not negative.
pub(super) fn power(base: Interval, e: f64) -> Interval {
    let halves = (2.0 * e).abs();
    match e {
        1.0 => base,
        _ if halves.fract() != 0.0 || halves > 16.0 => {
            let plain = base.pow(e);
            keep_sign(plain, widen(plain, 4))
        }
        _ if e < 0.0 => reciprocal(power(base, -e)),
        _ if e.fract() != 0.0 => whole_power(root(base), halves as u32),
        _ => whole_power(base, e as u32),
    }
}

fn whole_power(base: Interval, e: u32) -> Interval {
    let times = |x: f64, upward: bool| (1..e).fold(x, |p, _| mul_end(p, x, upward));
    // Of the sizes of the ends: both rounded the same way.
    let low = |x: f64| times(x.abs(), false);
    let high = |x: f64| times(x.abs(), true);
    match (e.is_multiple_of(2), base.lo >= 0.0, base.hi <= 0.0) {
        (_, true, _) => Interval::new(low(base.lo), high(base.hi)),
        (true, _, true) => Interval::new(low(base.hi), high(base.lo)),
        (true, ..) => Interval::new(0.0, high(base.lo).max(high(base.hi))),
        (false, _, true) => Interval::new(-high(base.lo), -low(base.hi)),
        (false, ..) => Interval::new(-high(base.lo), high(base.hi)),
    }
}

/// The root of what is not negative, exact if it is.
fn root(base: Interval) -> Interval {
    let end = |x: f64, upward: bool| {
        let r = libm::sqrt(x.max(0.0));
        let exact = r.is_infinite() || r == 0.0 || x > 1e-290 && libm::fma(r, r, -x) == 0.0;
        match (exact, upward) {
            (true, _) => r,
            (false, true) => r.next_up(),
            (false, false) => r.next_down(),
        }
    };
    Interval::new(end(base.lo, false), end(base.hi, true))
}

/// One over an interval; one over an end that is zero is infinite.
fn reciprocal(a: Interval) -> Interval {
    if a.lo < 0.0 && a.hi > 0.0 {
        return Interval::ALL;
    }
    let end = |x: f64, at_zero: f64, upward: bool| {
        if x == 0.0 || x.is_infinite() {
            return if x == 0.0 { at_zero } else { 0.0 };
        }
        let r = 1.0 / x;
        if r.is_infinite() {
            return overflow(r, upward);
        }
        let exact = r.is_normal() && libm::fma(r, x, -1.0) == 0.0;
        match (exact, upward) {
            (true, _) => r,
            (false, true) => r.next_up(),
            (false, false) => r.next_down(),
        }
    };
    Interval::new(end(a.hi, f64::NEG_INFINITY, false), end(a.lo, f64::INFINITY, true))
}

/// base^e for an exponent that is not a number.
pub(super) fn symbolic_power(base: Interval, e: Interval) -> Interval {
    let log = base.call(Fun::Ln);
    if base.lo < 0.0 {
        return Interval::POSITIVE;
    }
    let exponent = mul(widen(log, 4), e);
    call(Fun::Exp, exponent)
}

/// A widened interval that does not reach over a zero that the function itself never crosses.
fn keep_sign(plain: Interval, wide: Interval) -> Interval {
    Interval {
        lo: if plain.lo >= 0.0 { wide.lo.max(0.0) } else { wide.lo },
        hi: if plain.hi <= 0.0 { wide.hi.min(0.0) } else { wide.hi },
    }
}

/// The values of a function over an interval.
pub(super) fn call(f: Fun, a: Interval) -> Interval {
    let plain = match f {
        Fun::Cos => cosine(a),
        Fun::Sin => sine(a),
        Fun::Cosh => cosh(a),
        _ => return special(f, a),
    };
    let (lo, hi) = (plain.lo.max(-1.0), if f == Fun::Cosh { plain.hi } else { plain.hi.min(1.0) });
    Interval::new(lo, hi)
}

fn special(f: Fun, a: Interval) -> Interval {
    let plain = a.call(f);
    let exact = matches!(f, Fun::Abs | Fun::Sign | Fun::Turn);
    if exact || plain == Interval::ALL {
        return plain;
    }
    let wide = keep_sign(plain, widen(plain, 4));
    let (least, most) = match f {
        Fun::Tanh => (-1.0, 1.0),
        Fun::Exp => (0.0, f64::INFINITY),
        Fun::ExpM1 => (-1.0, f64::INFINITY),
        _ => (f64::NEG_INFINITY, f64::INFINITY),
    };
    Interval { lo: wide.lo.max(least), hi: wide.hi.min(most) }
}

/// Larger arguments are not told apart by their quadrants.
const MANY_TURNS: f64 = 1e6;

fn cosine(a: Interval) -> Interval {
    let pi = std::f64::consts::PI;
    if !(a.lo >= -MANY_TURNS && a.hi <= MANY_TURNS) {
        return Interval::new(-1.0, 1.0);
    }
    // Extremes at k π; near one, both sides count.
    let (first, last) = ((a.lo / pi - 1e-9).ceil(), (a.hi / pi + 1e-9).floor());
    let ends = widen(Interval::point(libm::cos(a.lo)).hull(Interval::point(libm::cos(a.hi))), 4);
    let mut out = ends;
    let mut k = first;
    while k <= last && k < first + 2.0 {
        let extreme = if k.rem_euclid(2.0) == 0.0 { 1.0 } else { -1.0 };
        out = out.hull(Interval::point(extreme));
        k += 1.0;
    }
    out
}

fn sine(a: Interval) -> Interval {
    let half = std::f64::consts::FRAC_PI_2;
    let shifted = cosine(widen(Interval::new(a.lo - half, a.hi - half), 2));
    // Just above zero the sine is not negative.
    if a.lo == 0.0 && a.hi <= 3.0 {
        return Interval::new(0.0, shifted.hi);
    }
    shifted
}

fn cosh(a: Interval) -> Interval {
    let size = a.call(Fun::Abs);
    let ends = widen(Interval::new(libm::cosh(size.lo), libm::cosh(size.hi)), 4);
    Interval::new(ends.lo.max(1.0), ends.hi)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn exact_results_stay_exact() {
        let unit = Interval::new(0.0, 1.0);
        assert_eq!(add(Interval::point(1.0), mul(Interval::point(-1.0), unit)), unit);
        assert_eq!(power(Interval::new(-2.0, 1.0), 3.0), Interval::new(-8.0, 1.0));
        assert_eq!(power(Interval::new(0.25, 4.0), -1.5), Interval::new(0.125, 8.0));
        assert_eq!(power(Interval::new(-2.0, 4.0), -2.0), Interval::new(0.0625, f64::INFINITY));
        assert_eq!(power(Interval::new(-2.0, 4.0), -1.0), Interval::ALL);
        let (third, root) = (power(Interval::point(3.0), -1.0), power(Interval::point(2.0), 0.5));
        assert!(third.lo < 1.0 / 3.0 && third.hi > third.lo.next_up() && root.width() > 0.0);
        assert!(add(Interval::point(0.1), Interval::point(0.2)).hi > 0.3);
        assert!(sine(Interval::new(0.0, 1.0)).nonnegative());
        assert!(!sine(Interval::new(0.0, 3.2)).nonnegative());
        assert_eq!(cosine(Interval::new(-1.0, 1.0)).hi, 1.0);
    }
}
