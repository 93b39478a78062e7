//! Linear relations between rational functions.

use super::{Expander, Mono, Poly, RatFun};
use crate::expr::{Graph, Id};
use crate::rational::Q;
use crate::rational::matrix::null_vector;
use crate::sorted;

/// Coefficients of the expressions whose sum is one, if there is a single such relation with rational
/// numbers.
pub fn parts_of_one(g: &mut Graph, expressions: &[Id]) -> Option<Vec<Q>> {
    let mut e = Expander::new(g);
    let mut functions: Vec<RatFun> =
        expressions.iter().map(|&x| e.expand(x)).collect::<Option<_>>()?;
    functions.push(RatFun::one());
    let relation = relation(&mut e, &functions)?;
    let (last, parts) = relation.split_last()?;
    let scale = last.neg().recip()?;
    parts.iter().map(|q| q.mul(scale)).collect()
}

/// The coefficients of the linear combination of these functions that is zero, if there is just one up to
/// a factor.
pub fn relation(e: &mut Expander, functions: &[RatFun]) -> Option<Vec<Q>> {
    let columns = over_one_denominator(e, functions)?;
    let mut monomials: Vec<&Mono> = columns.iter().flat_map(|p| &p.0).map(|(m, _)| m).collect();
    sorted::sort(&mut monomials);
    monomials.dedup();
    let coefficient =
        |p: &Poly, m: &Mono| p.0.iter().find(|(n, _)| n == m).map_or(Q::ZERO, |(_, q)| *q);
    let rows =
        monomials.iter().map(|m| columns.iter().map(|p| coefficient(p, m)).collect()).collect();
    null_vector(rows, columns.len())
}

/// The numerators of rational functions, all brought to the same denominator.
fn over_one_denominator(e: &mut Expander, functions: &[RatFun]) -> Option<Vec<Poly>> {
    let mut common: Vec<(Poly, u32)> = Vec::new();
    for (factor, exponent) in functions.iter().flat_map(|f| &f.den) {
        match common.iter_mut().find(|(p, _)| p == factor) {
            Some((_, most)) => *most = (*most).max(*exponent),
            None => common.push((factor.clone(), *exponent)),
        }
    }
    let numerator = |f: &RatFun| {
        let mut product = RatFun::from(f.num.clone());
        for (factor, most) in &common {
            let has = f.den.iter().find(|(p, _)| p == factor).map_or(0, |(_, e)| *e);
            product = e.mul(&product, &RatFun::from(factor.powi(most - has)?))?;
        }
        Some(product.num)
    };
    functions.iter().map(numerator).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::expr::Leaf;
    use crate::interval::Interval;

    #[test]
    fn sticks_add_up_to_one() {
        let mut g = Graph::new();
        let [u, v] = [0, 1].map(|i| g.leaf(Leaf::Unknown(i), "u", Interval::POSITIVE));
        let one = g.int(1);
        let below = g.sum(Q::int(3), &[(Q::int(-2), u)]);
        let first = g.div(u, below);
        let rest = g.sub(one, first);
        let second = g.mul(v, rest);
        let left = g.sub(one, v);
        let third = g.mul(left, rest);
        let found = parts_of_one(&mut g, &[first, second, third]);
        assert_eq!(found, Some(vec![Q::ONE; 3]));
        assert_eq!(parts_of_one(&mut g, &[first, second]), None);
    }
}
