//! Random sequences: paths whose vertices are drawn one after the other (Aether 2017, section 5.6).
//!
//! Vertices and the steps that made them live once, in an [`Arena`]; a [`RandomSequence`] is a
//! small handle to a range of them. Conditional densities are remembered, so that weighing all
//! techniques of a bidirectional path evaluates each of them once. Once the arena has grown to what
//! a sample needs, nothing here allocates.

mod erased;
mod evaluate;
mod joint;
mod memo;
mod random_sequence;
mod ratios;
mod snapshot;
mod strategies;
mod tape;
mod view;

use core::cell::{Cell, RefCell};
use core::sync::atomic::{AtomicU64, Ordering};

pub(crate) use erased::Borrowed;
pub use erased::{DynStrategy, Erased};
pub(crate) use evaluate::length_class;
pub(crate) use memo::{KEY, Key, Memo};
pub(crate) use random_sequence::Handle;
pub use random_sequence::{RandomSequence, first_block};
use ratios::LastFactors;
pub use snapshot::Snapshot;
pub(crate) use tape::{NONE, Part, Place, Tape, Unfolded};
pub use view::PathView;
pub(crate) use view::{LAST, LastDrawn, WINDOW, Window, each_last};

use crate::estimator::Joints;
use crate::mutation::Replay;
use crate::strategy::{Strategy, Vertex};

/// The home of all paths of one sample: their vertices, strategies and densities.
///
/// Make one a thread, [`Arena::clear`] it for each sample; the memory is kept.
#[derive(Debug)]
pub struct Arena<V: Vertex, S> {
    pub(crate) tape: Tape<V>,
    pub(crate) strategies: RefCell<Vec<S>>,
    /// Which of them were asked for last, the last one first.
    recent: RefCell<Recent>,
    /// The most vertices that one of them reads.
    pub(crate) most_read: Cell<usize>,
    memo: RefCell<Memo<V::Real>>,
    /// Lists of paths.
    pub(crate) lists: RefCell<Vec<Listed<V::Real>>>,
    pub(crate) ratios: RefCell<Vec<V::Real>>,
    last: RefCell<LastFactors<V::Real>>,
    /// What is known of how paths are joined.
    pub(crate) joints: RefCell<Joints<V>>,
    /// Memory of evaluating a mutation.
    pub(crate) replay: RefCell<Replay<V::Real>>,
    sequences: Cell<u8>,
    /// Which arena this is, and how often it has been cleared: no two contents share it.
    contents: (u64, u64),
}

/// A path in a list of techniques.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Listed<R> {
    pub handle: Handle,
    /// How many samples its technique takes.
    pub samples: R,
    /// From the first to the last step that is unlike that of the path before in the list, of the same length,
    /// once that has been asked for.
    pub unlike: Option<(u32, u32)>,
}

/// With how many strategies that are known already a strategy is compared: those that were asked for last.
const COMPARED: usize = 16;

/// The ids of those, the last one first; the others in any order.
#[derive(Debug, Default)]
struct Recent {
    ids: [u32; COMPARED],
    /// How many there have been.
    known: usize,
}

impl Recent {
    /// Puts an id before the others. If there is no room for all, the place that was taken first is taken again.
    #[inline]
    fn add(&mut self, id: u32) {
        let place = match self.known < COMPARED {
            true => self.known,
            false => 1 + self.known % (COMPARED - 1),
        };
        (self.ids[place], self.known) = (self.ids[0], self.known + 1);
        self.ids[0] = id;
    }
}

impl<V: Vertex, S: Strategy<V>> Arena<V, S> {
    /// An arena without any path.
    pub fn new() -> Self {
        static ARENAS: AtomicU64 = AtomicU64::new(0);
        Arena {
            tape: Tape::new(),
            strategies: RefCell::new(Vec::new()),
            recent: RefCell::default(),
            most_read: Cell::new(0),
            memo: RefCell::new(Memo::new()),
            lists: RefCell::new(Vec::new()),
            ratios: RefCell::new(Vec::new()),
            last: RefCell::new(LastFactors::new()),
            joints: RefCell::new(Joints::new()),
            replay: RefCell::default(),
            sequences: Cell::new(0),
            contents: (ARENAS.fetch_add(1, Ordering::Relaxed), 0),
        }
    }

    /// Forgets all paths and keeps the memory. The borrow checker makes sure that no handle to a
    /// path is left.
    pub fn clear(&mut self) {
        self.tape.clear();
        self.strategies.get_mut().clear();
        self.recent.get_mut().known = 0;
        self.most_read.set(0);
        self.memo.get_mut().clear();
        self.lists.get_mut().clear();
        self.joints.get_mut().clear();
        self.sequences.set(0);
        self.contents.1 += 1;
    }

    /// An empty path.
    ///
    /// The first four paths that are asked for since [`Arena::clear`] draw from blocks of sampling dimensions of their
    /// own. All further ones share those of the fourth: of a source that numbers dimensions ([`UniformSource::start`](crate::UniformSource::start))
    /// they would draw the same numbers, unless each says that it is another [piece](crate::UniformSource::piece) of the sample.
    pub fn sequence(&self) -> RandomSequence<'_, V, S> {
        let number = self.sequences.get();
        self.sequences.set(number.saturating_add(1));
        RandomSequence::empty(self, number)
    }

    /// How many vertices live here.
    pub fn vertex_count(&self) -> usize {
        self.tape.vertex_count()
    }

    pub(crate) fn contents(&self) -> (u64, u64) {
        self.contents
    }

    /// The id of a strategy; that of a known one if it is the same as one of the last that were asked for.
    #[inline]
    pub(crate) fn intern(&self, strategy: S) -> u32 {
        let recent = &mut *self.recent.borrow_mut();
        {
            let strategies = self.strategies.borrow();
            for i in 0..recent.known.min(COMPARED) {
                if strategies[recent.ids[i] as usize].same(&strategy) {
                    recent.ids.swap(0, i);
                    return recent.ids[0];
                }
            }
        }
        let id = self.add(strategy);
        recent.add(id);
        id
    }

    /// The id of a strategy of its own, with which no other is compared.
    #[inline]
    pub(crate) fn add(&self, strategy: S) -> u32 {
        let mut strategies = self.strategies.borrow_mut();
        self.most_read.set(self.most_read.get().max(strategy.reads().vertices));
        strategies.push(strategy);
        strategies.len() as u32 - 1
    }
}

impl<V: Vertex, S: Strategy<V>> Default for Arena<V, S> {
    fn default() -> Self {
        Self::new()
    }
}
