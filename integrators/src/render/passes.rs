//! How many samples each pass adds.

use super::Budget;
use super::windows::next_decision;

/// The largest pass: bounds how uneven an image is that was cancelled within one.
const LARGEST_PASS: u32 = 64;

/// What a render has come to.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct State {
    /// Samples of each pixel.
    pub done: u32,
    /// Seconds used, and those of them that samples took.
    pub seconds: f64,
    pub sampling: f64,
    /// The number of samples at which the observer wants to see the image.
    pub next_look: Option<u32>,
    /// Whether the error is below what is asked for.
    pub good_enough: bool,
}

/// The number of samples per pixel of the next pass, or `None` when the budget is used.
///
/// Passes double, so that a first image and an estimate of the speed come soon. Under a time
/// limit, a pass that would not end in time at the speed so far is shortened, and a last sample
/// that would exceed the limit by more than half its duration is not begun. A pass ends where the observer wants to
/// look, and where the error is judged.
pub(super) fn next_pass(budget: Budget, state: &State) -> Option<u32> {
    let done = state.done;
    let doubled = done.clamp(1, LARGEST_PASS);
    let fitting = |limit: f64| {
        let fitting = (limit - state.seconds) / state.sampling * f64::from(done) + 0.5;
        // A float outside the range of u32 becomes its nearest end, and NaN becomes 0.
        (fitting as u32).min(u32::MAX - done)
    };
    let left = match budget {
        Budget::Samples(total) => total.saturating_sub(done),
        Budget::Seconds(_) | Budget::Error(_) if done == 0 => 1,
        Budget::Seconds(limit) => fitting(limit),
        Budget::Error(_) if state.good_enough => 0,
        Budget::Error(limit) => fitting(limit.seconds)
            .min(limit.samples.saturating_sub(done))
            .min(next_decision(done) - done),
    };
    let to_look = state.next_look.and_then(|next| next.checked_sub(done)).filter(|n| *n > 0);
    (left > 0).then(|| left.min(doubled).min(to_look.unwrap_or(u32::MAX)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::render::ErrorBudget;

    fn at(done: u32, seconds: f64) -> State {
        State { done, seconds, sampling: seconds, ..State::default() }
    }

    /// The sizes of all passes if each sample takes `cost` seconds.
    fn all(budget: Budget, cost: f64) -> Vec<u32> {
        let mut done = 0;
        let pass = || {
            let size = next_pass(budget, &at(done, f64::from(done) * cost))?;
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
        assert_eq!(next_pass(Budget::Seconds(1.0), &at(5, 0.0)), Some(5));
        assert_eq!(next_pass(Budget::Seconds(1.0), &at(u32::MAX, 0.5)), None);
    }

    #[test]
    fn what_is_prepared_takes_time_but_says_nothing_of_the_speed() {
        let state = State { done: 2, seconds: 6.0, sampling: 2.0, ..State::default() };
        assert_eq!(next_pass(Budget::Seconds(7.0), &state), Some(1));
        assert_eq!(next_pass(Budget::Seconds(100.0), &state), Some(2));
    }

    #[test]
    fn passes_end_where_they_are_looked_at() {
        let state = State { done: 8, next_look: Some(11), ..State::default() };
        assert_eq!(next_pass(Budget::Samples(100), &state), Some(3));
        let state = State { done: 11, ..state };
        assert_eq!(next_pass(Budget::Samples(100), &state), Some(11));
    }

    #[test]
    fn an_error_is_judged_at_fixed_numbers_of_samples() {
        let limit = ErrorBudget { target: 0.1, samples: 90, seconds: 1e9, adaptive: false };
        let budget = Budget::Error(limit);
        assert_eq!(all(budget, 1e-9), [1, 1, 2, 4, 8, 16, 32, 26]);
        assert_eq!(next_pass(budget, &State { done: 21, ..at(21, 1.0) }), Some(11));
        assert_eq!(next_pass(budget, &State { good_enough: true, ..at(32, 1.0) }), None);
        let short = Budget::Error(ErrorBudget { seconds: 10.0, ..limit });
        assert_eq!(all(short, 1.0).iter().sum::<u32>(), 10);
    }
}
