//! How much was computed: rays, and densities of strategies.
//!
//! Each thread counts for itself ([`aether_core::work`]). [`threads`] adds up what the threads that it starts
//! count, so that the thread that renders knows all of it in the end.

use std::cell::Cell;
use std::ops::{AddAssign, Range, Sub};

use aether_core::work::{count_densities, densities};

/// Numbers of operations.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Work {
    /// Rays whose nearest hit was looked for.
    pub nearest: u64,
    /// Rays and segments of which only was asked whether anything stands in their way.
    pub occlusion: u64,
    /// Conditional densities of strategies.
    pub densities: u64,
}

thread_local! {
    static NEAREST: Cell<u64> = const { Cell::new(0) };
    static OCCLUSION: Cell<u64> = const { Cell::new(0) };
}

/// Counts a ray whose nearest hit is looked for.
#[inline]
pub fn count_nearest() {
    NEAREST.set(NEAREST.get() + 1);
}

/// Counts a ray that is asked whether anything stands in its way.
#[inline]
pub fn count_occlusion() {
    OCCLUSION.set(OCCLUSION.get() + 1);
}

impl Work {
    /// What this thread has done since it began.
    pub fn here() -> Self {
        Work { nearest: NEAREST.get(), occlusion: OCCLUSION.get(), densities: densities() }
    }

    /// Rays of both kinds.
    pub fn rays(&self) -> u64 {
        self.nearest + self.occlusion
    }

    /// Counts all of this as work of this thread.
    fn count_here(&self) {
        NEAREST.set(NEAREST.get() + self.nearest);
        OCCLUSION.set(OCCLUSION.get() + self.occlusion);
        count_densities(self.densities);
    }
}

impl AddAssign for Work {
    fn add_assign(&mut self, other: Self) {
        self.nearest += other.nearest;
        self.occlusion += other.occlusion;
        self.densities += other.densities;
    }
}

impl Sub for Work {
    type Output = Work;
    fn sub(self, before: Work) -> Work {
        Work {
            nearest: self.nearest - before.nearest,
            occlusion: self.occlusion - before.occlusion,
            densities: self.densities - before.densities,
        }
    }
}

/// Runs each job in a thread of its own and waits for all; the results are in order. What they count counts
/// for the calling thread. A job that panics ends the caller too.
pub fn threads<T: Send, J: FnOnce() -> T + Send>(jobs: impl IntoIterator<Item = J>) -> Vec<T> {
    std::thread::scope(|scope| {
        let counted = |job: J| move || (job(), Work::here());
        let started: Vec<_> = jobs.into_iter().map(|job| scope.spawn(counted(job))).collect();
        let finish = |thread: std::thread::ScopedJoinHandle<'_, (T, Work)>| {
            let (result, work) =
                thread.join().unwrap_or_else(|panic| std::panic::resume_unwind(panic));
            work.count_here();
            result
        };
        started.into_iter().map(finish).collect()
    })
}

/// What `make` makes of the numbers below `count`, in their order, by several threads.
pub fn in_parts<T: Send>(
    count: usize,
    cores: usize,
    make: impl Fn(Range<usize>) -> Vec<T> + Sync,
) -> Vec<T> {
    let share = count.div_ceil(cores).max(1);
    let make = &make;
    let part = |start: usize| move || make(start..(start + share).min(count));
    threads((0..count).step_by(share).map(part)).into_iter().flatten().collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_threads_count_is_added_up() {
        let before = Work::here();
        let jobs = (0..3u64).map(|i| {
            move || {
                (0..i).for_each(|_| count_nearest());
                count_occlusion();
                count_densities(10 * i);
                i
            }
        });
        assert_eq!(threads(jobs), [0, 1, 2]);
        let work = Work::here() - before;
        assert_eq!(work, Work { nearest: 3, occlusion: 3, densities: 30 });
        assert_eq!(work.rays(), 6);
    }
}
