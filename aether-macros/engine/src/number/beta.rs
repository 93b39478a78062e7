//! The incomplete beta function and its inverse, at any precision.

use super::{Dd, Number};

/// Numbers of this trait's precision that are written in the code.
fn of<T: Number>(x: f64) -> T {
    T::from_f64(x)
}

/// ln B(a, b).
pub(super) fn ln_beta<T: Number>(a: T, b: T) -> T {
    a.ln_gamma() + b.ln_gamma() - (a + b).ln_gamma()
}

/// A point x with y = 1 - x, neither of which loses digits.
#[derive(Clone, Copy)]
struct Point<T> {
    x: T,
    y: T,
}

impl<T: Number> Point<T> {
    fn flipped(self) -> Self {
        Point { x: self.y, y: self.x }
    }

    /// ln(x / y) enlarged by a step.
    fn moved(self, step: T) -> Self {
        let x = (self.x * step.exp()).max(of(LEAST));
        let (sum, y) = (x + self.y, self.y);
        Point { x: x / sum, y: (y / sum).max(of(LEAST)) }
    }
}

/// Smaller numbers lose digits.
const LEAST: f64 = 1e-305;

/// The distribution: a, b and ln B(a, b).
#[derive(Clone, Copy)]
struct Beta<T> {
    a: T,
    b: T,
    ln_beta: T,
}

impl<T: Number> Beta<T> {
    fn new(a: T, b: T) -> Self {
        Beta { a, b, ln_beta: ln_beta(a, b) }
    }

    /// The distribution of 1 - x.
    fn flipped(self) -> Self {
        Beta { a: self.b, b: self.a, ..self }
    }

    /// x^a y^b / B(a, b).
    fn weight(self, p: Point<T>) -> T {
        (self.a * p.x.ln() + self.b * p.y.ln() - self.ln_beta).exp()
    }

    /// The continued fraction f of I(x; a, b) = weight / f, by the algorithm of Lentz.
    fn fraction(self, Point { x, y }: Point<T>) -> T {
        let Beta { a, b, .. } = self;
        let one = of::<T>(1.0);
        let mean = a * y - b * x + one;
        let mut f = a * mean / (a + one);
        let (mut c, mut d) = (f, of::<T>(0.0));
        for k in 1..10_000 {
            let m = of::<T>(f64::from(k));
            let odd = a + m + m - one;
            let first = m * x / odd;
            let top = (a + m - one) * (a + b + m - one) * first * (b - m) * x / odd;
            let rest = (a + m) * (mean + m * (one + y)) / (odd + one + one);
            let bottom = m + (b - m) * first + rest;
            c = bottom + top / c;
            d = one / (bottom + top * d);
            f = f * (c * d);
            // As close as its precision allows, or as close as it gets.
            if (c * d - one).abs().to_f64() <= 1e-31 {
                break;
            }
        }
        f
    }

    /// I(x; a, b), the rest to one, and the derivative by ln(x / y). Neither of the two is one minus the
    /// other where it is small.
    fn tails(self, p: Point<T>) -> [T; 3] {
        let (one, weight) = (of::<T>(1.0), self.weight(p));
        let below = || weight / self.fraction(p);
        let above = || weight / self.flipped().fraction(p.flipped());
        let small = |part: T| part.to_f64() < 0.125;
        if p.x <= (self.a + one) / (self.a + self.b + of(2.0)) {
            let low = below();
            [low, if small(one - low) { above() } else { one - low }, weight]
        } else {
            let high = above();
            [if small(one - high) { below() } else { one - high }, high, weight]
        }
    }

    /// Newton's method on ln I, which is concave in ln(x / y), for I(x; a, b) = p; `None` if x underflows.
    fn newton(self, p: T, start: Point<T>, tolerance: f64) -> Option<Point<T>> {
        let (mut at, mut last, mut step) = (start, start, of::<T>(0.0));
        for _ in 0..100 {
            let [low, _, weight] = self.tails(at);
            if low.to_f64() < f64::MIN_POSITIVE {
                // Too far: nothing is left of the function here.
                step = step * of(0.5);
                at = last.moved(step);
                continue;
            }
            let error = (low - p) / p;
            let near = error.abs().to_f64() < 0.5;
            let error = if near { error.ln_1p() } else { low.ln() - p.ln() };
            step = (-(error * low / weight)).max(of(-300.0)).min(of(300.0));
            if at.x.to_f64() <= LEAST && step.to_f64() < 0.0 {
                return None;
            }
            last = at;
            at = at.moved(step);
            if step.abs().to_f64() < tolerance {
                break;
            }
        }
        Some(at)
    }
}

fn in_domain(a: Dd, b: Dd, x: Dd) -> bool {
    let inside = a > Dd::ZERO && b > Dd::ZERO && x >= Dd::ZERO && x <= Dd::ONE;
    inside && (a + b).is_finite()
}

/// Numbers that add up to one, the smaller as it is.
fn both([x, rest]: [Dd; 2]) -> [Dd; 2] {
    if x <= rest { [x, Dd::ONE - x] } else { [Dd::ONE - rest, rest] }
}

/// I(x; a, b) of x and 1 - x.
pub(super) fn incomplete(x: [Dd; 2], a: Dd, b: Dd) -> Dd {
    let [x, y] = both(x);
    if !in_domain(a, b, x) {
        return Dd::from_f64(f64::NAN);
    }
    if x == Dd::ZERO || x == Dd::ONE {
        return x;
    }
    Beta::new(a, b).tails(Point { x, y })[0]
}

/// The x with I(x; a, b) = p, of p and 1 - p.
pub(super) fn quantile(p: [Dd; 2], a: Dd, b: Dd) -> Dd {
    let [p, q] = both(p);
    if !in_domain(a, b, p) {
        return Dd::from_f64(f64::NAN);
    }
    if p == Dd::ZERO || p == Dd::ONE {
        return p;
    }
    let lower = p <= q;
    let beta = Beta::new(a, b);
    let (beta, p) = if lower { (beta, p) } else { (beta.flipped(), q) };
    let rough = Beta { a: beta.a.to_f64(), b: beta.b.to_f64(), ln_beta: beta.ln_beta.to_f64() };
    let n = rough.a + rough.b;
    let mean = Point { x: rough.a / n, y: rough.b / n };
    let found = rough.newton(p.to_f64(), mean, 1e-8).and_then(|Point { x, y }| {
        let (x, y) = (Dd::from_f64(x), Dd::from_f64(y));
        beta.newton(p, Point { x, y }.moved(Dd::ZERO), 1e-17)
    });
    let Point { x, y } = found.unwrap_or(Point { x: Dd::ZERO, y: Dd::ONE });
    if lower { x } else { y }
}
