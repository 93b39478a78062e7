//! Intervals from repetitions.

use aether_core::special::beta_inc_inv;

/// A value with an interval of confidence.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Interval {
    /// The estimate.
    pub value: f64,
    /// The lower end.
    pub low: f64,
    /// The upper end.
    pub high: f64,
}

impl Interval {
    /// Whether a value lies within.
    pub fn contains(&self, value: f64) -> bool {
        (self.low..=self.high).contains(&value)
    }
}

/// The confidence of all intervals. One in a hundred does not contain the truth: with 99 %, a page of forty curves
/// has no false alarm most of the time.
pub const CONFIDENCE: f64 = 0.99;

/// The value that Student's t with `freedom` degrees of freedom exceeds, in absolute value, with probability
/// `1 - confidence`: t² = ν (1/x - 1), where x has the beta distribution of ν/2 and 1/2.
pub fn student(confidence: f64, freedom: f64) -> f64 {
    let x: f64 = beta_inc_inv(freedom / 2.0, 0.5, 1.0 - confidence);
    (freedom * (1.0 / x - 1.0)).sqrt()
}

/// A function of several independent repetitions, with its interval by the jackknife (Tukey 1958): how much the
/// value changes when each is left out. `statistic` gets the numbers of those that are in; `None` if it has
/// no value, or with fewer than three repetitions.
pub fn jackknife(
    repetitions: usize,
    statistic: impl Fn(&[usize]) -> Option<f64>,
) -> Option<Interval> {
    if repetitions < 3 {
        return None;
    }
    let all: Vec<usize> = (0..repetitions).collect();
    let value = statistic(&all)?;
    let without = |k: usize| -> Option<f64> {
        let others: Vec<usize> = all.iter().copied().filter(|i| *i != k).collect();
        statistic(&others)
    };
    let parts: Vec<f64> = all.iter().map(|k| without(*k)).collect::<Option<_>>()?;
    let n = repetitions as f64;
    let mean = parts.iter().sum::<f64>() / n;
    let squares: f64 = parts.iter().map(|part| (part - mean).powi(2)).sum();
    let half = student(CONFIDENCE, n - 1.0) * (squares * (n - 1.0) / n).sqrt();
    Some(Interval { value, low: value - half, high: value + half })
}

/// The quantile of some values, interpolated between neighbours; NaN if there are none.
pub fn quantile(values: &[f64], at: f64) -> f64 {
    let mut sorted = values.to_vec();
    sorted.sort_by(f64::total_cmp);
    let Some(last) = sorted.len().checked_sub(1) else { return f64::NAN };
    let place = at.clamp(0.0, 1.0) * last as f64;
    let (below, part) = (place.floor() as usize, place.fract());
    sorted[below] + part * (sorted[(below + 1).min(last)] - sorted[below])
}

/// The median.
pub fn median(values: &[f64]) -> f64 {
    quantile(values, 0.5)
}

/// The slope of the straight line of least squares; `None` with fewer than two different places.
pub fn slope(points: &[(f64, f64)]) -> Option<f64> {
    let n = points.len() as f64;
    let (x, y) = points.iter().fold((0.0, 0.0), |(x, y), p| (x + p.0 / n, y + p.1 / n));
    let (xy, xx) = points
        .iter()
        .fold((0.0, 0.0), |(xy, xx), p| (xy + (p.0 - x) * (p.1 - y), xx + (p.0 - x).powi(2)));
    (xx > 0.0).then(|| xy / xx)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn quantiles_of_students_t() {
        // Tables of Student's t: 99 % and 95 % two-sided.
        for (confidence, freedom, expected) in [
            (0.99, 1.0, 63.656_741_162_87),
            (0.99, 3.0, 5.840_909_309_73),
            (0.95, 9.0, 2.262_157_162_85),
            (0.99, 100.0, 2.625_890_521_12),
        ] {
            approx::assert_relative_eq!(
                student(confidence, freedom),
                expected,
                max_relative = 1e-9
            );
        }
    }

    #[test]
    fn the_jackknife_of_a_mean_is_its_interval() {
        let values = [1.0, 2.0, 4.0, 9.0];
        let mean = |which: &[usize]| {
            Some(which.iter().map(|i| values[*i]).sum::<f64>() / which.len() as f64)
        };
        let interval = jackknife(4, mean).unwrap();
        // Standard error: the root of 38 / 3 / 4.
        let half = student(0.99, 3.0) * (38.0f64 / 12.0).sqrt();
        approx::assert_relative_eq!(interval.high - 4.0, half, max_relative = 1e-12);
        assert!((interval.value, interval.contains(4.1)) == (4.0, true));
        assert_eq!(jackknife(2, mean), None);
    }

    #[test]
    fn quantiles_and_slopes() {
        let values = [4.0, 1.0, 3.0, 2.0];
        assert_eq!([0.0, 0.5, 0.75, 1.0].map(|q| quantile(&values, q)), [1.0, 2.5, 3.25, 4.0]);
        assert!(quantile(&[], 0.5).is_nan());
        let line = [(0.0, 1.0), (1.0, 0.5), (2.0, 0.0)];
        assert_eq!((slope(&line), slope(&line[..1])), (Some(-0.5), None));
    }
}
