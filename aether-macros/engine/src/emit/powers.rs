//! How two powers of one base are related: of u^(1/k) and u^(1 - 1/k) only one has to be computed, and v^(3/2) is v √v, of
//! which others may have the root.

use crate::eval::evaluate;
use crate::expr::{Graph, Id, Leaf, Node};
use crate::number::{Dd, Number};
use crate::rational::Q;

/// How a power follows from another power of its base: it is so many `times` that one, as factors, and `whole` times
/// the base, above or below the line.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Related {
    /// 1 or 2, or minus that.
    pub times: i8,
    /// -1, 0 or 1; none below the line where the other power is there as well.
    pub whole: i8,
}

/// How b^e follows from b^f, by the values of the exponents at a few inputs: as sums and quotients of parameters
/// they may be written in many ways.
pub(super) fn related(g: &Graph, e: Id, f: Id) -> Option<Related> {
    let whole = |times: i8| {
        let mut found = None;
        for round in 0..3 {
            let input = |leaf: Leaf| Dd::from_f64(value_of(leaf, round));
            let [a, b] = [e, f].map(|id| evaluate::<Dd>(g, id, &input));
            let rest = a - b * Dd::from_f64(f64::from(times));
            let nearest = rest.to_f64().round();
            let off = (rest - Dd::from_f64(nearest)).to_f64().abs();
            let same = found.is_none_or(|known| known == nearest);
            if !(off < 1e-24 * (1.0 + a.to_f64().abs()) && same) {
                return None;
            }
            found = Some(nearest);
        }
        found
    };
    [1, -1, 2, -2].into_iter().find_map(|times| {
        let least = if times < 0 { 0 } else { -1 };
        let whole = whole(times).filter(|whole| (f64::from(least)..=1.0).contains(whole))?;
        Some(Related { times, whole: whole as i8 })
    })
}

/// Some number for an input, between one quarter and one: another one in each round.
fn value_of(leaf: Leaf, round: u32) -> f64 {
    let place = match leaf {
        Leaf::Param(i) => u32::from(i),
        Leaf::Unknown(i) => 64 + u32::from(i),
        Leaf::Out(i) => 128 + u32::from(i),
        Leaf::Bound(i) => 192 + u32::from(i),
    };
    let golden = 0.618_033_988_749_895;
    0.25 + 0.75 * (golden * f64::from(3 * place + round + 1)).fract()
}

/// The power 3/2 of a product, or that below the line.
#[derive(Debug, PartialEq, Eq)]
pub(super) struct ThreeHalves {
    /// The factors in the order of the expression; `None` stands for the number, which is not there if it is one.
    pub factors: Vec<Option<Id>>,
    /// The number.
    pub number: Q,
    /// Whether it divides.
    pub below: bool,
}

/// An expression as such a power of more than one factor: 4 u^(3/2) v^(3/2) / √2 is that of 2 u v.
pub(super) fn three_halves(g: &Graph, id: Id) -> Option<ThreeHalves> {
    let (q, body) = match g.node(id) {
        Node::Sum(c, terms) if c.is_zero() && terms.len() == 1 => terms[0],
        _ => (Q::ONE, id),
    };
    let Node::Product(powers) = g.node(body) else { return None };
    let (mut square, mut power, mut factors) = (q.powi(2)?, None, Vec::new());
    for &(base, exponent) in powers {
        let exponent = g.as_number(exponent)?;
        let twice = exponent.mul(Q::int(2)).filter(|twice| twice.is_int())?;
        if let Some(base) = g.as_number(base) {
            square = square.mul(base.powi(i64::from(twice.to_i32()?))?)?;
            factors.push(None);
            continue;
        }
        if twice.abs() != Q::int(3) || power.is_some_and(|power| power != exponent) {
            return None;
        }
        power = Some(exponent);
        factors.push(Some(base));
    }
    let below = power?.is_negative();
    let number = if below { square.recip()? } else { square }.cbrt()?;
    let numbers = factors.iter().filter(|factor| factor.is_none()).count();
    match numbers {
        _ if number == Q::ONE => factors.retain(Option::is_some),
        0 => factors.insert(0, None),
        _ => {}
    }
    (!q.is_negative() && numbers < 2 && factors.len() > 1).then_some(ThreeHalves {
        factors,
        number,
        below,
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::interval::Interval;

    #[test]
    fn three_halves_of_a_product_are_found_with_its_number() {
        let mut g = Graph::new();
        let [u, v] = [0, 1].map(|i| g.leaf(Leaf::Unknown(i), "u", Interval::new(0.0, 1.0)));
        let (two, half) = (g.int(2), Q::HALF);
        let (three, below) = (Q::new(3, 2).unwrap(), half.neg());
        let product = |g: &mut Graph, q: i64, of: &[(Id, Q)]| {
            let factors: Vec<_> = of.iter().map(|&(base, e)| (base, g.number(e))).collect();
            let body = g.product(&factors);
            g.sum(Q::ZERO, &[(Q::int(q), body)])
        };
        let density = product(&mut g, 4, &[(u, three), (v, three), (two, below)]);
        let found = three_halves(&g, density).unwrap();
        assert_eq!((found.number, found.below, found.factors.len()), (Q::int(2), false, 3));
        let below_line = product(&mut g, 1, &[(u, three.neg()), (v, three.neg())]);
        let found = three_halves(&g, below_line).unwrap();
        assert_eq!((found.number, found.below), (Q::ONE, true));
        // 2 / √2 is no power 3/2 of a rational number, nor are roots or two different powers.
        let others = [
            product(&mut g, 3, &[(u, three), (v, three), (two, below)]),
            product(&mut g, 1, &[(u, half), (v, half)]),
            product(&mut g, 1, &[(u, three), (v, half)]),
            product(&mut g, 1, &[(u, three)]),
            product(&mut g, -1, &[(u, three), (v, three)]),
        ];
        assert!(others.into_iter().all(|other| three_halves(&g, other).is_none()));
    }

    #[test]
    fn exponents_that_add_up_to_one() {
        let mut g = Graph::new();
        let k = g.leaf(Leaf::Param(0), "k", Interval::new(1.0, 9.0));
        let one = g.int(1);
        let more = g.add(k, one);
        let (inverse, share, rest) = (g.div(one, k), g.div(k, more), g.div(one, more));
        let less = g.sub(one, inverse);
        let minus = g.neg(inverse);
        let beyond = g.add(inverse, one);
        let by = |times, whole| Some(Related { times, whole });
        assert_eq!(related(&g, less, inverse), by(-1, 1));
        assert_eq!(related(&g, share, rest), by(-1, 1));
        assert_eq!(related(&g, minus, inverse), by(-1, 0));
        assert_eq!(related(&g, beyond, inverse), by(1, 1));
        assert_eq!(related(&g, inverse, beyond), by(1, -1));
        assert_eq!(related(&g, share, inverse), None);
        let twice = g.sum(Q::ZERO, &[(Q::int(2), inverse)]);
        assert_eq!(related(&g, twice, inverse), by(2, 0));
        let beside = g.sum(Q::ONE, &[(Q::int(-2), inverse)]);
        assert_eq!(related(&g, beside, inverse), by(-2, 1));
        let thrice = g.sum(Q::ZERO, &[(Q::int(3), inverse)]);
        assert_eq!(related(&g, thrice, inverse), None);
    }
}
