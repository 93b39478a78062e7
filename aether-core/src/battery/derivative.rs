//! Derivatives by differences, and the volume that they span.

/// How many steps are tried.
const LEVELS: usize = 10;
const FEW_LEVELS: usize = 3;

/// The numbers in which a map of uniforms computes.
pub(super) struct Numbers<'a> {
    /// How far the next one after one is from it.
    pub(super) epsilon: f64,
    /// Uniforms as they have them.
    pub(super) rounded: &'a dyn Fn(&[f64]) -> Vec<f64>,
}

const DOUBLE: Numbers<'static> = Numbers { epsilon: f64::EPSILON, rounded: &<[f64]>::to_vec };

/// The derivative of a map of uniforms at a point.
pub(super) struct Derivative {
    /// Orthonormal basis of the tangent space.
    pub(super) tangents: Vec<Vec<f64>>,
    /// How far each further column of the derivative reaches out of the span of those before it:
    /// the diagonal of R in the factorisation J = QR.
    pub(super) extents: Vec<f64>,
    /// Estimated relative error of the volume.
    pub(super) error: f64,
}

impl Derivative {
    /// Differentiates `f` at an interior point `u` of the unit cube; `None` where `f` is not
    /// defined, or its derivative too small or too rough to tell. `f` computes in these numbers.
    pub(super) fn of(
        f: &dyn Fn(&[f64]) -> Option<Vec<f64>>,
        u: &[f64],
        numbers: &Numbers<'_>,
    ) -> Option<Self> {
        Self::by_steps(f, u, (0.05, LEVELS), numbers)
    }

    /// The same to about a thousandth, in double precision, for less work and from points close by.
    pub(super) fn roughly(f: &dyn Fn(&[f64]) -> Option<Vec<f64>>, u: &[f64]) -> Option<Self> {
        Self::by_steps(f, u, (1e-5, FEW_LEVELS), &DOUBLE)
    }

    fn by_steps(
        f: &dyn Fn(&[f64]) -> Option<Vec<f64>>,
        u: &[f64],
        steps: (f64, usize),
        numbers: &Numbers<'_>,
    ) -> Option<Self> {
        let mut result = Derivative { tangents: Vec::new(), extents: Vec::new(), error: 0.0 };
        for axis in 0..u.len() {
            let (mut column, error) = ridders(f, u, axis, steps, numbers)?;
            // Twice, so that the columns are orthogonal to the last digit.
            for tangent in result.tangents.iter().chain(&result.tangents) {
                let along = dot(&column, tangent);
                column.iter_mut().zip(tangent).for_each(|(c, t)| *c -= along * t);
            }
            let extent = norm(&column);
            if !(extent > 0.0 && extent.is_finite()) {
                return None;
            }
            result.error += error / extent;
            column.iter_mut().for_each(|c| *c /= extent);
            result.tangents.push(column);
            result.extents.push(extent);
        }
        Some(result)
    }

    /// √det(JᵀJ), without forming JᵀJ.
    pub(super) fn volume(&self) -> f64 {
        self.extents.iter().product()
    }

    /// The smallest extent: how little the image may move as a uniform does.
    pub(super) fn least(&self) -> f64 {
        self.extents.iter().copied().fold(f64::INFINITY, f64::min)
    }

    /// Orthonormal basis of the normal space in n dimensions.
    pub(super) fn normals(&self, n: usize) -> Vec<Vec<f64>> {
        let mut basis = self.tangents.clone();
        while basis.len() < n {
            // Of the axes left over, the one that sticks out most.
            let candidates = (0..n).map(|axis| {
                let mut v = vec![0.0; n];
                v[axis] = 1.0;
                for b in basis.iter().chain(&basis) {
                    let along = dot(&v, b);
                    v.iter_mut().zip(b).for_each(|(v, b)| *v -= along * b);
                }
                v
            });
            let Some(mut next) = candidates.max_by(|a, b| norm(a).total_cmp(&norm(b))) else {
                break;
            };
            let length = norm(&next);
            next.iter_mut().for_each(|x| *x /= length);
            basis.push(next);
        }
        basis.split_off(self.tangents.len())
    }
}

pub(super) fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

pub(super) fn norm(a: &[f64]) -> f64 {
    dot(a, a).sqrt()
}

pub(super) fn distance(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| (a - b) * (a - b)).sum::<f64>().sqrt()
}

/// Central differences with shrinking steps, extrapolated to step zero (Ridders 1982), and the
/// estimated error of the column that they give: by how much those differ that it is made of, but no
/// less than what rounding makes of the last of them, since two of many may agree by chance.
fn ridders(
    f: &dyn Fn(&[f64]) -> Option<Vec<f64>>,
    u: &[f64],
    axis: usize,
    (widest, levels): (f64, usize),
    numbers: &Numbers<'_>,
) -> Option<(Vec<f64>, f64)> {
    const SHRINK: f64 = 1.6;
    let mut step = 0.5 * u[axis].min(1.0 - u[axis]).min(widest);
    let mut previous: Vec<Vec<f64>> = Vec::new();
    let mut best: Option<(Vec<f64>, f64)> = None;
    for level in 0..levels {
        // The ends of the step are where the numbers of the map have them.
        let at = |x: f64| {
            let mut v = u.to_vec();
            v[axis] = x;
            let v = (numbers.rounded)(&v);
            Some((v[axis], f(&v)?))
        };
        let ((high, up), (low, down)) = (at(u[axis] + step)?, at(u[axis] - step)?);
        let mut row = vec![scaled_difference(&up, &down, (high - low).recip())];
        // The standard deviation of the difference of two rounded values over the step, as the extrapolation adds to it.
        let rounding = 0.25 * numbers.epsilon / step * norm(&up);
        let mut factor = 1.0;
        for k in 0..level {
            factor *= SHRINK * SHRINK;
            let (new, old) = (&row[k], &previous[k]);
            let better: Vec<f64> =
                new.iter().zip(old).map(|(a, b)| (a * factor - b) / (factor - 1.0)).collect();
            let error = distance(&better, new).max(distance(&better, old)).max(rounding);
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

fn scaled_difference(a: &[f64], b: &[f64], scale: f64) -> Vec<f64> {
    a.iter().zip(b).map(|(a, b)| (a - b) * scale).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn volume_and_normal_of_a_sphere() {
        let sphere = |u: &[f64]| {
            let (r, phi) = ((u[0] * (1.0 - u[0])).sqrt() * 2.0, core::f64::consts::TAU * u[1]);
            Some(vec![r * phi.cos(), r * phi.sin(), 1.0 - 2.0 * u[0]])
        };
        let d = Derivative::of(&sphere, &[0.3, 0.8], &DOUBLE).unwrap();
        assert!((d.volume() / (4.0 * core::f64::consts::PI) - 1.0).abs() < 1e-9);
        assert!(d.error < 1e-8);
        let rough = Derivative::roughly(&sphere, &[0.01, 0.8]).unwrap();
        assert!((rough.volume() / (4.0 * core::f64::consts::PI) - 1.0).abs() < 1e-3);
        let normals = d.normals(3);
        let x = sphere(&[0.3, 0.8]).unwrap();
        assert!(normals.len() == 1 && (dot(&normals[0], &x).abs() - 1.0).abs() < 1e-9);
    }

    /// In single precision some of the differences agree by chance, though they are off by a percent.
    #[test]
    fn agreement_by_chance_is_no_accuracy() {
        let power = |u: &[f64]| Some(vec![f64::from((u[0] as f32).powf(1.0 / 7.0))]);
        let single = |u: &[f64]| u.iter().map(|u| f64::from(*u as f32)).collect();
        let numbers = Numbers { epsilon: f64::from(f32::EPSILON), rounded: &single };
        let (mut told, mut worst) = (0, 0.0_f64);
        for i in 0..2000 {
            let u = f64::from(0.99 + 4e-6 * i as f32);
            let d = Derivative::of(&power, &[u], &numbers).unwrap();
            let exact = u.powf(-6.0 / 7.0) / 7.0;
            worst = worst.max((d.volume() / exact - 1.0).abs() / d.error);
            told += usize::from(d.error < 5e-3);
        }
        assert!(worst < 3.0 && told > 1500, "{worst} {told}");
    }
}
