//! General powers that belong together: aⁿ / (√b)ⁿ is (a / √b)ⁿ, whose parts stay in range where large powers do not.

use super::{Graph, Id, Node};
use crate::rational::Q;

/// Powers of one exponent.
pub struct Together {
    /// The exponent, that of one of the factors.
    pub exponent: Id,
    /// What it is an exponent of: the product of these powers.
    pub inside: Vec<(Id, Q)>,
    /// Powers that are left over.
    pub outside: Vec<(Id, Q)>,
    /// The factors that all these make up.
    factors: Vec<(Id, Id)>,
}

impl Together {
    /// Whether a factor is one of those that have been taken together.
    pub fn contains(&self, factor: &(Id, Id)) -> bool {
        self.factors.contains(factor)
    }
}

impl Graph {
    /// Integer powers, from squares on, that several factors have in them, above and below the line or on the same side:
    /// that of their product or quotient is shorter and stays in range. It is negative where all are below the line.
    pub fn shared_powers(&self, factors: &[(Id, Id)]) -> Vec<Q> {
        let mut exponents: Vec<(Id, Q)> = Vec::new();
        for &(base, exponent) in factors {
            match self.node(exponent) {
                Node::Number(q) if q.den() == 1 && q.num().abs() > 1 => exponents.push((base, *q)),
                _ => {}
            }
        }
        let mut shared: Vec<Q> = Vec::new();
        if exponents.len() < 2 {
            return shared; // Products are evaluated often, and mostly have no such powers.
        }
        for &(base, q) in &exponents {
            let known = |power: &Q| power.abs() == q.abs();
            // Numbers on one side are a factor by themselves.
            let within = |&(b, e): &(Id, Q)| {
                let on_one_side = e.is_negative() == q.is_negative() && e.abs() >= q.abs();
                b != base && on_one_side && self.deps(b) != 0 && self.deps(base) != 0
            };
            let opposite = exponents.iter().any(|(_, e)| *e == q.neg());
            if (opposite || exponents.iter().any(within)) && !shared.iter().any(known) {
                shared.push(if opposite { q.abs() } else { q });
            }
        }
        shared
    }

    /// The factors whose exponents are multiples of one another, but for numbers, where some are above and others below
    /// the line.
    pub fn powers_together(&self, factors: &[(Id, Id)]) -> Option<Together> {
        let mut general: Vec<(Id, Id)> = Vec::new();
        for factor in factors {
            if self.as_number(factor.1).is_none() {
                general.push(*factor);
            }
        }
        if general.len() < 2 {
            return None;
        }
        general.iter().find_map(|&(_, exponent)| {
            let (constant, _) = self.linear(exponent);
            let (mut inside, mut outside, mut taken) = (vec![], vec![], vec![]);
            for &(b, e) in &general {
                let Some(ratio) = self.ratio(e, exponent) else { continue };
                let rest = ratio.mul(constant).and_then(|c| self.linear(e).0.add(c.neg()));
                let Some(rest) = rest.filter(|rest| is_short(*rest)) else { continue };
                inside.push((b, ratio));
                outside.extend((!rest.is_zero()).then_some((b, rest)));
                taken.push((b, e));
            }
            let small = inside.iter().all(|(_, q)| q.abs() <= Q::ONE && is_short(*q));
            let signs =
                [false, true].map(|sign| inside.iter().any(|(_, q)| q.is_negative() == sign));
            let found = Together { exponent, inside, outside, factors: taken };
            (small && signs == [true, true]).then_some(found)
        })
    }

    /// An expression as a number and terms.
    fn linear(&self, id: Id) -> (Q, Vec<(Q, Id)>) {
        match self.node(id) {
            Node::Sum(c, terms) => (*c, terms.clone()),
            _ => (Q::ZERO, vec![(Q::ONE, id)]),
        }
    }

    /// How many times the terms of another expression the terms of this one are.
    fn ratio(&self, id: Id, of: Id) -> Option<Q> {
        let ((_, a), (_, b)) = (self.linear(id), self.linear(of));
        let ratio = a.first()?.0.mul(b.first()?.0.recip()?)?;
        let alike = |(x, y): (&(Q, Id), &(Q, Id))| x.1 == y.1 && y.0.mul(ratio) == Some(x.0);
        (a.len() == b.len() && a.iter().zip(&b).all(alike)).then_some(ratio)
    }
}

/// Whether a power is made of few products and a root.
fn is_short(q: Q) -> bool {
    q.den() <= 2 && q.num().abs() <= 8
}

/// A power as another one and what is left.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Divided {
    /// The other power.
    pub power: Q,
    /// How often it is in there.
    pub times: Q,
    /// What is left.
    pub rest: Q,
}

/// A whole exponent by one of some powers: by that itself, if it is among them, or one that divides it, or one that is
/// smaller.
pub fn divided(exponent: Q, powers: &[Q]) -> Option<Divided> {
    if powers.is_empty() {
        return None;
    }
    let by = |power: Q| {
        let times = Q::int(i64::try_from(exponent.num() / power.num()).ok()?);
        Some(Divided { power, times, rest: exponent.add(times.mul(power)?.neg())? })
    };
    let all: Vec<Divided> = powers.iter().filter_map(|&power| by(power)).collect();
    let all = || all.iter().copied().filter(|by| exponent.is_int() && !by.times.is_zero());
    let same = all().find(|by| by.power.abs() == exponent.abs());
    same.or_else(|| all().find(|by| by.rest.is_zero())).or_else(|| all().next())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::eval::evaluate;
    use crate::expr::Leaf;
    use crate::interval::Interval;

    #[test]
    fn large_powers_of_a_quotient_stay_in_range() {
        let mut g = Graph::new();
        let n = g.leaf(Leaf::Param(0), "n", Interval::new(1.0, 1e6));
        let [a, b] = [0, 1].map(|i| g.leaf(Leaf::Out(i), "x", Interval::new(0.0, 4.0)));
        // a^(n + 1) / b^((n + 3) / 2), which is (a / √b)^(n + 1) / b.
        let above = g.sum(Q::ONE, &[(Q::ONE, n)]);
        let below = g.sum(Q::new(-3, 2).unwrap(), &[(Q::HALF.neg(), n)]);
        let id = g.product(&[(a, above), (b, below)]);
        let factors = g.factors(id);
        let found = g.powers_together(&factors).unwrap();
        assert_eq!(
            (found.exponent, &found.inside[..]),
            (above, &[(a, Q::ONE), (b, Q::HALF.neg())][..])
        );
        assert_eq!(found.outside, [(b, Q::int(-1))]);
        let at = |l: Leaf| match l {
            Leaf::Param(0) => 1e5,
            Leaf::Out(0) => 0.3,
            _ => 0.09 * (1.0 + 2e-6),
        };
        let expected = f64::exp(-0.1) / 0.09;
        let value = evaluate::<f64>(&g, id, &at);
        assert!((value / expected - 1.0).abs() < 1e-5, "{value}, {expected}");
        // Squares on one side are that of a product, also as parts of other powers.
        let (square, cube) = (g.int(-2), g.int(-3));
        let below = g.product(&[(a, square), (b, cube)]);
        let factors = g.factors(below);
        let shared = g.shared_powers(&factors);
        assert_eq!(shared, [Q::int(-2)]);
        let (power, rest) = (Q::int(-2), Q::int(-1));
        let expected = Divided { power, times: Q::ONE, rest };
        assert_eq!(divided(Q::int(-3), &shared), Some(expected));
        assert_eq!(divided(Q::int(1), &shared), None);
        // Powers that do not divide each other are left alone, and so are others.
        let product = g.product(&[(a, above), (b, n)]);
        let factors = g.factors(product);
        assert!(g.powers_together(&factors).is_none());
        let minus = g.powi(n, -1);
        let product = g.product(&[(a, above), (b, minus)]);
        let factors = g.factors(product);
        assert!(g.powers_together(&factors).is_none());
    }
}
