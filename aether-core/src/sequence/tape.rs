//! Where vertices and the steps that made them live: one growing tape, shared by all paths.

mod known;

use core::cell::{Cell, Ref, RefCell};

use crate::path_density::PathDensity;
use crate::strategy::{Dirac, Drawn, DrawnRun, Vertex};

/// Marks a step that has no vertex (yet).
pub(crate) const NONE: u32 = u32::MAX;

/// Which vertex of a draw a step makes: counted in the direction of travel.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Part(u8);

impl Part {
    /// Vertex `index` of `len`.
    pub fn new(index: usize, len: usize) -> Self {
        Part((index | (len - 1) << 4) as u8)
    }

    /// As a byte, and back.
    pub fn byte(self) -> u8 {
        self.0
    }

    /// The part whose byte this is.
    pub fn from_byte(byte: u8) -> Self {
        Part(byte)
    }

    /// Its number.
    #[inline]
    pub fn index(self) -> usize {
        usize::from(self.0 & 15)
    }

    /// How many vertices the draw yields.
    #[inline]
    pub fn len(self) -> usize {
        usize::from(self.0 >> 4) + 1
    }

    /// Whether the draw yields others too.
    #[inline]
    pub fn is_joint(self) -> bool {
        self.0 != 0
    }

    /// Whether the draw yields no further vertex.
    #[inline]
    pub fn is_last(self) -> bool {
        self.index() + 1 == self.len()
    }
}

/// One step of a path: a strategy, and the vertex that it made.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Entry {
    /// Id of the vertex, or [`NONE`].
    pub vertex: u32,
    /// Id of the strategy.
    pub strategy: u32,
    /// Block of sampling dimensions.
    pub block: u32,
    /// How many steps, this one included, have been taken since the path's origin, all of them in
    /// the direction of this one and neighbours on the tape; zero if that is not so. Such a run is named by
    /// the vertex that it ends with, so that copies of it share what is known about it.
    pub run: u32,
    /// Whether the step was taken against the order of the tape.
    pub backward: bool,
    /// Whether the vertex is known to see the one that it was made from.
    pub visible: bool,
    /// The Dirac factor that the vertex was drawn with.
    pub dirac: Option<Dirac>,
    /// Which vertex of its strategy's draw it is.
    pub part: Part,
    /// The [`Merger`] by which the vertex is also reached from the other side, or [`NONE`].
    pub merged: u32,
}

/// How a step makes a vertex: by which strategy, as which part of its draw, from which side, and what else
/// leads there.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Way {
    strategy: u32,
    merged: u32,
    part: Part,
    backward: bool,
}

impl Way {
    /// That of no step.
    pub const NONE: Way = Way { strategy: NONE, merged: NONE, part: Part(0), backward: false };
}

impl Entry {
    /// The way of the step, if it is read in the direction opposite to that of the tape or not.
    #[inline(always)]
    pub fn way(&self, reversed: bool) -> Way {
        let Entry { strategy, merged, part, .. } = *self;
        let backward = self.backward != reversed;
        Way { strategy, merged, part, backward }
    }

    /// A step of no strategy.
    const VACANT: Entry = Entry {
        vertex: NONE,
        strategy: NONE,
        block: 0,
        run: 0,
        backward: false,
        visible: false,
        dirac: None,
        part: Part(0),
        merged: NONE,
    };

    /// Whether the step goes in a direction, alone or beside one in the other.
    #[inline]
    pub fn goes(&self, backward: bool) -> bool {
        self.backward == backward || self.merged != NONE
    }
}

/// A second step to a vertex, from the other side: it has led to a place next to it.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Merger<R> {
    /// Id of its strategy.
    pub strategy: u32,
    /// The Dirac factor that its vertex was drawn with.
    pub dirac: Option<Dirac>,
    /// The measure of the places that count as next to the vertex.
    pub kernel: R,
}

/// A range of the tape, read in one direction or the other.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Place {
    start: u32,
    pub reversed: bool,
    pub len: u32,
}

impl Place {
    pub fn new(start: usize, len: usize) -> Self {
        Place { start: start as u32, reversed: false, len: len as u32 }
    }

    /// Position on the tape of step `i`.
    #[inline(always)]
    pub fn at(self, i: usize) -> usize {
        let i = i as u32;
        (if self.reversed { self.start.wrapping_sub(i) } else { self.start + i }) as usize
    }

    /// Steps `from..to`.
    #[inline]
    pub fn range(self, from: usize, to: usize) -> Self {
        let start = if from < to { self.at(from) } else { 0 };
        Place { start: start as u32, reversed: self.reversed, len: to.saturating_sub(from) as u32 }
    }

    /// The same steps in opposite order.
    #[inline]
    pub fn reverse(self) -> Self {
        let start = if self.len == 0 { 0 } else { self.at(self.len as usize - 1) };
        Place { start: start as u32, reversed: !self.reversed, len: self.len }
    }
}

/// A vertex, and what drawing it told of its conditional density.
#[derive(Clone, Copy, Debug)]
struct Kept<V: Vertex> {
    vertex: V,
    /// The density, if it is known.
    value: Option<V::Real>,
    /// What that is the density of.
    question: Question,
    /// The step that drew it: its position on the tape, and how many lie before it in its path.
    at: u32,
    before: u32,
}

/// What a conditional density is asked for, apart from vertices.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Question {
    /// The strategy, and the kind of density.
    pub tag: u32,
    /// The class of the length of the path before, if that matters.
    pub class: u32,
}

impl Question {
    /// No question: what nobody asks for.
    pub const NOTHING: Question = Question { tag: NONE, class: NONE };

    /// How a strategy distributes vertices of a kind, after paths whose lengths are of a class.
    #[inline]
    pub fn new(strategy: u32, dirac: Option<Dirac>, class: u32) -> Self {
        let kind = match dirac {
            None => 0,
            Some(Dirac::Position) => 1,
            Some(Dirac::Direction) => 2,
        };
        Question { tag: strategy * 4 + kind, class }
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

    /// Step `i` of a place, its direction as seen from there.
    #[inline]
    pub fn step(&self, place: Place, i: usize) -> Entry {
        let entry = self.entry(place.at(i));
        Entry { backward: entry.backward != place.reversed, ..entry }
    }

    /// Adds a step that is not taken yet.
    pub fn push(&self, strategy: u32, block: u32, part: Part) {
        self.entries.borrow_mut().push(Entry { strategy, block, part, ..Entry::VACANT });
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

    /// Makes a step lead to its vertex from both sides.
    pub fn merge(&self, at: usize, merger: Merger<V::Real>) {
        self.note(merger.dirac);
        let mut mergers = self.mergers.borrow_mut();
        let entry = &mut self.entries.borrow_mut()[at];
        *entry = Entry { merged: mergers.len() as u32, run: 0, ..*entry };
        mergers.push(merger);
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
        }
        for (i, entry) in copied.iter_mut().enumerate() {
            entry.backward ^= place.reversed;
            // What is known about a run holds only if this place sees all of it.
            let seen = if entry.backward { n - i } else { i + 1 };
            entry.run *= u32::from(entry.run == seen as u32);
        }
        for entry in &mut copied[taken.min(n)..] {
            (entry.vertex, entry.run) = (NONE, 0);
            (entry.visible, entry.dirac) = (false, None);
        }
        // The vertex that an outermost step was made from may have been cut off.
        for (i, backward) in [(0, false), (n - 1, true)] {
            let entry = &mut copied[i];
            if entry.backward == backward {
                entry.visible = false;
                entry.dirac = entry.dirac.filter(|dirac| *dirac == Dirac::Position);
            }
        }
    }

    /// Notes that there is a step with a Dirac factor.
    #[inline]
    fn note(&self, dirac: Option<Dirac>) {
        if dirac == Some(Dirac::Direction) {
            self.directed.set(true);
        }
    }

    /// Takes step `i` of a place that is read forwards; what was told of its density answers a question.
    #[inline(always)]
    pub fn take(&self, place: Place, i: usize, drawn: &Drawn<V>, question: Question) {
        let mut entries = self.entries.borrow_mut();
        let run = match i.checked_sub(1).map(|before| entries[place.at(before)]) {
            None => 1,
            Some(before) if before.backward == place.reversed && before.run as usize == i => {
                before.run + 1
            }
            Some(_) => 0,
        };
        let mut vertices = self.vertices.borrow_mut();
        let (visible, dirac) = (drawn.visible, drawn.dirac);
        self.note(dirac);
        let entry = &mut entries[place.at(i)];
        *entry = Entry { vertex: vertices.len() as u32, run, visible, dirac, ..*entry };
        let (at, before) = (place.at(i) as u32, i as u32);
        vertices.push(Kept { vertex: drawn.vertex, value: drawn.value, question, at, before });
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
        let (index, len) = (step.part.index(), step.part.len());
        let after = len - 1 - index;
        let (before, after) = if step.backward { (after, index) } else { (index, after) };
        let end = k + after + 1;
        if before > k || end > place.len as usize {
            return None;
        }
        let run = place.range(k - before, end);
        let run = if step.backward { run.reverse() } else { run };
        let whole = (0..len).all(|j| {
            let other = self.step(run, j);
            !other.backward
                && other.part == Part::new(j, len)
                && other.strategy == step.strategy
                && (other.vertex == NONE) == (step.vertex == NONE)
        });
        whole.then_some(run)
    }

    /// Whether a place holds all of every joint run of which it has a step.
    pub fn is_whole(&self, place: Place) -> bool {
        let mut k = 0;
        while k < place.len as usize {
            let part = self.step(place, k).part;
            if part.is_joint() && self.joint_run(place, k).is_none() {
                return false;
            }
            // A run that is there ends so many steps on.
            k += part.len();
        }
        true
    }

    #[inline]
    pub fn vertex(&self, at: usize) -> Option<V> {
        let id = self.entry(at).vertex;
        self.vertices.borrow().get(id as usize).map(|kept| kept.vertex)
    }

    /// The tape with its steps and vertices at hand, to which nothing can be added meanwhile.
    #[inline]
    pub fn unfolded(&self) -> Unfolded<'_, V> {
        let entries = Ref::map(self.entries.borrow(), Vec::as_slice);
        let vertices = Ref::map(self.vertices.borrow(), Vec::as_slice);
        Unfolded { tape: self, entries, vertices }
    }

    /// Whether vertex `i` of a place carries a Dirac factor.
    #[inline]
    pub fn carries(&self, place: Place, i: usize, dirac: Dirac) -> bool {
        let made = |i: usize, backward: bool| {
            let step = self.step(place, i);
            let dirac = if step.backward == backward {
                step.dirac
            } else if step.merged != NONE {
                self.merger(step.merged).dirac
            } else {
                None
            };
            dirac == Some(Dirac::Direction)
        };
        match dirac {
            Dirac::Position => self.step(place, i).dirac == Some(Dirac::Position),
            Dirac::Direction if !self.directed.get() => false,
            Dirac::Direction => {
                (i + 1 < place.len as usize && made(i + 1, false)) || (i > 0 && made(i - 1, true))
            }
        }
    }

    /// Which kind of factor vertex `i` of a place has for a step in the given direction.
    #[inline]
    pub fn kind(&self, place: Place, i: usize, backward: bool) -> Option<Dirac> {
        if self.carries(place, i, Dirac::Position) {
            return Some(Dirac::Position);
        }
        let before = if backward { i + 1 } else { i.wrapping_sub(1) };
        let fixed = before < place.len as usize && self.carries(place, before, Dirac::Direction);
        fixed.then_some(Dirac::Direction)
    }
}

/// A tape that is being read: [`Tape::unfolded`].
#[derive(Debug)]
pub(crate) struct Unfolded<'t, V: Vertex> {
    pub tape: &'t Tape<V>,
    entries: Ref<'t, [Entry]>,
    vertices: Ref<'t, [Kept<V>]>,
}

impl<V: Vertex> Unfolded<'_, V> {
    #[inline(always)]
    pub fn vertex(&self, at: usize) -> Option<V> {
        let id = self.entries.get(at)?.vertex;
        self.vertices.get(id as usize).map(|kept| kept.vertex)
    }

    /// Whether step `i` of a place is known to see step `i - 1`.
    #[inline]
    pub fn visible(&self, place: Place, i: usize) -> bool {
        let (step, before) = (&self.entries[place.at(i)], &self.entries[place.at(i - 1)]);
        // A vertex that has been merged was reached from the other side too.
        let reached = |step: &Entry, backward: bool| {
            let from_there = (step.backward != place.reversed) == backward;
            if from_there { step.visible } else { step.merged != NONE }
        };
        reached(step, false) || reached(before, true)
    }
}
