//! How two powers of one base are related: of u^(1/k) and u^(1 - 1/k) only one has to be computed.

use crate::eval::evaluate;
use crate::expr::{Graph, Id, Leaf};
use crate::number::{Dd, Number};

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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::interval::Interval;
    use crate::rational::Q;

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
