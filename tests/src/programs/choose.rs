//! Which programs the suite has.

use proptest::strategy::{Strategy, ValueTree};
use proptest::test_runner::{Config, RngAlgorithm, TestRng, TestRunner};

use super::plan::{Plan, plan};

/// The first plans that proptest composes, always the same.
pub fn plans(core: bool, seed: u8, count: usize) -> Vec<Plan> {
    let rng = TestRng::from_seed(RngAlgorithm::ChaCha, &[seed; 32]);
    let mut runner = TestRunner::new_with_rng(Config::default(), rng);
    let strategy = plan(core);
    let next = |_| strategy.new_tree(&mut runner).expect("no strategy filters").current();
    (0..count).map(next).collect()
}
