//! How many samples each pass adds.

use super::Budget;

/// The largest pass: bounds how uneven an image is that was cancelled within one.
const LARGEST_PASS: u32 = 64;

/// The number of samples per pixel of the next pass, or `None` when the budget is used.
///
/// Passes double, so that a first image and an estimate of the speed come soon. Under a time
/// limit, a pass that would not end in time at the speed so far is shortened, and a last sample
/// that would exceed the limit by more than half its duration is not begun.
pub(super) fn next_pass(budget: Budget, done: u32, seconds: f64) -> Option<u32> {
    let doubled = done.clamp(1, LARGEST_PASS);
    let left = match budget {
        Budget::Samples(total) => total.saturating_sub(done),
        Budget::Seconds(_) if done == 0 => 1,
        Budget::Seconds(limit) => {
            let fitting = (limit - seconds) / seconds * f64::from(done) + 0.5;
            // A float outside the range of u32 becomes its nearest end, and NaN becomes 0.
            (fitting as u32).min(u32::MAX - done)
        }
    };
    (left > 0).then(|| left.min(doubled))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The sizes of all passes if each sample takes `cost` seconds.
    fn all(budget: Budget, cost: f64) -> Vec<u32> {
        let mut done = 0;
        let pass = || {
            let size = next_pass(budget, done, f64::from(done) * cost)?;
            done += size;
            Some(size)
        };
        std::iter::from_fn(pass).collect()
    }

    #[test]
    fn samples_are_met_exactly() {
        assert_eq!(all(Budget::Samples(1), 1.0), [1]);
        assert_eq!(all(Budget::Samples(13), 1.0), [1, 1, 2, 4, 5]);
        assert_eq!(all(Budget::Samples(1000), 1.0).iter().sum::<u32>(), 1000);
    }

    #[test]
    fn time_is_met_within_half_a_sample() {
        assert_eq!(all(Budget::Seconds(10.0), 1.0).iter().sum::<u32>(), 10);
        assert_eq!(all(Budget::Seconds(10.4), 1.0).iter().sum::<u32>(), 10);
        assert_eq!(all(Budget::Seconds(0.1), 1.0), [1]);
        assert_eq!(all(Budget::Seconds(3.0), 0.001).iter().sum::<u32>(), 3000);
    }

    #[test]
    fn extreme_speeds_end() {
        assert_eq!(next_pass(Budget::Seconds(1.0), 5, 0.0), Some(5));
        assert_eq!(next_pass(Budget::Seconds(1.0), u32::MAX, 0.5), None);
    }
}
