//! Intervals that certainly contain every value of an expression over a box of inputs: the
//! arithmetic of proofs.
//!
//! Ends are rounded outward. A result that is exact stays exact (a proof that a slope is not negative
//! often ends at a zero that is attained), and other results are widened: by one unit in the last place
//! where IEEE rounds correctly, by several after a function of `libm`.

use std::collections::HashMap;

use crate::expr::{Fun, Graph, Id, Leaf, Node, children};
use crate::interval::Interval;

/// Expressions in an order in which every part comes before the whole.
pub struct Enclosure {
    order: Vec<Id>,
    place: HashMap<Id, usize>,
}

impl Enclosure {
    /// For these expressions.
    pub fn new(g: &Graph, ids: &[Id]) -> Enclosure {
        let mut order = Vec::new();
        let mut place = HashMap::new();
        let mut open: Vec<(Id, bool)> = ids.iter().rev().map(|i| (*i, false)).collect();
        while let Some((id, ready)) = open.pop() {
            if place.contains_key(&id) {
                continue;
            }
            if ready {
                place.insert(id, order.len());
                order.push(id);
            } else {
                open.push((id, true));
                open.extend(children(g.node(id)).into_iter().map(|c| (c, false)));
            }
        }
        Enclosure { order, place }
    }

    /// The intervals of all parts over a box; [`get`](Self::get) picks one of them.
    pub fn over(&self, g: &Graph, region: &dyn Fn(Leaf) -> Interval) -> Vec<Interval> {
        let mut values: Vec<Interval> = Vec::with_capacity(self.order.len());
        for &id in &self.order {
            let value = node(g, id, region, &|part| values[self.place[&part]]);
            values.push(value);
        }
        values
    }

    /// The interval of one of the expressions.
    pub fn get(&self, values: &[Interval], id: Id) -> Interval {
        values[self.place[&id]]
    }
}

fn node(
    g: &Graph,
    id: Id,
    region: &dyn Fn(Leaf) -> Interval,
    part: &dyn Fn(Id) -> Interval,
) -> Interval {
    match g.node(id) {
        Node::Number(q) => {
            let x = q.to_f64();
            // Integers of this size and halves of them are exact.
            let exact = q.num().unsigned_abs() < 1 << 53 && q.den().count_ones() == 1;
            if exact { Interval::point(x) } else { widen(Interval::point(x), 1) }
        }
        Node::Float(bits) => Interval::point(f64::from_bits(*bits)),
        Node::Pi => widen(Interval::point(std::f64::consts::PI), 1),
        Node::Leaf(l) => region(*l),
        Node::Sum(c, terms) => {
            let constant = Interval::point(c.to_f64());
            let constant = if c.is_int() { constant } else { widen(constant, 1) };
            terms.iter().fold(constant, |s, (q, t)| {
                let k = Interval::point(q.to_f64());
                let k = if q.is_int() { k } else { widen(k, 1) };
                add(s, mul(k, part(*t)))
            })
        }
        Node::Product(factors) => {
            let powers = factors.iter().map(|(b, e)| match g.as_number(*e) {
                Some(q) if q == crate::rational::Q::ONE => part(*b),
                Some(q) => power(part(*b), q.to_f64()),
                None => symbolic_power(part(*b), part(*e)),
            });
            powers.fold(Interval::point(1.0), mul)
        }
        Node::Call(f, args) => match args[..] {
            [a] => call(*f, part(a)),
            _ => widen(g.range(id), 8),
        },
        Node::If(test, yes, no) => {
            let test = part(*test);
            if test.lo > 0.0 {
                part(*yes)
            } else if test.hi <= 0.0 {
                part(*no)
            } else {
                part(*yes).hull(part(*no))
            }
        }
        Node::Root(r) if r.inside => Interval::new(part(r.lo).lo, part(r.hi).hi),
        Node::Root(_) => Interval::ALL,
    }
}

fn down(x: f64, ulps: u8) -> f64 {
    (0..ulps).fold(x, |x, _| x.next_down())
}
fn up(x: f64, ulps: u8) -> f64 {
    (0..ulps).fold(x, |x, _| x.next_up())
}

/// Larger by some units in the last place on both sides; zero and infinity are never results of
/// rounding here, except underflow, which the next number covers.
fn widen(a: Interval, ulps: u8) -> Interval {
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

fn add(a: Interval, b: Interval) -> Interval {
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

fn mul(a: Interval, b: Interval) -> Interval {
    let ends = [(a.lo, b.lo), (a.lo, b.hi), (a.hi, b.lo), (a.hi, b.hi)];
    let lo = ends.iter().map(|(x, y)| mul_end(*x, *y, false)).fold(f64::INFINITY, f64::min);
    let hi = ends.iter().map(|(x, y)| mul_end(*x, *y, true)).fold(f64::NEG_INFINITY, f64::max);
    Interval::new(lo, hi)
}

/// base^e, where a base with a fractional exponent is not negative.
fn power(base: Interval, e: f64) -> Interval {
    let small = e.fract() == 0.0 && (2.0..=8.0).contains(&e);
    if small {
        let even = e % 2.0 == 0.0;
        let times = |x: f64, upward: bool| (1..e as u32).fold(x, |p, _| mul_end(p, x, upward));
        // Of the sizes of the ends: both rounded the same way.
        let low = |x: f64| times(x.abs(), false);
        let high = |x: f64| times(x.abs(), true);
        return match (even, base.lo >= 0.0, base.hi <= 0.0) {
            (_, true, _) => Interval::new(low(base.lo), high(base.hi)),
            (true, _, true) => Interval::new(low(base.hi), high(base.lo)),
            (true, ..) => Interval::new(0.0, high(base.lo).max(high(base.hi))),
            (false, _, true) => Interval::new(-high(base.lo), -low(base.hi)),
            (false, ..) => Interval::new(-high(base.lo), high(base.hi)),
        };
    }
    keep_sign(base.pow(e), widen(base.pow(e), 4))
}

fn symbolic_power(base: Interval, e: Interval) -> Interval {
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

fn call(f: Fun, a: Interval) -> Interval {
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
    use crate::eval::evaluate;
    use crate::number::{Dd, Number};
    use crate::points::Rng;
    use crate::rational::Q;

    #[test]
    fn exact_results_stay_exact() {
        let unit = Interval::new(0.0, 1.0);
        assert_eq!(add(Interval::point(1.0), mul(Interval::point(-1.0), unit)), unit);
        assert_eq!(power(Interval::new(-2.0, 1.0), 3.0), Interval::new(-8.0, 1.0));
        assert!(add(Interval::point(0.1), Interval::point(0.2)).hi > 0.3);
        assert!(sine(Interval::new(0.0, 1.0)).nonnegative());
        assert!(!sine(Interval::new(0.0, 3.2)).nonnegative());
        assert_eq!(cosine(Interval::new(-1.0, 1.0)).hi, 1.0);
    }

    /// Every value at points of a box, computed in double-double, lies in the enclosure.
    #[test]
    fn values_lie_inside() {
        let mut g = Graph::new();
        let x = g.leaf(Leaf::Unknown(0), "x", Interval::ALL);
        let y = g.leaf(Leaf::Unknown(1), "y", Interval::ALL);
        let mut rng = Rng::new(5);
        let functions = [
            Fun::Exp,
            Fun::ExpM1,
            Fun::Sin,
            Fun::Cos,
            Fun::Tanh,
            Fun::Cosh,
            Fun::Sinh,
            Fun::Atan,
            Fun::Asinh,
            Fun::Abs,
        ];
        for round in 0..600 {
            let f = functions[round % functions.len()];
            let (px, py) = (g.powi(x, 2 + round as i64 % 4), g.call(f, &[y]));
            let third = Q::new(1, 3).unwrap();
            let inner = g.sum(third, &[(Q::ONE, px), (Q::int(-2), py)]);
            let product = g.mul(inner, py);
            let e = Enclosure::new(&g, &[product]);
            let mut boxed = || {
                let (lo, width) = (6.0 * rng.uniform() - 3.0, rng.uniform() * rng.uniform());
                Interval::new(lo, lo + width)
            };
            let (bx, by) = (boxed(), boxed());
            let region = |l: Leaf| if l == Leaf::Unknown(0) { bx } else { by };
            let enclosed = e.get(&e.over(&g, &region), product);
            for corner in 0..9 {
                let inside = |b: Interval, k: usize| b.lo + b.width() * [0.0, 0.37, 1.0][k];
                let at = |l: Leaf| {
                    let v = if l == Leaf::Unknown(0) {
                        inside(bx, corner % 3)
                    } else {
                        inside(by, corner / 3)
                    };
                    Dd::from_f64(v.clamp(region(l).lo, region(l).hi))
                };
                let v = evaluate::<Dd>(&g, product, &at);
                let (below, above) = (v - Dd::from_f64(enclosed.lo), Dd::from_f64(enclosed.hi) - v);
                assert!(
                    below.to_f64() >= 0.0 && above.to_f64() >= 0.0,
                    "{f:?} {bx:?} {by:?} {v:?} {enclosed:?}"
                );
            }
        }
    }
}
