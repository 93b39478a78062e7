//! What a forward function says by itself: derivatives by differences, preimages by search. Nothing
//! that a compiler derived is used here.

/// A map of the unit cube; `None` where it has no value.
pub type Forward<'a> = &'a dyn Fn(&[f64]) -> Option<Vec<f64>>;

/// √det(JᵀJ) of `f` at `u` and its relative error, by differences extrapolated to step zero (Ridders
/// 1982); `None` next to where `f` has no value.
pub fn volume(f: Forward, u: &[f64]) -> Option<(f64, f64)> {
    let mut columns = Vec::new();
    let mut error = 0.0;
    for axis in 0..u.len() {
        let (column, e) = partial(f, u, axis)?;
        error += e / norm(&column);
        columns.push(column);
    }
    let volume = span(&columns);
    // Columns that are nearly parallel magnify the error.
    let magnified = columns.iter().map(|c| norm(c)).product::<f64>() / volume;
    Some((volume, error * magnified))
}

/// The derivative along one axis and the length of its error.
fn partial(f: Forward, u: &[f64], axis: usize) -> Option<(Vec<f64>, f64)> {
    const SHRINK: f64 = 1.6;
    let mut step = 0.5 * u[axis].min(1.0 - u[axis]).min(0.05);
    let mut previous: Vec<Vec<f64>> = Vec::new();
    let mut best: Option<(Vec<f64>, f64)> = None;
    for level in 0..14 {
        let at = |step: f64| {
            let mut v = u.to_vec();
            v[axis] += step;
            f(&v)
        };
        let (up, down) = (at(step)?, at(-step)?);
        let slope = |(a, b): (&f64, &f64)| (a - b) * 0.5 / step;
        let mut row: Vec<Vec<f64>> = vec![up.iter().zip(&down).map(slope).collect()];
        let mut factor = 1.0;
        for k in 0..level.min(8) {
            factor *= SHRINK * SHRINK;
            let (new, old) = (&row[k], &previous[k]);
            let better: Vec<f64> =
                new.iter().zip(old).map(|(a, b)| (a * factor - b) / (factor - 1.0)).collect();
            let error = distance(&better, new).max(distance(&better, old));
            if best.as_ref().is_none_or(|(_, least)| error < *least) {
                best = Some((better.clone(), error));
            }
            row.push(better);
        }
        previous = row;
        step /= SHRINK;
    }
    best
}

/// A search for the points of the cube that `f` maps to a given one.
pub struct Search<'a> {
    f: Forward<'a>,
    dimension: usize,
    side: usize,
    grid: Vec<Option<Vec<f64>>>,
}

impl<'a> Search<'a> {
    /// Evaluates `f` on a grid of the cube of this dimension.
    pub fn new(f: Forward<'a>, dimension: usize) -> Self {
        let side = [1, 400, 48, 16][dimension];
        let mut search = Search { f, dimension, side, grid: vec![] };
        search.grid = (0..side.pow(dimension as u32)).map(|i| f(&search.place(i))).collect();
        search
    }

    fn place(&self, index: usize) -> Vec<f64> {
        let mut rest = index;
        (0..self.dimension)
            .map(|_| {
                let i = rest % self.side;
                rest /= self.side;
                (i as f64 + 0.5) / self.side as f64
            })
            .collect()
    }

    /// The uniforms found that map to `x`, from every point of the grid that is nearer to `x` than
    /// its neighbours.
    pub fn preimages(&self, x: &[f64]) -> Vec<Vec<f64>> {
        let far: Vec<f64> = self
            .grid
            .iter()
            .map(|y| y.as_ref().map_or(f64::INFINITY, |y| distance(x, y)))
            .collect();
        let mut found: Vec<Vec<f64>> = Vec::new();
        for (index, d) in far.iter().enumerate() {
            if d.is_finite() && self.neighbours(index).all(|n| far[n] >= *d) {
                let Some(u) = self.descend(self.place(index), x) else { continue };
                if !found.iter().any(|v| distance(v, &u) < 1e-6) {
                    found.push(u);
                }
            }
        }
        found
    }

    fn neighbours(&self, index: usize) -> impl Iterator<Item = usize> + '_ {
        (0..self.dimension).flat_map(move |axis| {
            let stride = self.side.pow(axis as u32);
            let i = index / stride % self.side;
            [(i > 0).then(|| index - stride), (i + 1 < self.side).then(|| index + stride)]
                .into_iter()
                .flatten()
        })
    }

    /// Newton's method for f(u) = x with halved steps, inside the cube.
    fn descend(&self, mut u: Vec<f64>, x: &[f64]) -> Option<Vec<f64>> {
        let scale = 1.0 + norm(x);
        let mut miss = distance(&(self.f)(&u)?, x);
        for _ in 0..40 {
            if miss < 1e-13 * scale {
                break;
            }
            let Some(step) = self.newton(&u, x) else { break };
            let mut length = 1.0;
            let mut moved = false;
            while length > 1e-4 {
                let v: Vec<f64> = u
                    .iter()
                    .zip(&step)
                    .map(|(u, s)| (u + length * s).clamp(1e-12, 1.0 - 1e-12))
                    .collect();
                if let Some(d) = (self.f)(&v).map(|y| distance(&y, x)).filter(|d| *d < miss) {
                    (u, miss, moved) = (v, d, true);
                    break;
                }
                length *= 0.5;
            }
            if !moved {
                break;
            }
        }
        (miss < 1e-9 * scale).then_some(u)
    }

    /// The least-squares step towards x.
    fn newton(&self, u: &[f64], x: &[f64]) -> Option<Vec<f64>> {
        let y = (self.f)(u)?;
        let columns: Vec<Vec<f64>> = (0..u.len())
            .map(|axis| {
                let h = 1e-6 * (u[axis].min(1.0 - u[axis])).max(1e-9) * 2.0;
                let at = |h: f64| {
                    let mut v = u.to_vec();
                    v[axis] += h;
                    (self.f)(&v)
                };
                let (up, down) = (at(h)?, at(-h)?);
                Some(up.iter().zip(&down).map(|(a, b)| (a - b) / (2.0 * h)).collect())
            })
            .collect::<Option<_>>()?;
        let rest: Vec<f64> = x.iter().zip(&y).map(|(x, y)| x - y).collect();
        let gram: Vec<Vec<f64>> =
            columns.iter().map(|a| columns.iter().map(|b| dot(a, b)).collect()).collect();
        let right: Vec<f64> = columns.iter().map(|c| dot(c, &rest)).collect();
        solve(gram, right)
    }
}

/// Gauss's elimination with pivots.
fn solve(mut a: Vec<Vec<f64>>, mut b: Vec<f64>) -> Option<Vec<f64>> {
    let n = b.len();
    for k in 0..n {
        let p = (k..n).max_by(|i, j| a[*i][k].abs().total_cmp(&a[*j][k].abs()))?;
        a.swap(k, p);
        b.swap(k, p);
        if a[k][k] == 0.0 || !a[k][k].is_finite() {
            return None;
        }
        for i in k + 1..n {
            let factor = a[i][k] / a[k][k];
            let pivot = a[k].clone();
            a[i].iter_mut().zip(pivot).skip(k).for_each(|(x, p)| *x -= factor * p);
            b[i] -= factor * b[k];
        }
    }
    let mut x = vec![0.0; n];
    for k in (0..n).rev() {
        let known: f64 = (k + 1..n).map(|j| a[k][j] * x[j]).sum();
        x[k] = (b[k] - known) / a[k][k];
    }
    x.iter().all(|x| x.is_finite()).then_some(x)
}

/// The volume that vectors span: product of the lengths after orthogonalisation.
fn span(columns: &[Vec<f64>]) -> f64 {
    let mut rest = columns.to_vec();
    let mut volume = 1.0;
    for i in 0..rest.len() {
        let length = norm(&rest[i]);
        volume *= length;
        let unit: Vec<f64> = rest[i].iter().map(|x| x / length).collect();
        for other in rest.iter_mut().skip(i + 1) {
            let along = dot(&unit, other);
            other.iter_mut().zip(&unit).for_each(|(x, u)| *x -= along * u);
        }
    }
    volume
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

/// Euclidean length.
pub fn norm(a: &[f64]) -> f64 {
    dot(a, a).sqrt()
}

/// Euclidean distance.
pub fn distance(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| (a - b) * (a - b)).sum::<f64>().sqrt()
}
