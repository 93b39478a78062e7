//! A path that outlives the contents of an arena: the state of a Markov chain.

use crate::sequence::{Arena, RandomSequence};
use crate::strategy::{Strategy, Vertex};

use super::tape::{Entry, NONE};

/// A complete path outside any arena: its vertices, the strategies that made them and their Dirac
/// factors. Storing another path of no greater length needs no heap.
#[derive(Clone, Debug)]
pub struct Snapshot<V: Vertex, S> {
    steps: Vec<(V, S, Entry)>,
}

impl<V: Vertex, S> Default for Snapshot<V, S> {
    fn default() -> Self {
        Snapshot { steps: Vec::new() }
    }
}

impl<V: Vertex, S: Strategy<V>> Snapshot<V, S> {
    /// The empty path.
    pub fn new() -> Self {
        Self::default()
    }

    /// A copy of a path; the empty path if it is not complete, or if vertices of it have been merged.
    pub fn of(path: &RandomSequence<'_, V, S>) -> Self {
        let mut snapshot = Self::new();
        snapshot.store(path);
        snapshot
    }

    /// Replaces what is stored by a copy of a path; by the empty path if that has no [`Snapshot::of`].
    pub fn store(&mut self, path: &RandomSequence<'_, V, S>) {
        self.steps.clear();
        let (arena, place) = (path.arena, path.handle.place);
        let merged = |i: usize| arena.tape.step(place, i).merged != NONE;
        if !path.is_complete() || (0..path.len()).any(merged) {
            return;
        }
        let strategies = arena.strategies.borrow();
        self.steps.extend((0..path.len()).filter_map(|i| {
            let entry = arena.tape.step(place, i);
            let strategy = strategies.get(entry.strategy as usize)?.clone();
            Some((arena.tape.vertex(place.at(i))?, strategy, entry))
        }));
    }

    /// How many vertices the path has.
    pub fn len(&self) -> usize {
        self.steps.len()
    }

    /// Whether the path has no vertex.
    pub fn is_empty(&self) -> bool {
        self.steps.is_empty()
    }
}

impl<V: Vertex, S: Strategy<V>> Arena<V, S> {
    /// The path of a snapshot, with vertices of its own here: restoring it twice yields two paths
    /// that share no vertex.
    pub fn restore(&self, snapshot: &Snapshot<V, S>) -> RandomSequence<'_, V, S> {
        let mut path = self.sequence();
        let start = self.tape.len();
        // Neighbours with one strategy have one here too: those of a joint run belong together.
        let mut last = None;
        for (vertex, strategy, entry) in &snapshot.steps {
            let id = match last {
                Some((before, id)) if before == entry.strategy => id,
                _ => self.intern(strategy.clone()),
            };
            last = Some((entry.strategy, id));
            self.tape.push_taken(*vertex, Entry { strategy: id, ..*entry });
        }
        path.occupy(start, snapshot.len());
        path
    }
}
