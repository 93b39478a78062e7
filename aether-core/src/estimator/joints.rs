//! Paths of two pieces that are weighed without being made: their techniques differ in which piece ends where, and
//! sums over them grow with the pieces.
//!
//! Vertex k of a piece has the density `own` under its walk; let r_k be the density with which the other walk would have
//! made it, over that. Relative to the technique that joins both pieces behind vertex k, those that join them before it
//! add up to s_{k+1} = term(r_k) (m_k + s_k), where m_k stands for the technique whose piece has k vertices: the
//! term of its number of samples. A joint decides r_k of the last two vertices of a piece only, as strategies
//! read two vertices; the sum of those before them is one for all joints of paths of one length.

use core::cell::{Ref, RefMut};

use crate::combine::Separable;
use crate::estimator::connections::{Connected, Connections};
use crate::estimator::{Estimator, Factors, PathIntegrand, RealOf, Value, is_regular};
use crate::path_density::PathDensity;
use crate::real::{Real, Scalar};
use crate::sequence::{
    Arena, LAST, PathView, Place, RandomSequence, Step, Unfolded, WINDOW, Window, length_class,
};
use crate::strategy::{Dirac, Drawn, Strategy, Vertex};
use crate::work::count_densities;

/// The most vertices that a strategy may read, and one less than those of a factor of the integrand.
const READS: usize = LAST - 1;

/// A density, or a sum of terms, of paths of an integrand.
type DensityOf<I> = PathDensity<RealOf<I>>;

/// A strategy and the side that it comes from, and the class of lengths of what lies before.
type Question = (u32, u32);

/// What is known of a vertex.
#[derive(Clone, Debug)]
struct Known<R> {
    /// Its density under the strategy that drew it.
    own: Option<PathDensity<R>>,
    /// Densities that depend on vertices of its own piece alone, under the strategies that were asked last.
    others: [(Question, PathDensity<R>); 2],
}

/// What an arena remembers of how the vertices of walks could have been made.
#[derive(Clone, Debug)]
pub(crate) struct Joints<R> {
    /// By the id of a vertex.
    known: Vec<Known<R>>,
    /// The terms of the numbers of samples of all techniques, by the number of vertices of the first walk.
    masses: Vec<PathDensity<R>>,
    /// The sums of either piece, up to each vertex.
    sums: [Vec<Sum<R>>; 2],
}

/// What the techniques that join a path before a vertex of a piece add up to, and what that depends on, beside the sum up
/// to the vertex before: mostly it is the same for paths of several lengths.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Sum<R> {
    /// The name of the run up to the last vertex that matters.
    run: u32,
    /// The mass of the technique that joins a path right there.
    mass: PathDensity<R>,
    /// How the other walk would have made the vertex, if it has a step for that.
    question: Option<Question>,
    sum: PathDensity<R>,
}

impl<R: Scalar> Joints<R> {
    pub fn new() -> Self {
        Joints { known: Vec::new(), masses: Vec::new(), sums: [Vec::new(), Vec::new()] }
    }

    pub fn clear(&mut self) {
        self.known.clear();
        self.sums.iter_mut().for_each(Vec::clear);
    }

    /// What the techniques add up to that join a path before vertex `k` of a piece.
    #[inline]
    fn sum(&self, end: End, k: usize) -> PathDensity<R> {
        k.checked_sub(1).map_or(PathDensity::ZERO, |last| self.sums[end as usize][last].sum)
    }

    /// Makes room for so many vertices.
    #[inline]
    fn reserve(&mut self, vertices: usize) {
        if vertices > self.known.len() {
            let nothing = Known { own: None, others: [((u32::MAX, 0), PathDensity::ZERO); 2] };
            self.known.resize(vertices, nothing);
        }
    }

    /// What is known of a vertex that there is room for.
    #[inline]
    fn of(&mut self, vertex: u32) -> &mut Known<R> {
        &mut self.known[vertex as usize]
    }
}

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

    /// The pieces of two walks and a last vertex, which is at a position of the tape; `None` if paths have to be made to
    /// weigh them.
    pub fn new(
        estimator: &'r Estimator<I, Factors<I::Value>>,
        walks: [&RandomSequence<'r, I::Vertex, S>; 2],
        connections: &'r Connections<'r, S, N, D>,
        heuristic: &'r H,
        tape: &'r Unfolded<'r, I::Vertex>,
        [ending, last]: [Option<usize>; 2],
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
            ending: ending.map_or(u32::MAX, |ending| ending as u32),
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

    /// The terms of all other techniques, relative to that of a sample of the technique that made a path.
    fn others(&mut self, joined: &Joined<'_, I::Vertex>) -> DensityOf<I> {
        let (n, Joint { first, ends }) = (self.connections.length, joined.joint);
        if ends {
            let own = self.density_of_last(joined);
            let mut sum = self.joints.masses[n];
            if !sum.is_zero() {
                let density = self.near_by_step(joined, End::First, n - 1);
                sum = sum * self.heuristic.term(density / own);
            }
            let further = self.chain(joined, End::First, first);
            if further.is_zero() {
                return sum;
            }
            let density = self.near_by_step(joined, End::Second, n - 1);
            return sum + further * self.heuristic.term(density / own);
        }
        if first < n {
            return self.chain(joined, End::First, first)
                + self.chain(joined, End::Second, n - first);
        }
        let further = self.chain(joined, End::First, n);
        if !self.connections.ends_after(n - 1) || self.joints.masses[n - 1].is_zero() {
            return further;
        }
        let density = self.near(joined, End::First, n - 1, self.ending);
        let own = self.own(End::First, n - 1);
        further + self.joints.masses[n - 1] * self.heuristic.term(density / own)
    }

    /// The sum of the techniques that join a path before the end of a piece of `len` vertices. What it starts from is
    /// that of those that do before the last vertices of the piece, for which alone the joint matters.
    fn chain(&mut self, joined: &Joined<'_, I::Vertex>, end: End, len: usize) -> DensityOf<I> {
        let start = len.saturating_sub(READS);
        let mut sum = self.joints.sum(end, start);
        for k in start..len {
            let ending = |pieces: &mut Self, i: usize| match len > READS {
                true => pieces.density(joined.joint, End::First, i, pieces.ending),
                false => pieces.near(joined, End::First, i, pieces.ending),
            };
            sum = self.mass(end, k, ending) + sum;
            if !sum.is_zero() {
                let other = self.near_by_step(joined, end.other(), self.index(end, k));
                sum = sum * self.heuristic.term(other / self.own(end, k));
            }
        }
        sum
    }

    /// The masses of all techniques.
    fn weigh_samples(&mut self) {
        let (connections, heuristic) = (self.connections, self.heuristic);
        let (mut count, mut mass) = (0, PathDensity::ZERO);
        let masses = (0..=connections.length).map(|first| {
            let samples = (connections.samples)(first);
            if samples != count {
                let number = PathDensity::new(RealOf::<I>::of(samples as f64));
                (count, mass) = (samples, heuristic.term(number));
            }
            mass
        });
        self.joints.masses.clear();
        self.joints.masses.extend(masses);
    }

    /// The sums of all but the last two vertices of either walk.
    fn sum_up(&mut self) {
        let n = self.connections.length;
        for end in [End::First, End::Second] {
            let len = self.walks[end as usize].len;
            // Of the other piece only the length matters.
            let first = if end == End::First { len } else { n - len };
            let joint = Joint { first, ends: false };
            let mut sum = PathDensity::ZERO;
            for k in 0..len.saturating_sub(READS) {
                sum = self.summed(joint, end, k, sum);
            }
        }
    }

    /// What the techniques add up to that join a path before vertex k + 1 of a piece, from that of those that do before
    /// vertex k, both far from the joint.
    #[inline]
    fn summed(&mut self, joint: Joint, end: End, k: usize, sum: DensityOf<I>) -> DensityOf<I> {
        let ending = |pieces: &mut Self, i| pieces.density(joint, End::First, i, pieces.ending);
        let mass = self.mass(end, k, ending);
        let (i, run) =
            (self.index(end, k), self.tape.id(self.walks[end as usize].place, k + READS));
        let question = self.step_of(end.other(), i).map(|step| self.question(end.other(), i, step));
        let known = self.joints.sums[end as usize].get(k);
        if let Some(known) = known
            && (known.run, known.mass, known.question) == (run, mass, question)
        {
            return known.sum;
        }
        let mut sum = mass + sum;
        if !sum.is_zero() {
            let step = self.step_of(end.other(), i);
            let other = step.map(|step| self.density(joint, end.other(), i, step));
            let other = other.unwrap_or(PathDensity::ZERO);
            sum = sum * self.heuristic.term(other / self.own(end, k));
        }
        // Those that follow have been computed from another one.
        let sums = &mut self.joints.sums[end as usize];
        sums.truncate(k);
        sums.push(Sum { run, mass, question, sum });
        sum
    }

    /// How a strategy that comes from one end would make vertex `i` of a path.
    #[inline]
    fn question(&self, end: End, i: usize, strategy: u32) -> Question {
        let known = &self.strategies[strategy as usize];
        let class = length_class(known, known.reads(), self.index(end, i));
        (strategy << 1 | end as u32, class)
    }

    /// What stands for the technique that joins a path behind `k` vertices of a piece: the term of its number of
    /// samples. Where it draws the last vertex for itself, that has another density than its walk's: `ending`, of
    /// vertex `i` of the path.
    #[inline]
    fn mass(
        &mut self,
        end: End,
        k: usize,
        ending: impl FnOnce(&mut Self, usize) -> DensityOf<I>,
    ) -> DensityOf<I> {
        let n = self.connections.length;
        let first = if end == End::First { k } else { n - k };
        let mass = self.joints.masses[first];
        if mass.is_zero() || !self.connections.ends_after(first) {
            return mass;
        }
        if end == End::First {
            return PathDensity::ZERO; // It does not continue what the second walk would have begun.
        }
        let density = ending(self, n - 1);
        mass * self.heuristic.term(density / self.own(End::Second, 0))
    }

    /// The step of a walk that would make vertex `i` of a path, if there is one.
    #[inline]
    fn step_of(&self, end: End, i: usize) -> Option<u32> {
        let (place, k) = (self.walks[end as usize].place, self.index(end, i));
        (k < place.len as usize).then(|| self.tape.way(place, k).strategy())
    }

    /// The density of vertex `i` of a path, far from the joint, under a strategy that comes from one end: it depends on
    /// nothing but vertices of one piece, and is remembered.
    fn density(&mut self, joint: Joint, end: End, i: usize, strategy: u32) -> DensityOf<I> {
        let question = self.question(end, i, strategy);
        let known = &self.strategies[strategy as usize];
        let at = self.position(joint, i);
        let id = self.tape.vertex_id(at);
        let others = &self.joints.of(id).others;
        if let Some((_, density)) = others.iter().find(|(asked, _)| *asked == question) {
            return *density;
        }
        let Some(target) = self.tape.at_hand(at) else { return PathDensity::ZERO };
        let is_fixed = self.tape.is_drawn_with(at, Dirac::Position);
        let view = self.before(joint, i, end, known.reads().vertices);
        let density = evaluated(known, view, target, is_fixed);
        let [last, before] = &mut self.joints.of(id).others;
        *before = core::mem::replace(last, (question, density));
        density
    }

    /// The density of vertex `i` of a path, next to the joint, under the step of a walk that would make it.
    #[inline]
    fn near_by_step(&self, joined: &Joined<'_, I::Vertex>, end: End, i: usize) -> DensityOf<I> {
        let strategy = self.step_of(end, i);
        strategy.map_or(PathDensity::ZERO, |strategy| self.near(joined, end, i, strategy))
    }

    /// The density of vertex `i` of a path, next to the joint, under a strategy that comes from one end.
    #[inline]
    fn near(
        &self,
        joined: &Joined<'_, I::Vertex>,
        end: End,
        i: usize,
        strategy: u32,
    ) -> DensityOf<I> {
        let (place, backward) = (joined.place(i), end == End::Second);
        let Some(target) = joined.window.vertices[place] else { return PathDensity::ZERO };
        let is_fixed = joined.window.fixed >> place & 1 == 1;
        let last = if backward { place + 1 } else { place - 1 };
        let view = PathView::of_window(&joined.window, last, backward, self.index(end, i));
        evaluated(&self.strategies[strategy as usize], view, target, is_fixed)
    }

    /// The density with which the last vertex of a path was drawn for itself.
    fn density_of_last(&self, joined: &Joined<'_, I::Vertex>) -> DensityOf<I> {
        let known = self.last.and_then(|at| self.tape.own(Place::new(at, 1), 0));
        let i = self.connections.length - 1;
        known.map_or_else(|| self.near(joined, End::First, i, self.ending), PathDensity::new)
    }

    /// The density of vertex `k` of a walk under its own strategy.
    #[inline]
    fn own(&mut self, end: End, k: usize) -> DensityOf<I> {
        let place = self.walks[end as usize].place;
        let id = self.tape.id(place, k);
        if let Some(known) = self.joints.of(id).own {
            return known;
        }
        let own = PathDensity::new(self.arena.factor(place, k, place.range(0, k + 1)));
        self.joints.of(id).own = Some(own);
        own
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

/// The density of a vertex under a strategy after a path, or its probability if it can be nowhere else.
#[inline]
fn evaluated<V: Vertex, S: Strategy<V>>(
    strategy: &S,
    path: PathView<'_, V>,
    target: &V,
    is_fixed: bool,
) -> PathDensity<V::Real> {
    let dirac = is_fixed.then_some(Dirac::Position);
    count_densities(1);
    let view = path.asking(dirac).limited(strategy.reads());
    PathDensity::new(strategy.pdf(view, target).of_kind(dirac))
}
