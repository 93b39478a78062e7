//! How much was computed, for measurements.
//!
//! Each thread counts for itself, so counting costs an addition and never waits. Who starts threads adds up
//! what they counted.

use core::cell::Cell;

std::thread_local! {
    static DENSITIES: Cell<u64> = const { Cell::new(0) };
}

/// How many conditional densities of strategies this thread has evaluated since it began: those that drawing
/// a vertex told, and those that weights and estimates asked for. Each counts once, however many outcomes of
/// choices it sums up; what was remembered is not evaluated and does not count.
#[inline]
pub fn densities() -> u64 {
    DENSITIES.get()
}

/// Adds evaluations to those of this thread, such as what a thread that it started has counted.
#[inline]
pub fn count_densities(more: u64) {
    DENSITIES.set(DENSITIES.get() + more);
}
