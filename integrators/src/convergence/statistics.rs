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
/// value changes when each is left out. `statistic` gets the number of the one that is left out, first that of none; `None` if
/// it has no value, or with fewer than three repetitions.
pub fn jackknife(
    repetitions: usize,
    statistic: impl Fn(Option<usize>) -> Option<f64>,
) -> Option<Interval> {
    if repetitions < 3 {
        return None;
    }
    let value = statistic(None)?;
    let parts: Vec<f64> = (0..repetitions).map(|k| statistic(Some(k))).collect::<Option<_>>()?;
    let n = repetitions as f64;
    let mean = parts.iter().sum::<f64>() / n;
    let squares: f64 = parts.iter().map(|part| (part - mean).powi(2)).sum();
    let half = student(CONFIDENCE, n - 1.0) * (squares * (n - 1.0) / n).sqrt();
    Some(Interval { value, low: value - half, high: value + half })
}

/// A sum of values, and what it is without each of them.
#[derive(Clone, Debug, PartialEq)]
pub struct Sums {
    all: f64,
    without: Vec<f64>,
}

impl Sums {
    /// Those of some values. What is left of a sum is added up, not subtracted from it: next to a large value it would lose
    /// its digits.
    pub fn of(values: &[f64]) -> Self {
        let mut without = Vec::with_capacity(values.len());
        let mut all = 0.0;
        for value in values {
            without.push(all);
            all += value;
        }
        let mut after = 0.0;
        for (without, value) in without.iter_mut().zip(values).rev() {
            *without += after;
            after += value;
        }
        Sums { all, without }
    }

    /// The sum without the value with this number.
    pub fn without(&self, left_out: Option<usize>) -> f64 {
        left_out.map_or(self.all, |k| self.without[k])
    }

    /// The mean without the value with this number.
    pub fn mean_without(&self, left_out: Option<usize>) -> f64 {
        let count = self.without.len() - usize::from(left_out.is_some());
        self.without(left_out) / count as f64
    }
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
        let sums = Sums::of(&values);
        let mean = |left_out: Option<usize>| Some(sums.mean_without(left_out));
        let interval = jackknife(4, mean).unwrap();
        // Standard error: the root of 38 / 3 / 4.
        let half = student(0.99, 3.0) * (38.0f64 / 12.0).sqrt();
        approx::assert_relative_eq!(interval.high - 4.0, half, max_relative = 1e-12);
        assert!((interval.value, interval.contains(4.1)) == (4.0, true));
        assert_eq!(jackknife(2, mean), None);
    }

    #[test]
    fn what_is_left_of_a_sum_keeps_its_digits() {
        let sums = Sums::of(&[0.25, 1e30, 0.5, 2.0]);
        assert_eq!([Some(0), Some(1), None].map(|k| sums.without(k)), [1e30, 2.75, 1e30]);
        assert_eq!(sums.mean_without(Some(1)), 2.75 / 3.0);
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
