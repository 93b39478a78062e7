//! Pearson's test of counts.

use super::gamma::chi_square_tail;
use super::report::Report;

/// Bins in which fewer are expected are pooled.
const FEWEST: f64 = 5.0;
/// So many where fewer than [`FEWEST`] are expected cannot be.
const IMPOSSIBLE: f64 = 30.0;

/// Counts of samples against what is expected of a density, or of probabilities.
#[derive(Default)]
pub(super) struct Pearson {
    statistic: f64,
    bins: f64,
    /// The largest deviation in standard deviations, and of which bin.
    worst: (f64, String),
    /// The counts in bins where few are expected, how many are, and the variance of that.
    pooled: (f64, f64, f64),
}

impl Pearson {
    /// Adds a bin with so many samples, where some number is expected; that has a variance if it is an estimate.
    pub(super) fn add(&mut self, name: &str, count: f64, (expected, variance): (f64, f64)) {
        if expected < FEWEST {
            let (counts, all, variances) = self.pooled;
            self.pooled = (counts + count, all + expected, variances + variance);
        } else {
            self.compare(name, count, (expected, variance));
        }
    }

    fn compare(&mut self, name: &str, count: f64, (expected, variance): (f64, f64)) {
        let deviation = (count - expected) / (expected + variance).sqrt();
        self.statistic += deviation * deviation;
        self.bins += 1.0;
        if deviation.is_nan() || deviation.abs() >= self.worst.0 {
            self.worst = (deviation.abs(), name.to_owned());
        }
    }

    /// Reports whether the counts may be as they are, but for one right density in so many as the rate says.
    pub(super) fn conclude(
        mut self,
        (check, subject): (&'static str, &str),
        rate: f64,
        report: &mut Report,
    ) {
        let (count, expected, variance) = self.pooled;
        let is_impossible = expected < FEWEST && count > IMPOSSIBLE;
        if expected >= FEWEST {
            self.compare("the rest", count, (expected, variance));
        }
        let p = chi_square_tail(self.statistic, (self.bins - 1.0).max(1.0));
        let figures = format!(
            "{subject}: statistic {:.1}, p = {p:.1e} (limit {rate:e}), {} is {:.1} standard \
             deviations off",
            self.statistic, self.worst.1, self.worst.0
        );
        let failure = if is_impossible {
            Some(format!("{count} samples where {:.1} are expected; {figures}", expected.max(0.0)))
        } else {
            // A NaN is not right.
            (p.is_nan() || p < rate).then(|| figures.clone())
        };
        report.conclude(check, failure, figures);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Whether the test finds nothing in these bins.
    fn passes(bins: &[(f64, f64)]) -> bool {
        let (mut pearson, mut report) = (Pearson::default(), Report::new("counts"));
        bins.iter().for_each(|(count, expected)| pearson.add("a bin", *count, (*expected, 0.0)));
        pearson.conclude(("chi-square", "counts"), 1e-6, &mut report);
        report.is_ok()
    }

    #[test]
    fn counts_that_cannot_be_fail() {
        assert!(passes(&[(100.0, 110.0), (210.0, 200.0), (3.0, 1.0)]));
        assert!(!passes(&[(100.0, 170.0), (270.0, 200.0)]));
        // Many small bins are one that is not small, and what should not be there at all is seen.
        assert!(!passes(&[(0.0, 4.0); 9]));
        assert!(!passes(&[(100.0, 131.0), (31.0, 0.0)]) && passes(&[(100.0, 101.0), (1.0, 0.0)]));
        assert!(!passes(&[(f64::NAN, 100.0), (100.0, 100.0)]));
    }
}
