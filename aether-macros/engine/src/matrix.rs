//! Matrices of expressions: determinants, and the solution of small linear systems.

use crate::expr::{Graph, Id};
use crate::jacobian::simplify_with;
use crate::rational::Q;

/// Solves matrix · atoms = known; also tells which rows were not needed.
pub fn solve_matrix(
    g: &mut Graph,
    matrix: &[Vec<Id>],
    known: &[Id],
    frames: &[[[Id; 3]; 3]],
) -> Option<(Vec<Id>, Vec<usize>)> {
    let (m, k) = (matrix.len(), matrix[0].len());
    if let Some(values) = orthonormal(g, matrix, known, frames) {
        return Some((values, vec![]));
    }
    if m > k
        && let Some(rows) = independent_rows(g, matrix)
    {
        let square: Vec<Vec<Id>> = rows.iter().map(|&r| matrix[r].clone()).collect();
        let right: Vec<Id> = rows.iter().map(|&r| known[r]).collect();
        let unused = (0..m).filter(|r| !rows.contains(r)).collect();
        return Some((cramer(g, &square, &right)?, unused));
    }
    match (m, k) {
        _ if m == k => Some((cramer(g, matrix, known)?, vec![])),
        (_, 1) => {
            // The least squares solution along one column.
            let column: Vec<Id> = matrix.iter().map(|r| r[0]).collect();
            let top = dot(g, &column, known);
            let bottom = dot(g, &column, &column);
            Some((vec![g.div(top, bottom)], vec![]))
        }
        (3, 2) => {
            // Two columns a, b with normal n = a × b: coordinates by triple products.
            let a: Vec<Id> = matrix.iter().map(|r| r[0]).collect();
            let b: Vec<Id> = matrix.iter().map(|r| r[1]).collect();
            let n = cross(g, &a, &b);
            let nn = dot(g, &n, &n);
            let xb = cross(g, known, &b);
            let ax = cross(g, &a, known);
            let s = dot(g, &xb, &n);
            let t = dot(g, &ax, &n);
            Some((vec![g.div(s, nn), g.div(t, nn)], vec![]))
        }
        _ => None,
    }
}

/// A matrix that is a frame, by its type or as seen from its columns, has its transpose as its inverse.
fn orthonormal(
    g: &mut Graph,
    matrix: &[Vec<Id>],
    known: &[Id],
    frames: &[[[Id; 3]; 3]],
) -> Option<Vec<Id>> {
    if matrix.len() != 3 || matrix[0].len() != 3 {
        return None;
    }
    let is = |f: &[[Id; 3]; 3], columns: bool| {
        // The atoms may come in any order: every column of the system must be some column of the frame.
        (0..3).all(|j| {
            (0..3).any(|c| (0..3).all(|i| matrix[i][j] == if columns { f[c][i] } else { f[i][c] }))
        })
    };
    let typed = frames.iter().any(|f| is(f, true) || is(f, false));
    if !typed && (g.units().is_empty() || !is_frame(g, matrix)) {
        return None;
    }
    Some(
        (0..3)
            .map(|j| {
                let column: Vec<Id> = (0..3).map(|i| matrix[i][j]).collect();
                dot(g, &column, known)
            })
            .collect(),
    )
}

/// Whether the columns of a matrix are seen to be perpendicular and of unit length, as those of the frame about a direction.
pub fn is_frame(g: &mut Graph, matrix: &[Vec<Id>]) -> bool {
    let units = g.units().to_vec();
    let columns: Vec<Vec<Id>> = (0..3).map(|j| matrix.iter().map(|row| row[j]).collect()).collect();
    let mut is = |i: usize, j: usize| {
        let product = dot(g, &columns[i], &columns[j]);
        let expected = g.int(i64::from(i == j));
        let rest = g.sub(product, expected);
        let rest = simplify_with(g, rest, &units);
        g.as_number(rest).is_some_and(Q::is_zero)
    };
    let pairs = [(0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2)];
    pairs.into_iter().all(|(i, j)| is(i, j))
}

/// Rows that determine all atoms, if the coefficients are plain numbers.
fn independent_rows(g: &Graph, matrix: &[Vec<Id>]) -> Option<Vec<usize>> {
    let k = matrix[0].len();
    let numbers: Option<Vec<Vec<Q>>> =
        matrix.iter().map(|r| r.iter().map(|c| g.as_number(*c)).collect()).collect();
    let numbers = numbers?;
    let mut chosen: Vec<usize> = Vec::new();
    let mut reduced: Vec<Vec<Q>> = Vec::new();
    for (i, r) in numbers.iter().enumerate() {
        let mut r = r.clone();
        for b in &reduced {
            let p = b.iter().position(|x| !x.is_zero())?;
            let f = r[p].mul(b[p].recip()?)?;
            for (x, y) in r.iter_mut().zip(b) {
                *x = x.add(f.mul(*y)?.neg())?;
            }
        }
        if r.iter().any(|x| !x.is_zero()) && chosen.len() < k {
            chosen.push(i);
            reduced.push(r);
        }
    }
    (chosen.len() == k).then_some(chosen)
}

/// Cramer's rule for up to three unknowns.
fn cramer(g: &mut Graph, matrix: &[Vec<Id>], known: &[Id]) -> Option<Vec<Id>> {
    let (bottom, tops) = match known.len() {
        1 | 2 => (determinant(g, matrix), replaced(g, matrix, known)),
        3 => triple_products(g, matrix, known),
        _ => return None,
    };
    if g.as_number(bottom).is_some_and(Q::is_zero) {
        return None;
    }
    Some(tops.into_iter().map(|top| g.div(top, bottom)).collect())
}

/// The determinants with each column replaced by what is known.
fn replaced(g: &mut Graph, matrix: &[Vec<Id>], known: &[Id]) -> Vec<Id> {
    let with_known = |j: usize| -> Vec<Vec<Id>> {
        let mut replaced = matrix.to_vec();
        replaced.iter_mut().zip(known).for_each(|(row, &x)| row[j] = x);
        replaced
    };
    (0..known.len()).map(|j| determinant(g, &with_known(j))).collect()
}

/// The determinant of three columns, and those with each of them replaced by what is known: all four are triple products of one
/// of two vector products of columns. Of columns that are vectors, machines with instructions for two numbers have the edges in
/// pairs; minors of two rows, as many of them, would have to be put together.
fn triple_products(g: &mut Graph, matrix: &[Vec<Id>], known: &[Id]) -> (Id, Vec<Id>) {
    let [a, b, c] = [0, 1, 2].map(|j| matrix.iter().map(|row| row[j]).collect::<Vec<Id>>());
    let (bc, xa) = (cross(g, &b, &c), cross(g, known, &a));
    let (bottom, along_b) = (dot(g, &a, &bc), dot(g, &xa, &c));
    (bottom, vec![dot(g, known, &bc), g.neg(along_b), dot(g, &xa, &b)])
}

/// The determinant, by expansion along the first row.
pub fn determinant(g: &mut Graph, m: &[Vec<Id>]) -> Id {
    if m.len() == 1 {
        return m[0][0];
    }
    let mut terms = Vec::new();
    for j in 0..m.len() {
        let minor: Vec<Vec<Id>> = m[1..]
            .iter()
            .map(|r| r.iter().enumerate().filter(|(c, _)| *c != j).map(|(_, x)| *x).collect())
            .collect();
        let d = determinant(g, &minor);
        let t = g.mul(m[0][j], d);
        terms.push((if j % 2 == 0 { Q::ONE } else { Q::int(-1) }, t));
    }
    g.sum(Q::ZERO, &terms)
}

/// Scalar product.
pub fn dot(g: &mut Graph, a: &[Id], b: &[Id]) -> Id {
    let terms: Vec<_> = a.iter().zip(b).map(|(&x, &y)| (Q::ONE, g.mul(x, y))).collect();
    g.sum(Q::ZERO, &terms)
}

/// Vector product.
pub fn cross(g: &mut Graph, a: &[Id], b: &[Id]) -> Vec<Id> {
    (0..3)
        .map(|i| {
            let (j, k) = ((i + 1) % 3, (i + 2) % 3);
            let p = g.mul(a[j], b[k]);
            let q = g.mul(a[k], b[j]);
            g.sub(p, q)
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::eval::Evaluator;
    use crate::expr::{Leaf, Node};
    use crate::interval::Interval;

    #[test]
    fn three_unknowns_are_triple_products_of_two_vector_products() {
        let mut g = Graph::new();
        let leaf = |g: &mut Graph, i: u8| g.leaf(Leaf::Param(i), "p", Interval::ALL);
        let matrix = [0, 1, 2].map(|row| (0..3).map(|j| leaf(&mut g, 3 * row + j)).collect());
        let known = [9, 10, 11].map(|i| leaf(&mut g, i));
        let solved = cramer(&mut g, &matrix, &known).unwrap();
        // Those of 2, -3, 5.
        let rows = [[1.0, 2.0, 7.0], [-1.0, 4.0, 0.5], [3.0, 0.25, 2.0]];
        let right = rows.map(|row| 2.0 * row[0] - 3.0 * row[1] + 5.0 * row[2]);
        let at = |leaf| match leaf {
            Leaf::Param(i) if i < 9 => rows[usize::from(i) / 3][usize::from(i) % 3],
            Leaf::Param(i) => right[usize::from(i) - 9],
            _ => f64::NAN,
        };
        let mut e = Evaluator::<f64>::new(&g, &at);
        let found = [0, 1, 2].map(|j| e.value(solved[j]));
        assert!(
            found.iter().zip([2.0, -3.0, 5.0]).all(|(a, b)| (a - b).abs() < 1e-14),
            "{found:?}"
        );
        // Six differences of products are all that is computed besides sums of products with them.
        let within = g.within(&solved);
        let is_difference = |id: &&Id| matches!(g.node(**id), Node::Sum(_, t) if t.len() == 2);
        assert_eq!(within.iter().filter(is_difference).count(), 6);
    }
}
