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
}

impl<V: Vertex, S> Snapshot<V, S> {
    /// How many vertices the path has.
    pub fn len(&self) -> usize {
        self.steps.len()
    }

    /// Whether the path has no vertex.
    pub fn is_empty(&self) -> bool {
        self.steps.is_empty()
    }

    /// Vertex `i`, if the path has it.
    pub fn vertex(&self, i: usize) -> Option<V> {
        self.steps.get(i).map(|step| step.0)
    }

    /// The same path with something else in the place of its strategies: without those that borrow, it can be
    /// stored where they cannot.
    pub fn map<T>(self, mut f: impl FnMut(S) -> T) -> Snapshot<V, T> {
        let steps =
            self.steps.into_iter().map(|(vertex, strategy, entry)| (vertex, f(strategy), entry));
        Snapshot { steps: steps.collect() }
    }
}

impl<V: Vertex, S: Strategy<V>> Arena<V, S> {
    /// The path of a snapshot, with vertices of its own here: restoring it twice yields two paths
    /// that share no vertex.
    pub fn restore(&self, snapshot: &Snapshot<V, S>) -> RandomSequence<'_, V, S> {
        self.restore_with(snapshot, |_, strategy| strategy.clone())
    }

    /// [`Arena::restore`] of a snapshot whose strategies are something else, from which, and from the number of
    /// the vertex, `make` makes those of this arena.
    pub fn restore_with<T>(
        &self,
        snapshot: &Snapshot<V, T>,
        make: impl Fn(usize, &T) -> S,
    ) -> RandomSequence<'_, V, S> {
        let mut path = self.sequence();
        let start = self.tape.len();
        // Neighbours with one strategy have one here too: those of a joint run belong together.
        let mut last = None;
        for (i, (vertex, strategy, entry)) in snapshot.steps.iter().enumerate() {
            let id = match last {
                Some((before, id)) if before == entry.strategy => id,
                _ => self.intern(make(i, strategy)),
            };
            last = Some((entry.strategy, id));
            self.tape.push_taken(*vertex, Entry { strategy: id, ..*entry });
        }
        path.occupy(start, snapshot.steps.len());
        path
    }
}
