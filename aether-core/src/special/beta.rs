//! The incomplete beta function and its inverse.
//!
//! In double precision, a lane at a time, on `libm` alone: the bits are the same everywhere.

use core::f64::consts::TAU;

use crate::real::Real;

/// ln Γ(n + 1) - n ln n + n for n >= 0, which grows like a logarithm.
fn stirling(n: f64) -> f64 {
    if n == 0.0 {
        return 0.0;
    }
    if n < 10.0 {
        return libm::log(libm::tgamma(n + 1.0) * libm::exp(n) / libm::pow(n, n));
    }
    /// B₂ₖ / (2k (2k - 1)) for k = 1, 2, …: Stirling's series.
    const SERIES: [f64; 9] = [
        1.0 / 12.0,
        -1.0 / 360.0,
        1.0 / 1260.0,
        -1.0 / 1680.0,
        1.0 / 1188.0,
        -691.0 / 360_360.0,
        1.0 / 156.0,
        -3617.0 / 122_400.0,
        43867.0 / 244_188.0,
    ];
    let square = 1.0 / (n * n);
    let sum = SERIES.iter().rev().fold(0.0, |sum, c| sum * square + c);
    0.5 * libm::log(TAU * n) + sum / n
}

/// z - ln(1 + z), where the ratio is 1 + z.
fn excess(z: f64, ratio: f64) -> f64 {
    if z.abs() > 0.5 {
        return z - libm::log(ratio);
    }
    // ln(1 + z) = 2 artanh r with r = z / (2 + z), and z - 2 r = r z.
    let r = z / (2.0 + z);
    let square = r * r;
    let sum = (1..18).rev().fold(0.0, |sum, k| sum * square + 1.0 / f64::from(2 * k + 1));
    r * (z - 2.0 * square * sum)
}

/// ln B(a, b).
fn ln_beta_of(a: f64, b: f64) -> f64 {
    let n = a + b;
    let powers = a * libm::log1p(b / a) + b * libm::log1p(a / b);
    (stirling(a) + stirling(b) - stirling(n)) - powers - libm::log(a) + libm::log1p(a / b)
}

/// x^a y^b / B(a, b) with y = 1 - x: the density of ln(x / y). By its distance from the mode, so that
/// large parameters cost no digits (Loader, "Fast and accurate computation of binomial probabilities",
/// 2000).
fn weight(a: f64, b: f64, x: f64, y: f64) -> f64 {
    let n = a + b;
    let front = a * (b / n) * libm::exp(stirling(n) - stirling(a) - stirling(b));
    let (t, of_x, of_y) = (a * y - b * x, n * x / a, n * y / b);
    let distance = a * excess(-t / a, of_x) + b * excess(t / b, of_y);
    // Far out, with small exponents, powers round less than the exponential of a large number.
    front
        * if distance > n { libm::pow(of_x, a) * libm::pow(of_y, b) } else { libm::exp(-distance) }
}

/// The continued fraction f of I(x; a, b) = weight / f, by the algorithm of Lentz; it converges fast for
/// x up to the mean (Didonato and Morris, "Algorithm 708", 1992).
fn fraction(a: f64, b: f64, x: f64, y: f64) -> f64 {
    let guarded = |z: f64| if z == 0.0 { f64::MIN_POSITIVE } else { z };
    let mut f = guarded(a * ((a * y - b * x) + 1.0) / (a + 1.0));
    let (mut c, mut d) = (f, 0.0);
    for k in 1..10_000 {
        let m = f64::from(k);
        let odd = a + 2.0 * m - 1.0;
        let top = (a + m - 1.0) * x / odd * ((a + b + m - 1.0) / odd) * m * (b - m) * x;
        let rest = (a + m) * (a * y - b * x + 1.0 + m * (1.0 + y)) / (a + 2.0 * m + 1.0);
        let bottom = m + m * (b - m) * x / odd + rest;
        c = guarded(bottom + top / c);
        d = 1.0 / guarded(bottom + top * d);
        f *= c * d;
        if (c * d - 1.0).abs() <= f64::EPSILON {
            break;
        }
    }
    f
}

/// I(x; a, b), the rest to one, and the derivative by ln(x / y), where y = 1 - x. Neither of the two is
/// one minus the other where it is small.
fn tails(a: f64, b: f64, x: f64, y: f64) -> [f64; 3] {
    const SMALL: f64 = 0.125;
    let w = weight(a, b, x, y);
    let (below, above) = (|| w / fraction(a, b, x, y), || w / fraction(b, a, y, x));
    let (mut low, mut high);
    if x <= (a + 1.0) / (a + b + 2.0) {
        low = below().min(1.0);
        high = 1.0 - low;
        if high < SMALL {
            high = above();
        }
    } else {
        high = above().min(1.0);
        low = 1.0 - high;
        if low < SMALL {
            low = below();
        }
    }
    [low, high, w]
}

/// x and 1 - x for I(x; a, b) = p up to one half: Newton's method on ln I, which is concave in
/// ln(x / y), so that it converges from everywhere.
fn lower_quantile(a: f64, b: f64, p: f64) -> [f64; 2] {
    /// Smaller numbers lose digits.
    const LEAST: f64 = 1e-307;
    let moved = |[x, y]: [f64; 2], step: f64| {
        let x = x * libm::exp(step);
        let sum = x + y;
        [(x / sum).max(LEAST), (y / sum).max(LEAST)]
    };
    let mut at = [a / (a + b), b / (a + b)];
    let (mut last, mut step) = (at, 0.0);
    for _ in 0..200 {
        let [low, _, w] = tails(a, b, at[0], at[1]);
        if low < f64::MIN_POSITIVE {
            // Too far: nothing is left of the function here.
            step *= 0.5;
            at = moved(last, step);
            continue;
        }
        let error = (low - p) / p;
        let near = error.abs() < 0.5;
        let error = if near { libm::log1p(error) } else { libm::log(low) - libm::log(p) };
        step = (-error * low / w).clamp(-300.0, 300.0);
        if at[0] <= LEAST && step < 0.0 {
            return [0.0, 1.0];
        }
        last = at;
        at = moved(at, step);
        if step.abs() < 1e-9 {
            break;
        }
    }
    at
}

fn in_domain(a: f64, b: f64, x: f64) -> bool {
    a > 0.0 && b > 0.0 && a + b < f64::INFINITY && (0.0..=1.0).contains(&x)
}

/// I(x; a, b), and the rest to one.
fn incomplete(a: f64, b: f64, x: f64) -> [f64; 2] {
    if !in_domain(a, b, x) {
        return [f64::NAN; 2];
    }
    if x == 0.0 || x == 1.0 {
        return [x, 1.0 - x];
    }
    let [low, high, _] = tails(a, b, x, 1.0 - x);
    [low, high]
}

/// The x with I(x; a, b) = p, and the rest to one.
fn quantile(a: f64, b: f64, p: f64) -> [f64; 2] {
    if !in_domain(a, b, p) {
        return [f64::NAN; 2];
    }
    if p == 0.0 || p == 1.0 {
        return [p, 1.0 - p];
    }
    if p <= 0.5 {
        return lower_quantile(a, b, p);
    }
    let [rest, x] = lower_quantile(b, a, 1.0 - p);
    [x, rest]
}

/// A function of doubles, one lane after the other.
fn by_lane<R: Real>(f: impl Fn([f64; 3]) -> f64, arguments: [R; 3]) -> R {
    R::from_lanes(|i| R::Lane::of(f(arguments.map(|x| x.lane(i).to_f64()))))
}

pub(super) fn beta_inc<R: Real>(a: R, b: R, x: R) -> R {
    by_lane(|[a, b, x]| incomplete(a, b, x)[0], [a, b, x])
}

/// I(1 - y; a, b) is what I(y; b, a) leaves of one.
pub(super) fn beta_inc_rest<R: Real>(a: R, b: R, y: R) -> R {
    by_lane(|[a, b, y]| incomplete(b, a, y)[1], [a, b, y])
}

pub(super) fn beta_inc_inv<R: Real>(a: R, b: R, p: R) -> R {
    by_lane(|[a, b, p]| quantile(a, b, p)[0], [a, b, p])
}

/// The x with I(x; a, b) = 1 - q is what that with I(x; b, a) = q leaves of one.
pub(super) fn beta_inc_inv_rest<R: Real>(a: R, b: R, q: R) -> R {
    by_lane(|[a, b, q]| quantile(b, a, q)[1], [a, b, q])
}

pub(super) fn ln_beta<R: Real>(a: R, b: R) -> R {
    by_lane(|[a, b, _]| if in_domain(a, b, 0.0) { ln_beta_of(a, b) } else { f64::NAN }, [a, b, b])
}
