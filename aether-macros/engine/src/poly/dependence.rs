//! Linear relations between rational functions.

use super::{Expander, Mono, Poly, RatFun};
use crate::expr::{Graph, Id};
use crate::rational::Q;

/// Coefficients of the expressions whose sum is one, if there is a single such relation with rational
/// numbers.
pub fn parts_of_one(g: &mut Graph, expressions: &[Id]) -> Option<Vec<Q>> {
    let mut e = Expander::new(g);
    let functions: Vec<RatFun> = expressions.iter().map(|&x| e.expand(x)).collect::<Option<_>>()?;
    let columns = over_one_denominator(&functions)?;
    let mut monomials: Vec<&Mono> = columns.iter().flat_map(|p| &p.0).map(|(m, _)| m).collect();
    monomials.sort();
    monomials.dedup();
    let coefficient =
        |p: &Poly, m: &Mono| p.0.iter().find(|(n, _)| n == m).map_or(Q::ZERO, |(_, q)| *q);
    let rows: Vec<Vec<Q>> =
        monomials.iter().map(|m| columns.iter().map(|p| coefficient(p, m)).collect()).collect();
    let kernel = kernel(rows, columns.len())?;
    let (last, parts) = kernel.split_last()?;
    let scale = last.neg().recip()?;
    parts.iter().map(|q| q.mul(scale)).collect()
}

/// The numerators over a common denominator, and that denominator: the numerator of one.
fn over_one_denominator(functions: &[RatFun]) -> Option<Vec<Poly>> {
    let mut common: Vec<(Poly, u32)> = Vec::new();
    for (d, e) in functions.iter().flat_map(|f| &f.den) {
        match common.iter_mut().find(|(p, _)| p == d) {
            Some((_, have)) => *have = (*have).max(*e),
            None => common.push((d.clone(), *e)),
        }
    }
    let lift = |num: &Poly, den: &[(Poly, u32)]| {
        common.iter().try_fold(num.clone(), |n, (d, e)| {
            let have = den.iter().find(|(p, _)| p == d).map_or(0, |(_, e)| *e);
            n.mul(&d.powi(e - have)?)
        })
    };
    let mut columns: Vec<Poly> =
        functions.iter().map(|f| lift(&f.num, &f.den)).collect::<Option<_>>()?;
    columns.push(lift(&Poly::constant(Q::ONE), &[])?);
    Some(columns)
}

/// The vector that the rows take to zero, if there is but one up to a factor.
fn kernel(mut rows: Vec<Vec<Q>>, n: usize) -> Option<Vec<Q>> {
    let mut pivots = Vec::new();
    let mut free = None;
    for column in 0..n {
        let first = pivots.len();
        let Some(pivot) = (first..rows.len()).find(|&i| !rows[i][column].is_zero()) else {
            if free.replace(column).is_some() {
                return None;
            }
            continue;
        };
        rows.swap(first, pivot);
        let scale = rows[first][column].recip()?;
        rows[first] = rows[first].iter().map(|q| q.mul(scale)).collect::<Option<_>>()?;
        for i in (0..rows.len()).filter(|i| *i != first) {
            let factor = rows[i][column].neg();
            let subtracted = rows[i].iter().zip(&rows[first]).map(|(a, b)| a.add(b.mul(factor)?));
            rows[i] = subtracted.collect::<Option<_>>()?;
        }
        pivots.push(column);
    }
    let free = free?;
    let mut vector = vec![Q::ZERO; n];
    vector[free] = Q::ONE;
    for (row, &column) in rows.iter().zip(&pivots) {
        vector[column] = row[free].neg();
    }
    Some(vector)
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
