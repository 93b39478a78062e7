//! A path that outlives the contents of an arena: the state of a Markov chain.

use crate::sequence::{Arena, RandomSequence};
use crate::strategy::{Dirac, Strategy, Vertex};

use super::tape::{Entry, Part, Way};

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
        let merged = |i: usize| arena.tape.step(place, i).way.merger().is_some();
        if !path.is_complete() || (0..path.len()).any(merged) {
            return;
        }
        let strategies = arena.strategies.borrow();
        self.steps.extend((0..path.len()).filter_map(|i| {
            let entry = arena.tape.step(place, i);
            let strategy = strategies.get(entry.way.strategy() as usize)?.clone();
            Some((arena.tape.vertex(place.at(i))?, strategy, entry))
        }));
    }
}

impl<V: Vertex, S> Snapshot<V, S> {
    /// What a vertex takes, with its strategy and what else is known of it.
    pub const BYTES_OF_A_STEP: usize = size_of::<(V, S, Entry)>();

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

    /// The steps of the path: the vertex, what has made it, and what else is known of the step, as a number to be
    /// kept in a file ([`Snapshot::from_steps`]).
    pub fn steps(&self) -> impl Iterator<Item = (&V, &S, u64)> {
        self.steps.iter().enumerate().map(|(i, (vertex, strategy, entry))| {
            let joined = i > 0 && self.steps[i - 1].2.way.strategy() == entry.way.strategy();
            (vertex, strategy, code(entry, joined))
        })
    }

    /// The path with these steps, which were those of another, with the same or other strategies.
    pub fn from_steps(steps: impl IntoIterator<Item = (V, S, u64)>) -> Self {
        let mut number = 0;
        let steps = steps.into_iter().map(|(vertex, strategy, code)| {
            let (entry, joined) = decoded(code);
            number += u32::from(!joined);
            (vertex, strategy, Entry { way: entry.way.by(number), ..entry })
        });
        Snapshot { steps: steps.collect() }
    }

    /// The same path with something else in the place of its strategies: without those that borrow, it can be
    /// stored where they cannot.
    pub fn map<T>(self, mut f: impl FnMut(S) -> T) -> Snapshot<V, T> {
        let steps =
            self.steps.into_iter().map(|(vertex, strategy, entry)| (vertex, f(strategy), entry));
        Snapshot { steps: steps.collect() }
    }
}

/// What a snapshot needs of a step besides its vertex and its strategy: from the lowest bit the block of sampling
/// dimensions (32 bits), the part of a joint draw (8), the Dirac factor (2), and one bit each for the direction, for
/// visibility, and for whether the step before has the same strategy.
fn code(entry: &Entry, joined: bool) -> u64 {
    let dirac = match entry.dirac {
        None => 0,
        Some(Dirac::Position) => 1,
        Some(Dirac::Direction) => 2,
    };
    u64::from(entry.block)
        | u64::from(entry.way.part().byte()) << 32
        | dirac << 40
        | u64::from(entry.way.is_backward()) << 42
        | u64::from(entry.visible) << 43
        | u64::from(joined) << 44
}

/// The step of a [`code`], and whether the one before has the same strategy.
fn decoded(code: u64) -> (Entry, bool) {
    let bit = |i: u32| code >> i & 1 == 1;
    let dirac = match code >> 40 & 3 {
        1 => Some(Dirac::Position),
        2 => Some(Dirac::Direction),
        _ => None,
    };
    let way = Way::new(0, Part::from_byte((code >> 32) as u8)).turned(bit(42));
    let entry = Entry { visible: bit(43), dirac, ..Entry::pending(way, code as u32) };
    (entry, bit(44))
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
                Some((before, id)) if before == entry.way.strategy() => id,
                _ => self.add(make(i, strategy)),
            };
            last = Some((entry.way.strategy(), id));
            self.tape.push_taken(*vertex, Entry { way: entry.way.by(id), ..*entry });
        }
        path.occupy(start, snapshot.steps.len());
        path
    }
}
