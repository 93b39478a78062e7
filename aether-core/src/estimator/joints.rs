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
use crate::estimator::range::{is_usable, per};
use crate::estimator::techniques::Technique;
use crate::estimator::{Estimator, Factors, PathIntegrand, RealOf, Value};
use crate::path_density::PathDensity;
use crate::real::Real;
use crate::sequence::{
    Arena, LAST, PathView, Place, RandomSequence, Unfolded, WINDOW, Window, length_class,
};
use crate::strategy::{Dirac, Drawn, Strategy, Vertex};
pub(crate) use known::Joints;
use known::{Question, Stop, Tail};

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
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Walk {
    place: Place,
    /// How many of them have vertices.
    len: usize,
}

/// What pieces of a walk carry, by the number of their vertices.
#[derive(Clone, Debug)]
pub(super) struct Carried<T> {
    /// Which walk it is, and of which contents of an arena.
    walk: Option<((u64, u64), Walk)>,
    values: Vec<T>,
    /// Whether all of it stays in the range of numbers.
    in_range: bool,
}

impl<T> Carried<T> {
    /// Forgets which walk it is.
    pub fn clear(&mut self) {
        self.walk = None;
    }

    /// Begins anew, unless it is of that walk.
    fn begin(&mut self, contents: (u64, u64), walk: Walk) -> bool {
        if self.walk == Some((contents, walk)) {
            return false;
        }
        (self.walk, self.in_range) = (Some((contents, walk)), true);
        self.values.clear();
        true
    }
}

impl<T> Default for Carried<T> {
    fn default() -> Self {
        Carried { walk: None, values: Vec::new(), in_range: true }
    }
}

/// How a path is joined.
#[derive(Clone, Copy)]
struct Joint {
    /// How many vertices it has.
    length: usize,
    /// How many of them are those of the first walk.
    first: usize,
}

impl Joint {
    /// The number of a vertex in a path from that in its walk, and back.
    #[inline(always)]
    fn index(&self, end: End, k: usize) -> usize {
        if end == End::First { k } else { self.length - 1 - k }
    }
}

/// The place in a window of the first vertex behind a joint.
const BEHIND: usize = WINDOW / 2;

/// A path with its vertices about the joint: all that its weight depends on and its pieces' weights do not.
struct Joined<'r, V: Vertex> {
    joint: Joint,
    /// The last vertex if it was drawn for itself.
    last: Option<&'r Drawn<V>>,
    window: Window<'r, V>,
}

impl<V: Vertex> Joined<'_, V> {
    /// The place in the window of vertex `i` of the path.
    #[inline(always)]
    fn place(&self, i: usize) -> usize {
        BEHIND + i - self.joint.first
    }
}

/// Two walks whose pieces are joined to paths.
pub(super) struct Pieces<'r, I: PathIntegrand, S, H, D> {
    estimator: &'r Estimator<I, Factors<I::Value>>,
    connections: &'r Connections<'r, S, RealOf<I>, H, D>,
    heuristic: &'r H,
    arena: &'r Arena<I::Vertex, S>,
    tape: &'r Unfolded<'r, I::Vertex>,
    strategies: Ref<'r, [S]>,
    walks: [Walk; 2],
    /// The strategy that draws last vertices for themselves, and how many vertices it reads.
    ending: u32,
    ending_reads: usize,
    /// The techniques of paths of the length in question, and whether the last vertex is drawn for itself by one of them.
    row: &'r [Technique<RealOf<I>>],
    ends: bool,
    /// The length of the paths whose sums are made; none at first.
    summed_up: usize,
    joints: RefMut<'r, Joints<I::Vertex>>,
    /// The last vertices that were drawn for themselves, by the length of the path.
    lasts: &'r [Option<Drawn<I::Vertex>>],
    /// What all paths share that begin with so many vertices of the first walk, or end with so many of the second one.
    carried: [Carried<I::Value>; 2],
}

impl<'r, I, S, H, D> Pieces<'r, I, S, H, D>
where
    I: PathIntegrand,
    S: Strategy<I::Vertex>,
    H: Separable<RealOf<I>>,
    D: Fn(usize, usize) -> bool,
{
    /// Whether paths need not be made to weigh them.
    pub fn are_plain(
        estimator: &Estimator<I, Factors<I::Value>>,
        walks: [&RandomSequence<'_, I::Vertex, S>; 2],
        connections: &Connections<'_, S, RealOf<I>, H, D>,
    ) -> bool {
        let arena = walks[0].arena;
        S::VERTICES == 1
            && estimator.reads() <= LAST
            && arena.tape.is_undirected()
            && walks.iter().all(|walk| walk.is_run())
            && arena.most_read.get() <= READS
            && connections.ending.is_none_or(|by| by.reads().vertices <= READS)
    }

    /// The pieces of two walks. In line, as there is much in them.
    #[inline(always)]
    pub fn new(
        estimator: &'r Estimator<I, Factors<I::Value>>,
        walks: [&RandomSequence<'r, I::Vertex, S>; 2],
        connections: &'r Connections<'r, S, RealOf<I>, H, D>,
        tape: &'r Unfolded<'r, I::Vertex>,
        lasts: &'r [Option<Drawn<I::Vertex>>],
    ) -> Self {
        let arena = walks[0].arena;
        let ending = connections.ending.map(|strategy| arena.intern(strategy.clone()));
        let joints = arena.joints.borrow_mut();
        let carried = core::mem::take(&mut estimator.factors.borrow_mut().carried);
        Pieces {
            estimator,
            connections,
            heuristic: connections.techniques.heuristic(),
            arena,
            tape,
            strategies: Ref::map(arena.strategies.borrow(), Vec::as_slice),
            walks: walks.map(|walk| Walk { place: walk.handle.place, len: walk.len() }),
            ending: ending.unwrap_or(u32::MAX),
            ending_reads: connections.ending.map_or(0, |strategy| strategy.reads().vertices),
            row: &[],
            ends: false,
            summed_up: 0,
            joints,
            lasts,
            carried,
        }
    }

    /// Looks up the walks, and computes what their pieces carry; returns whether that stays in the range of numbers.
    /// Otherwise paths have to be made to weigh them.
    pub fn prepare(&mut self) -> bool {
        for end in [End::First, End::Second] {
            self.learn(end);
            self.joints.sides[end as usize].forget_sums();
        }
        self.carry()
    }

    /// How a strategy makes the vertex of a step from one end.
    #[inline]
    fn asked(&self, strategy: u32, end: End, step: usize) -> Question {
        let known = &self.strategies[strategy as usize];
        (strategy << 1 | end as u32, length_class(known, known.reads(), step))
    }

    /// Looks up the vertices and the steps of a walk, if it is not the one that was asked for last.
    fn learn(&mut self, end: End) {
        let walk @ Walk { place, len } = self.walks[end as usize];
        let (tape, strategies, arena) = (self.tape, &self.strategies, self.arena);
        let side = &mut self.joints.sides[end as usize];
        if side.walk == Some(walk) {
            return;
        }
        side.begin(walk);
        // Of a walk that is one run, drawing a vertex has mostly told its density.
        let steps = tape.steps_of_run(place);
        let mut tail = Tail::EMPTY;
        for (k, step) in steps[..len].iter().enumerate() {
            let fixed = step.dirac == Some(Dirac::Position);
            let told = tape.value_of(step.vertex);
            let own = told.unwrap_or_else(|| arena.factor(place, k, place.range(0, k + 1)));
            let own = PathDensity::new(own);
            tail = side.add(tail, Stop { id: step.vertex, visible: step.visible, fixed, own }, end);
        }
        // Mostly a step makes its vertex as the one before it does.
        let mut k = 0;
        while k < steps.len() {
            let id = steps[k].way.strategy();
            let strategy = &strategies[id as usize];
            let reads = strategy.reads();
            let (class, first) = (length_class(strategy, reads, k), k);
            let alike = steps[k..].iter().zip(k..).take_while(|(step, k)| {
                step.way.strategy() == id
                    && (!reads.length || length_class(strategy, reads, *k) == class)
            });
            k += alike.count().max(1);
            let question = (id << 1 | end as u32, class);
            side.steps.extend(core::iter::repeat_n((question, first as u32), k - first));
        }
    }

    /// Computes what pieces of the walks carry, unless these are the ones that were asked for last; returns whether that
    /// stays in the range of numbers.
    fn carry(&mut self) -> bool {
        let (estimator, arena, tape) = (self.estimator, self.arena, self.tape);
        let ([first, second], reads) = (self.walks, estimator.reads());
        let [ahead, behind] = &mut self.carried;
        if ahead.begin(arena.contents(), first) {
            let mut value = I::Value::one();
            ahead.values.push(value);
            for (len, piece) in self.joints.sides[0].pieces.iter().enumerate().skip(1) {
                if !value.is_zero() {
                    let window = window(tape, [&piece.tail, &Tail::EMPTY]);
                    let view = PathView::of_window(&window, BEHIND - 1, false, len);
                    value = per(value.multiply(estimator.extended(view)), piece.own.value());
                }
                ahead.values.push(value);
            }
        }
        if !behind.begin(arena.contents(), second) {
            return behind.in_range;
        }
        let mut value = I::Value::one();
        behind.values.push(value);
        // All that the factor reads which closes a path, if there is so much of the second walk.
        let mut closing = I::Value::one();
        let pieces = &self.joints.sides[1].pieces;
        for (len, piece) in pieces.iter().enumerate().skip(1) {
            // The edge that the new vertex completes: all that its factor reads is there.
            if len >= reads {
                let window = window(tape, [&Tail::EMPTY, &piece.tail]);
                let place = BEHIND + reads - 1;
                let view = PathView::of_window(&window, place, false, reads);
                value = value.multiply(estimator.extended(view));
                if len == reads {
                    closing = estimator.closing(view);
                }
            }
            value = per(value, piece.own.value());
            behind.values.push(value.multiply(closing));
        }
        // What has left the range of numbers does not come back.
        behind.in_range = pieces.len() == 1 || is_usable(value);
        behind.in_range
    }

    /// Visits the paths that contribute.
    pub fn visit(&mut self, visit: &mut impl FnMut(Connected<I::Value>)) {
        // A last vertex may be drawn behind all of the first walk.
        let longest = self.connections.longest(self.walks[0].len + self.walks[1].len.max(1));
        for length in (*self.connections.lengths.start()).max(1)..=longest {
            self.row = self.connections.techniques.row(length);
            self.ends = self.connections.end(length);
            self.visit_length(length, visit);
        }
    }

    /// Visits the paths with so many vertices that contribute.
    fn visit_length(&mut self, length: usize, visit: &mut impl FnMut(Connected<I::Value>)) {
        let [first, second] = self.walks;
        for first in length.saturating_sub(second.len.max(1))..first.len.min(length) + 1 {
            let Technique { samples, mass } = self.row[first];
            if samples == 0 {
                continue;
            }
            let ends = self.ends && first + 1 == length;
            let last = if ends { self.lasts.get(length).and_then(Option::as_ref) } else { None };
            let exists = if ends { last.is_some() } else { first + second.len >= length };
            if !exists || !(self.connections.is_drawn)(length, first) {
                continue;
            }
            let joined = self.joined(Joint { length, first }, last);
            let Some(value) = self.value(&joined) else { continue };
            // Not a local variable: the compiler would make a loop of the paths that carry nothing, within that of all, and load
            // what this one needs anew whenever it is entered.
            if self.summed_up != length {
                self.sum_up(length);
                self.summed_up = length;
            }
            let weight = self.others(&joined).share_beside(mass);
            let alone = value.over(RealOf::<I>::of(samples as f64));
            visit(Connected { length, first, value: alone.times(weight), alone });
        }
    }

    /// A path with its vertices about the joint, the last of which may have been drawn for itself.
    #[inline(always)]
    fn joined(&self, joint: Joint, last: Option<&'r Drawn<I::Vertex>>) -> Joined<'r, I::Vertex> {
        let (tape, [first, second]) = (self.tape, &self.joints.sides);
        let ahead = &first.pieces[joint.first].tail;
        let behind = match last {
            Some(_) => &Tail::EMPTY,
            None => &second.pieces[joint.length - joint.first].tail,
        };
        let mut joined = Joined { joint, last, window: window(tape, [ahead, behind]) };
        if let Some(last) = last {
            let window = &mut joined.window;
            window.vertices[BEHIND] = Some(&last.vertex);
            window.sees_next |= u16::from(last.visible) << (BEHIND - 1);
            window.fixed |= u16::from(last.dirac == Some(Dirac::Position)) << BEHIND;
        }
        joined
    }

    /// f / p of a path, not weighted, if it is not zero.
    fn value(&self, joined: &Joined<'_, I::Vertex>) -> Option<I::Value> {
        let (Joint { length, first }, last) = (joined.joint, joined.last);
        let behind = length - first;
        let mut value = self.carried[0].values[first];
        if last.is_none() {
            value = value.multiply(self.carried[1].values[behind]);
        }
        if value.is_zero() {
            return None;
        }
        // What goes on behind the edge may vanish without a shadow ray.
        let reads = self.estimator.reads();
        let own = if last.is_some() { behind } else { behind.min(reads - 1) };
        let view = |place: usize| {
            let len = first + place + 1 - BEHIND;
            PathView::of_window(&joined.window, place, false, len)
        };
        for distance in [1, 0] {
            if distance < own {
                let factor = self.estimator.extended(view(BEHIND + distance));
                value = value.multiply(factor);
                if value.is_zero() {
                    return None;
                }
            }
        }
        if last.is_some() {
            let density = self.density_of_last(joined).value();
            value = per(value, density);
        }
        if last.is_none() && behind >= reads {
            return Some(value);
        }
        value = value.multiply(self.estimator.closing(view(joined.place(length - 1))));
        (!value.is_zero()).then_some(value)
    }
}

/// The last vertices of a piece of either walk, about the joint between them.
#[inline(always)]
fn window<'r, V: Vertex>(tape: &'r Unfolded<'r, V>, [ahead, behind]: [&Tail; 2]) -> Window<'r, V> {
    let vertices = |tail: &Tail| tail.ids.map(|id| tape.vertex_of(id));
    let ([a, b, c], [d, e, f]) = (vertices(ahead), vertices(behind));
    Window {
        vertices: [None, None, c, b, a, d, e, f, None, None],
        sees_next: ahead.sees_next | behind.sees_next,
        fixed: ahead.fixed | behind.fixed,
    }
}

impl<I: PathIntegrand, S, H, D> Drop for Pieces<'_, I, S, H, D> {
    /// Gives back what was borrowed of the estimator.
    fn drop(&mut self) {
        self.estimator.factors.borrow_mut().carried = core::mem::take(&mut self.carried);
    }
}
