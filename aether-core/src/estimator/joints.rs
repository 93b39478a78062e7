//! Paths of two pieces that are weighed without being made: their techniques differ in which piece ends where, and
//! sums over them grow with the pieces.
//!
//! Vertex k of a piece has the density `own` under its walk; let r_k be the density with which the other walk would have
//! made it, over that. Relative to the technique that joins both pieces behind vertex k, those that join them before it
//! add up to s_{k+1} = term(r_k) (m_k + s_k), where m_k stands for the technique whose piece has k vertices: the
//! term of its number of samples. A joint decides r_k of the last two vertices of a piece only, as strategies
//! read two vertices; the sum of those before them is one for all joints of paths of one length.

mod known;
mod weights;

use core::cell::{Ref, RefMut};

use crate::combine::Separable;
use crate::estimator::connections::{Connected, Connections};
use crate::estimator::{Estimator, Factors, PathIntegrand, RealOf, Value, is_regular};
use crate::path_density::PathDensity;
use crate::real::Real;
use crate::sequence::{
    Arena, LAST, PathView, Place, RandomSequence, Step, Unfolded, WINDOW, Window,
};
use crate::strategy::{Dirac, Drawn, Strategy};
pub(crate) use known::Joints;

/// The most vertices that a strategy may read, and one less than those of a factor of the integrand.
const READS: usize = LAST - 1;

/// A density, or a sum of terms, of paths of an integrand.
type DensityOf<I> = PathDensity<RealOf<I>>;

/// One of the two walks.
#[derive(Clone, Copy, PartialEq, Eq)]
enum End {
    /// The one that paths begin with.
    First,
    /// The one that they end with.
    Second,
}

impl End {
    fn other(self) -> End {
        if self == End::First { End::Second } else { End::First }
    }
}

/// The steps of a walk.
#[derive(Clone, Copy)]
struct Walk {
    place: Place,
    /// How many of them have vertices, for paths of the length in question.
    len: usize,
}

/// How a path is joined.
#[derive(Clone, Copy)]
struct Joint {
    /// How many of its vertices are those of the first walk.
    first: usize,
    /// Whether its last vertex was drawn for itself.
    ends: bool,
}

/// The place in a window of the first vertex behind a joint.
const BEHIND: usize = WINDOW / 2;

/// A path with its vertices about the joint: all that its weight depends on and its pieces' weights do not.
struct Joined<'r, V> {
    joint: Joint,
    window: Window<'r, V>,
}

impl<V> Joined<'_, V> {
    /// The place in the window of vertex `i` of the path.
    #[inline(always)]
    fn place(&self, i: usize) -> usize {
        BEHIND + i - self.joint.first
    }
}

/// Two walks whose pieces are joined to paths of one length.
pub(super) struct Pieces<'r, I: PathIntegrand, S, N, D, H> {
    estimator: &'r Estimator<I, Factors<I::Value>>,
    connections: &'r Connections<'r, S, N, D>,
    heuristic: &'r H,
    arena: &'r Arena<I::Vertex, S>,
    tape: &'r Unfolded<'r, I::Vertex>,
    strategies: Ref<'r, [S]>,
    walks: [Walk; 2],
    /// Where the last vertex is that was drawn for itself.
    last: Option<usize>,
    /// The strategy that drew it, or would have.
    ending: u32,
    joints: RefMut<'r, Joints<RealOf<I>>>,
}

impl<'r, I, S, N, D, H> Pieces<'r, I, S, N, D, H>
where
    I: PathIntegrand,
    S: Strategy<I::Vertex>,
    N: Fn(usize) -> usize,
    D: Fn(usize) -> bool,
    H: Separable<RealOf<I>>,
{
    /// Whether the paths need not be made to weigh them.
    pub fn are_plain(
        estimator: &Estimator<I, Factors<I::Value>>,
        walks: [&RandomSequence<'r, I::Vertex, S>; 2],
        connections: &Connections<'_, S, N, D>,
        drawn: Option<&Drawn<I::Vertex>>,
    ) -> bool {
        let arena = walks[0].arena;
        S::VERTICES == 1
            && estimator.reads() <= LAST
            && arena.tape.is_undirected()
            && drawn.is_none_or(|drawn| drawn.dirac != Some(Dirac::Direction))
            && walks.iter().all(|walk| walk.is_run())
            && connections.ending.is_none_or(|ending| ending.reads().vertices <= READS)
            && arena.most_read.get() <= READS
    }

    /// The pieces of two walks, and the strategy of a last vertex and where that is on the tape; `None` if paths have to
    /// be made to weigh them.
    pub fn new(
        estimator: &'r Estimator<I, Factors<I::Value>>,
        walks: [&RandomSequence<'r, I::Vertex, S>; 2],
        connections: &'r Connections<'r, S, N, D>,
        heuristic: &'r H,
        tape: &'r Unfolded<'r, I::Vertex>,
        ending: Option<u32>,
        last: Option<usize>,
    ) -> Option<Self> {
        let (arena, length) = (walks[0].arena, connections.length);
        let mut pieces = Pieces {
            estimator,
            connections,
            heuristic,
            arena,
            tape,
            strategies: Ref::map(arena.strategies.borrow(), Vec::as_slice),
            walks: walks.map(|walk| Walk { place: walk.handle.place, len: walk.len().min(length) }),
            last,
            ending: ending.unwrap_or(u32::MAX),
            joints: arena.joints.borrow_mut(),
        };
        pieces.behind(pieces.walks[1].len)?;
        pieces.joints.reserve(tape.vertex_count());
        pieces.weigh_samples();
        Some(pieces)
    }

    /// Visits the paths that contribute.
    pub fn visit(&mut self, visit: &mut impl FnMut(Connected<I::Value>)) {
        let connections = self.connections;
        let ([first, second], mut is_summed_up) = (self.walks, false);
        for first in 0..=first.len {
            let mass = self.joints.masses[first];
            let ends = connections.ends_after(first);
            let exists =
                if ends { self.last.is_some() } else { first + second.len >= connections.length };
            if mass.is_zero() || !exists || !(connections.is_drawn)(first) {
                continue;
            }
            let joined = self.joined(Joint { first, ends });
            let value = self.value(&joined);
            if value.is_zero() {
                continue;
            }
            if !is_summed_up {
                self.sum_up();
                is_summed_up = true;
            }
            let others = self.others(&joined) / mass;
            let weight = (PathDensity::ONE / (PathDensity::ONE + others)).value();
            let samples = RealOf::<I>::of((connections.samples)(first) as f64);
            let value = value.over(samples);
            visit(Connected { first, value: value.times(weight), alone: value });
        }
    }

    /// A path with its vertices about the joint.
    #[inline]
    fn joined(&self, joint: Joint) -> Joined<'r, I::Vertex> {
        let (n, tape) = (self.connections.length, self.tape);
        let mut window = Window { vertices: [None; WINDOW], sees_next: 0, fixed: 0 };
        let mut put = |place: usize, at: usize, neighbour: usize| {
            let (vertex, visible, dirac) = tape.kept(at);
            window.vertices[place] = vertex;
            window.sees_next |= u16::from(visible) << neighbour;
            window.fixed |= u16::from(dirac == Some(Dirac::Position)) << place;
        };
        for k in 0..joint.first.min(LAST) {
            let place = BEHIND - 1 - k;
            put(place, self.walks[0].place.at(joint.first - 1 - k), place - 1);
        }
        if joint.ends {
            if let Some(last) = self.last {
                put(BEHIND, last, BEHIND - 1);
            }
        } else {
            for k in 0..(n - joint.first).min(LAST) {
                let i = self.index(End::Second, joint.first + k);
                put(BEHIND + k, self.walks[1].place.at(i), BEHIND + k);
            }
        }
        Joined { joint, window }
    }

    /// f / p of a path, not weighted.
    fn value(&self, joined: &Joined<'_, I::Vertex>) -> I::Value {
        let (n, joint) = (self.connections.length, joined.joint);
        let (first, place) = (joint.first, self.walks[0].place.range(0, joint.first));
        let mut value = self.estimator.ahead(self.arena, self.tape, place, first);
        if value.is_zero() {
            return value;
        }
        // What goes on behind the edge may vanish without a shadow ray.
        let own = (n - first).min(self.estimator.reads() - 1);
        for k in (first..first + own).rev() {
            let view = PathView::of_window(&joined.window, joined.place(k), false, k + 1);
            value = value.multiply(self.estimator.extended(view));
            if value.is_zero() {
                return value;
            }
        }
        if joint.ends {
            let density = self.density_of_last(joined).value();
            value = if is_regular(density) { value.over(density) } else { I::Value::zero() };
        } else {
            let behind = self.behind(n - first);
            value = behind.map_or(I::Value::zero(), |behind| value.multiply(behind));
        }
        if value.is_zero() {
            return value;
        }
        value.multiply(self.estimator.closing(self.before(joint, n, End::First, LAST)))
    }

    /// What all paths share that end with so many vertices of the second walk; `None` if that leaves the range of
    /// numbers.
    fn behind(&self, len: usize) -> Option<I::Value> {
        if len == 0 {
            return Some(I::Value::one());
        }
        let place = self.walks[1].place.range(0, len).reverse();
        self.estimator.ending(self.arena, self.tape, place, 0)
    }

    /// The number of a vertex in a path from that in its walk, and back.
    #[inline]
    fn index(&self, end: End, k: usize) -> usize {
        if end == End::First { k } else { self.connections.length - 1 - k }
    }

    /// Where vertex `i` of a path is on the tape.
    #[inline]
    fn position(&self, joint: Joint, i: usize) -> usize {
        match self.last {
            _ if i < joint.first => self.walks[0].place.at(i),
            Some(last) if joint.ends => last,
            _ => self.walks[1].place.at(self.index(End::Second, i)),
        }
    }

    /// What lies before vertex `i` of a path, coming from one end, of which so many vertices are read.
    #[inline]
    fn before(&self, joint: Joint, i: usize, end: End, read: usize) -> PathView<'_, I::Vertex> {
        let (n, backward) = (self.connections.length, end == End::Second);
        let len = if backward { n - 1 - i } else { i };
        let last = core::array::from_fn(|j| {
            if j >= len.min(read) {
                return Step::NONE;
            }
            let i = if backward { i + 1 + j } else { i - 1 - j };
            Step::new(self.position(joint, i), (joint.ends || i < joint.first) == backward)
        });
        PathView::of_last(self.tape, last, len, read)
    }
}
