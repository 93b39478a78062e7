//! Polynomials as expressions.

use super::Poly;
use crate::expr::{Graph, Id};
use crate::rational::Q;

impl Poly {
    /// The terms as (coefficient, product of atoms) pairs.
    pub fn terms(&self, g: &mut Graph) -> Vec<(Q, Id)> {
        let mut out = Vec::new();
        for (m, q) in &self.0 {
            let f: Vec<_> = m.iter().map(|(a, e)| (*a, g.int(i64::from(*e)))).collect();
            out.push((*q, g.product(&f)));
        }
        out
    }

    /// The expression, with common factors taken out.
    pub fn to_expr(&self, g: &mut Graph) -> Id {
        let factors = self.factors(g, 1);
        g.product(&factors)
    }

    /// The polynomial to a power, as factors of a product: content, common atoms and the rest, the
    /// rest with a sign that makes it positive where that is known.
    pub(super) fn factors(&self, g: &mut Graph, power: i64) -> Vec<(Id, Id)> {
        let parts = self.split();
        if parts.iter().filter(|(p, _)| p.len() > 1).map(|(_, e)| e).sum::<u32>() > 1
            && let Some(factors) = self.in_parts(g, &parts, power)
        {
            return factors;
        }
        let (mut k, common, rest) = self.content();
        let mut factors = Vec::new();
        for (a, e) in common.iter() {
            let e = g.int(i64::from(*e) * power);
            factors.push((*a, e));
        }
        let mut constant = Q::ZERO;
        let mut terms = Vec::new();
        for (m, q) in &rest.0 {
            if m.is_empty() {
                constant = *q;
                continue;
            }
            let f: Vec<_> = m.iter().map(|(a, e)| (*a, g.int(i64::from(*e)))).collect();
            let t = g.product(&f);
            terms.push((*q, t));
        }
        let mut body = g.sum(constant, &terms);
        if g.range(body).nonpositive() && !g.range(body).nonnegative() {
            body = g.neg(body);
            k = k.neg();
        }
        let e = g.int(power);
        factors.push((body, e));
        let k = g.number(k);
        factors.push((k, e));
        factors
    }

    /// The polynomial to a power as a product of parts, which multiply to it but for a constant.
    fn in_parts(&self, g: &mut Graph, parts: &[(Poly, u32)], power: i64) -> Option<Vec<(Id, Id)>> {
        let mut rest = self.clone();
        let mut factors = Vec::new();
        for (part, e) in parts {
            for _ in 0..*e {
                rest = rest.exact_div(part)?;
            }
            factors.extend(part.factors(g, power * i64::from(*e)));
        }
        let k = g.number(rest.as_constant()?);
        let e = g.int(power);
        factors.push((k, e));
        Some(factors)
    }
}
