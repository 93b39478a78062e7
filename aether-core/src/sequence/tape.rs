//! Where vertices and the steps that made them live: one growing tape, shared by all paths.

mod entry;
mod unfolded;

use core::cell::{Cell, Ref, RefCell};

pub(crate) use entry::{Entry, Merger, NONE, Part, Place, Question, Step, Way};
pub(crate) use unfolded::Unfolded;

use crate::path_density::PathDensity;
use crate::strategy::{Dirac, Drawn, DrawnRun, Vertex};

/// A vertex, and what drawing it told of its conditional density.
#[derive(Clone, Copy, Debug)]
struct Kept<V: Vertex> {
    vertex: V,
    /// The density, if it is known.
    value: Option<V::Real>,
    /// What that is the density of.
    question: Question,
    /// The step that drew it: its position on the tape, how many lie before it in its path, and whether these come after it
    /// on the tape, as the path is read against its order.
    at: u32,
    before: u32,
    reversed: bool,
}

impl<V: Vertex> Kept<V> {
    /// Where on the tape the step lies that is `j + 1` before the one that drew the vertex, if there is one.
    #[inline(always)]
    fn before(&self, j: usize) -> Option<usize> {
        let (at, by) = (self.at as usize, j + 1);
        (j < self.before as usize).then(|| if self.reversed { at + by } else { at - by })
    }
}

/// Vertices, steps, and the densities of runs.
#[derive(Debug)]
pub(crate) struct Tape<V: Vertex> {
    vertices: RefCell<Vec<Kept<V>>>,
    entries: RefCell<Vec<Entry>>,
    /// Density of the run that ends with a vertex, as far as there are any.
    runs: RefCell<Vec<Option<PathDensity<V::Real>>>>,
    mergers: RefCell<Vec<Merger<V::Real>>>,
    /// Whether some step has led in a single direction: mostly none has.
    directed: Cell<bool>,
}

impl<V: Vertex> Tape<V> {
    pub fn new() -> Self {
        Tape {
            vertices: RefCell::new(Vec::new()),
            entries: RefCell::new(Vec::new()),
            runs: RefCell::new(Vec::new()),
            mergers: RefCell::new(Vec::new()),
            directed: Cell::new(false),
        }
    }

    pub fn clear(&mut self) {
        self.vertices.get_mut().clear();
        self.entries.get_mut().clear();
        self.runs.get_mut().clear();
        self.mergers.get_mut().clear();
        self.directed.set(false);
    }

    /// Number of steps on the tape.
    #[inline]
    pub fn len(&self) -> usize {
        self.entries.borrow().len()
    }

    #[inline]
    pub fn vertex_count(&self) -> usize {
        self.vertices.borrow().len()
    }

    #[inline]
    pub fn entry(&self, at: usize) -> Entry {
        self.entries.borrow()[at]
    }

    /// Step `i` of a place, its way as seen from there.
    #[inline]
    pub fn step(&self, place: Place, i: usize) -> Entry {
        let entry = self.entry(place.at(i));
        Entry { way: entry.way.turned(place.reversed), ..entry }
    }

    /// The vertex of a step, if it has one.
    #[inline]
    pub fn vertex(&self, at: usize) -> Option<V> {
        let id = self.entries.borrow()[at].vertex;
        self.vertices.borrow().get(id as usize).map(|kept| kept.vertex)
    }

    /// The tape with its steps and vertices at hand, to which nothing can be added meanwhile.
    #[inline]
    pub fn unfolded(&self) -> Unfolded<'_, V> {
        let entries = Ref::map(self.entries.borrow(), Vec::as_slice);
        let vertices = Ref::map(self.vertices.borrow(), Vec::as_slice);
        Unfolded { tape: self, entries, vertices }
    }

    /// Adds a step that is not taken yet.
    #[inline]
    pub fn push(&self, strategy: u32, block: u32, part: Part) {
        let entry = Entry::pending(Way::new(strategy, part), block);
        self.entries.borrow_mut().push(entry);
    }

    /// Adds steps of a strategy that draws one vertex, each with its block.
    #[inline]
    pub fn push_each(&self, strategy: u32, blocks: impl Iterator<Item = u32>) {
        let way = Way::new(strategy, Part::new(0, 1));
        self.entries.borrow_mut().extend(blocks.map(|block| Entry::pending(way, block)));
    }

    /// Adds a step with a vertex of its own; nothing is known about the run that it belongs to.
    pub fn push_taken(&self, vertex: V, entry: Entry) {
        self.note(entry.dirac);
        let id = self.vertex_count() as u32;
        self.vertices.borrow_mut().push(Kept {
            vertex,
            value: None,
            question: Question::NOTHING,
            at: 0,
            before: 0,
            reversed: false,
        });
        self.entries.borrow_mut().push(Entry { vertex: id, run: 0, ..entry });
    }

    /// Replaces what is known about how the vertex of a step sees the one that it was made from,
    /// and forgets the run that the step belonged to.
    pub fn set_origin(&self, at: usize, visible: bool, dirac: Option<Dirac>) {
        let entry = &mut self.entries.borrow_mut()[at];
        *entry = Entry { visible, dirac, run: 0, ..*entry };
        self.note(dirac);
    }

    /// Forgets the steps from a position on, which no path has any more; their vertices stay.
    pub fn truncate(&self, len: usize) {
        self.entries.borrow_mut().truncate(len);
    }

    /// Replaces the strategy of a step that is not taken.
    pub fn set_strategy(&self, at: usize, strategy: u32) {
        let entry = &mut self.entries.borrow_mut()[at];
        *entry = Entry::pending(entry.way.by(strategy), entry.block);
    }

    /// Makes a step lead to its vertex from both sides; returns whether there was room for that.
    pub fn merge(&self, at: usize, merger: Merger<V::Real>) -> bool {
        self.note(merger.dirac);
        let mut mergers = self.mergers.borrow_mut();
        if mergers.len() == Way::MERGERS {
            return false;
        }
        let entry = &mut self.entries.borrow_mut()[at];
        *entry = Entry { way: entry.way.merging(mergers.len() as u32), run: 0, ..*entry };
        mergers.push(merger);
        true
    }

    pub fn merger(&self, id: u32) -> Merger<V::Real> {
        self.mergers.borrow()[id as usize]
    }

    /// Copies a place, of which the first `taken` steps have vertices, to the end of the tape.
    pub fn copy(&self, place: Place, taken: usize) {
        let (n, mut entries) = (place.len as usize, self.entries.borrow_mut());
        if n == 0 {
            return;
        }
        let start = entries.len();
        let (first, last) = (place.at(0), place.at(n - 1));
        entries.extend_from_within(first.min(last)..first.max(last) + 1);
        let copied = &mut entries[start..];
        if place.reversed {
            copied.reverse();
            for entry in &mut *copied {
                entry.way = entry.way.turned(true);
            }
        }
        // What is known about a run holds only if this place sees all of it; mostly it is one run from its end on.
        let is_run = |entry: &Entry, backward: bool| {
            entry.run as usize == n && entry.way.is_backward() == backward
        };
        if !is_run(&copied[n - 1], false) && !is_run(&copied[0], true) {
            for (i, entry) in copied.iter_mut().enumerate() {
                let seen = if entry.way.is_backward() { n - i } else { i + 1 };
                if entry.run != seen as u32 {
                    entry.run = 0;
                }
            }
        }
        for entry in &mut copied[taken.min(n)..] {
            *entry = Entry::pending(entry.way, entry.block);
        }
        // The vertex that an outermost step was made from may have been cut off.
        if !copied[0].way.is_backward() {
            copied[0].forget_origin();
        }
        if copied[n - 1].way.is_backward() {
            copied[n - 1].forget_origin();
        }
    }

    /// Notes that there is a step with a Dirac factor.
    #[inline]
    pub fn note(&self, dirac: Option<Dirac>) {
        if dirac == Some(Dirac::Direction) {
            self.directed.set(true);
        }
    }

    /// Takes step `i` of a place, in the direction in which that is read; what was told of its density answers a question.
    #[inline(always)]
    pub fn take(&self, place: Place, i: usize, drawn: &Drawn<V>, question: Question) {
        let mut entries = self.entries.borrow_mut();
        let run = match i.checked_sub(1).map(|before| &entries[place.at(before)]) {
            None => 1,
            Some(before) if before.way.is_backward() == place.reversed => {
                if before.run as usize == i { before.run + 1 } else { 0 }
            }
            Some(_) => 0,
        };
        let mut vertices = self.vertices.borrow_mut();
        let (visible, dirac) = (drawn.visible, drawn.dirac);
        self.note(dirac);
        let entry = &mut entries[place.at(i)];
        *entry = Entry { vertex: vertices.len() as u32, run, visible, dirac, ..*entry };
        let (at, before, reversed) = (place.at(i) as u32, i as u32, place.reversed);
        let (vertex, value) = (drawn.vertex, drawn.value);
        vertices.push(Kept { vertex, value, question, at, before, reversed });
    }

    /// Adds a step behind a run of so many that ends where the tape does, with the vertex that it has drawn; what was told of
    /// its density answers a question.
    #[inline(always)]
    pub fn extend_run(
        &self,
        (strategy, block): (u32, u32),
        run: usize,
        drawn: &Drawn<V>,
        question: Question,
    ) {
        let (mut entries, mut vertices) = (self.entries.borrow_mut(), self.vertices.borrow_mut());
        let (visible, dirac, run) = (drawn.visible, drawn.dirac, run as u32);
        self.note(dirac);
        let (at, vertex) = (entries.len() as u32, vertices.len() as u32);
        let way = Way::new(strategy, Part::new(0, 1));
        entries.push(Entry { way, vertex, block, run: run + 1, visible, dirac });
        let (vertex, value) = (drawn.vertex, drawn.value);
        vertices.push(Kept { vertex, value, question, at, before: run, reversed: false });
    }

    /// Takes the steps of a joint run, of which `i` is the first, of a place that is read forwards.
    pub fn take_run(&self, place: Place, i: usize, drawn: &DrawnRun<V>) {
        for (j, vertex) in drawn.vertices().iter().enumerate() {
            let visible = drawn.visible && j > 0;
            self.take(place, i + j, &Drawn { visible, ..Drawn::new(*vertex) }, Question::NOTHING);
        }
    }

    /// The joint run that step `k` of a place belongs to: all of its steps in the direction of travel;
    /// `None` if the place holds only a piece of it.
    pub fn joint_run(&self, place: Place, k: usize) -> Option<Place> {
        let step = self.step(place, k);
        let (index, len) = (step.way.part().index(), step.way.part().len());
        let after = len - 1 - index;
        let backward = step.way.is_backward();
        let (before, after) = if backward { (after, index) } else { (index, after) };
        let end = k + after + 1;
        if before > k || end > place.len as usize {
            return None;
        }
        let run = place.range(k - before, end);
        let run = if backward { run.reverse() } else { run };
        let whole = (0..len).all(|j| {
            let other = self.step(run, j);
            !other.way.is_backward()
                && other.way.part() == Part::new(j, len)
                && other.way.strategy() == step.way.strategy()
                && (other.vertex == NONE) == (step.vertex == NONE)
        });
        whole.then_some(run)
    }

    /// Whether a place holds all of every joint run of which it has a step.
    pub fn is_whole(&self, place: Place) -> bool {
        let mut k = 0;
        while k < place.len as usize {
            let part = self.step(place, k).way.part();
            if part.is_joint() && self.joint_run(place, k).is_none() {
                return false;
            }
            // A run that is there ends so many steps on.
            k += part.len();
        }
        true
    }

    /// Whether no step of the tape leads in a single direction.
    #[inline]
    pub fn is_undirected(&self) -> bool {
        !self.directed.get()
    }

    /// The density of a run, by its name.
    pub fn run_density(&self, name: u32) -> Option<PathDensity<V::Real>> {
        self.runs.borrow().get(name as usize).copied().flatten()
    }

    pub fn set_run_density(&self, name: u32, density: PathDensity<V::Real>) {
        let runs = &mut self.runs.borrow_mut();
        if runs.len() <= name as usize {
            runs.resize(name as usize + 1, None);
        }
        runs[name as usize] = Some(density);
    }
}
