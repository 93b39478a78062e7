//! Work that all threads share.

use std::sync::atomic::AtomicUsize;
use std::thread::{available_parallelism, scope};

/// What the threads of this machine make, each of the pieces of work whose numbers it takes from the count.
pub fn on_all_threads<T: Send>(work: impl Fn(&AtomicUsize) -> T + Sync) -> Vec<T> {
    let next = AtomicUsize::new(0);
    let work = || work(&next);
    scope(|scope| {
        let threads = 0..available_parallelism().map_or(1, usize::from);
        let running: Vec<_> = threads.map(|_| scope.spawn(work)).collect();
        running.into_iter().map(|thread| thread.join().expect("no thread panicked")).collect()
    })
}
