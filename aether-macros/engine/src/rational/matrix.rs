//! Matrices of rational numbers, by rows.

use super::Q;

/// A matrix that Gauss and Jordan have reduced: each pivot is one, and alone in its column.
struct Reduced {
    rows: Vec<Vec<Q>>,
    /// The columns of the pivots, one for each of the first rows.
    pivots: Vec<usize>,
}

/// Reduces the first `columns` columns; `None` if a number does not fit.
fn reduced(mut rows: Vec<Vec<Q>>, columns: usize) -> Option<Reduced> {
    let mut pivots = Vec::new();
    for column in 0..columns {
        let done = pivots.len();
        let Some(at) = (done..rows.len()).find(|&r| !rows[r][column].is_zero()) else { continue };
        rows.swap(done, at);
        let scale = rows[done][column].recip()?;
        let pivot: Vec<Q> = rows[done].iter().map(|q| q.mul(scale)).collect::<Option<_>>()?;
        rows[done].clone_from(&pivot);
        let others = rows.iter_mut().enumerate().filter(|(r, _)| *r != done);
        for (_, row) in others.filter(|(_, row)| !row[column].is_zero()) {
            let factor = row[column].neg();
            for (x, p) in row.iter_mut().zip(&pivot) {
                *x = x.add(p.mul(factor)?)?;
            }
        }
        pivots.push(column);
    }
    Some(Reduced { rows, pivots })
}

/// The vector that the rows, each of length `n`, take to zero, if there is but one up to a factor.
pub fn null_vector(rows: Vec<Vec<Q>>, n: usize) -> Option<Vec<Q>> {
    let Reduced { rows, pivots } = reduced(rows, n)?;
    let mut free = (0..n).filter(|c| !pivots.contains(c));
    let (one, None) = (free.next()?, free.next()) else { return None };
    let mut vector = vec![Q::ZERO; n];
    vector[one] = Q::ONE;
    for (row, column) in rows.iter().zip(pivots) {
        vector[column] = row[one].neg();
    }
    Some(vector)
}

/// The inverse of a square matrix, if it has one.
pub fn inverse(matrix: &[Vec<Q>]) -> Option<Vec<Vec<Q>>> {
    let n = matrix.len();
    let unit = |i: usize| (0..n).map(move |j| if i == j { Q::ONE } else { Q::ZERO });
    let beside =
        matrix.iter().enumerate().map(|(i, row)| row.iter().copied().chain(unit(i)).collect());
    let Reduced { rows, pivots } = reduced(beside.collect(), n)?;
    (pivots.len() == n).then(|| rows.into_iter().map(|row| row[n..].to_vec()).collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn rows(numbers: &[&[i64]]) -> Vec<Vec<Q>> {
        numbers.iter().map(|row| row.iter().map(|&n| Q::int(n)).collect()).collect()
    }

    #[test]
    fn one_null_vector_or_none() {
        let found = null_vector(rows(&[&[0, 1, 2], &[2, 0, -4], &[2, 1, -2]]), 3);
        assert_eq!(found, Some(rows(&[&[2, -2, 1]]).remove(0)));
        assert_eq!(null_vector(rows(&[&[1, 1, 1]]), 3), None);
        assert_eq!(null_vector(rows(&[&[1, 2], &[3, 4]]), 2), None);
    }

    #[test]
    fn inverses() {
        let found = inverse(&rows(&[&[0, 2], &[1, 3]]));
        let half = Q::HALF;
        let expected = vec![vec![Q::new(-3, 2).unwrap(), Q::ONE], vec![half, Q::ZERO]];
        assert_eq!(found, Some(expected));
        assert_eq!(inverse(&rows(&[&[1, 2], &[2, 4]])), None);
    }
}
