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
    /// Integer powers, from squares on, that occur both above and below the line.
    pub fn shared_powers(&self, factors: &[(Id, Id)]) -> Vec<Q> {
        let below = |(_, e): &(Id, Id)| self.as_number(*e).is_some_and(|q| q.num() < -1);
        if !factors.iter().any(below) {
            return vec![];
        }
        let exponents: Vec<Q> = factors.iter().filter_map(|(_, e)| self.as_number(*e)).collect();
        let mut shared = Vec::new();
        for power in exponents.iter().map(|q| q.abs()).filter(|q| q.is_int() && *q > Q::ONE) {
            let both = exponents.contains(&power) && exponents.contains(&power.neg());
            if both && !shared.contains(&power) {
                shared.push(power);
            }
        }
        shared
    }

    /// The factors whose exponents are multiples of one another, but for numbers, where some are above and others below
    /// the line.
    pub fn powers_together(&self, factors: &[(Id, Id)]) -> Option<Together> {
        let is_general = |(_, e): &&(Id, Id)| self.as_number(*e).is_none();
        if factors.iter().filter(is_general).count() < 2 {
            return None;
        }
        let general: Vec<(Id, Id)> = factors.iter().filter(is_general).copied().collect();
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

/// Which of some powers a whole exponent is a multiple of: of that itself, if it is among them.
pub fn power_below(exponent: Q, powers: &[Q]) -> Option<Q> {
    let divides = |power: &Q| exponent.is_int() && exponent.num() % power.num() == 0;
    let same = powers.iter().find(|&&power| power == exponent.abs());
    same.or_else(|| powers.iter().find(|power| divides(power))).copied()
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
