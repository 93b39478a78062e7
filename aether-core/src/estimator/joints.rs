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
use crate::sequence::{Arena, LAST, PathView, Place, RandomSequence, Step, Unfolded, length_class};
use crate::strategy::{Dirac, Drawn, Strategy};
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
    /// The sums of either piece.
    sums: [Vec<PathDensity<R>>; 2],
}

impl<R: Scalar> Joints<R> {
    pub fn new() -> Self {
        Joints { known: Vec::new(), masses: Vec::new(), sums: [Vec::new(), Vec::new()] }
    }

    pub fn clear(&mut self) {
        self.known.clear();
    }

    /// What is known of a vertex.
    #[inline]
    fn of(&mut self, vertex: u32) -> &mut Known<R> {
        let vertex = vertex as usize;
        if vertex >= self.known.len() {
            let nothing = Known { own: None, others: [((u32::MAX, 0), PathDensity::ZERO); 2] };
            self.known.resize(vertex + 1, nothing);
        }
        &mut self.known[vertex]
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

/// Two walks whose pieces are joined to paths of one length.
pub(super) struct Pieces<'r, I: PathIntegrand, S, N, D, H> {
    estimator: &'r Estimator<I, Factors<I::Value>>,
    connections: &'r Connections<'r, S, N, D>,
    heuristic: &'r H,
    arena: &'r Arena<I::Vertex, S>,
    tape: Unfolded<'r, I::Vertex>,
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
    /// The pieces of two walks and a last vertex; `None` if paths have to be made to weigh them.
    pub fn new(
        estimator: &'r Estimator<I, Factors<I::Value>>,
        walks: [&RandomSequence<'r, I::Vertex, S>; 2],
        connections: &'r Connections<'r, S, N, D>,
        heuristic: &'r H,
        drawn: Option<&Drawn<I::Vertex>>,
    ) -> Option<Self> {
        let (arena, length) = (walks[0].arena, connections.length);
        let plain = S::VERTICES == 1
            && estimator.reads() <= LAST
            && arena.tape.is_undirected()
            && drawn.is_none_or(|drawn| drawn.dirac != Some(Dirac::Direction))
            && walks.iter().all(|walk| walk.is_run())
            && connections.ending.is_none_or(|ending| ending.reads().vertices <= READS)
            && arena.most_read.get() <= READS;
        if !plain {
            return None;
        }
        let ending = connections.ending.map_or(u32::MAX, |ending| arena.intern(ending.clone()));
        let last = drawn.map(|drawn| arena.tape.keep(drawn).at(0));
        let mut pieces = Pieces {
            estimator,
            connections,
            heuristic,
            arena,
            tape: arena.tape.unfolded(),
            strategies: Ref::map(arena.strategies.borrow(), Vec::as_slice),
            walks: walks.map(|walk| Walk { place: walk.handle.place, len: walk.len().min(length) }),
            last,
            ending,
            joints: arena.joints.borrow_mut(),
        };
        pieces.behind(pieces.walks[1].len)?;
        pieces.sum_up();
        Some(pieces)
    }

    /// Visits the paths that contribute.
    pub fn visit(&mut self, visit: &mut impl FnMut(Connected<I::Value>)) {
        let connections = self.connections;
        let [first, second] = self.walks;
        for first in 0..=first.len {
            let mass = self.joints.masses[first];
            let ends = connections.ends_after(first);
            let exists =
                if ends { self.last.is_some() } else { first + second.len >= connections.length };
            if mass.is_zero() || !exists || !(connections.is_drawn)(first) {
                continue;
            }
            let joint = Joint { first, ends };
            let value = self.value(joint);
            if value.is_zero() {
                continue;
            }
            let others = self.others(joint) / mass;
            let weight = (PathDensity::ONE / (PathDensity::ONE + others)).value();
            let samples = RealOf::<I>::of((connections.samples)(first) as f64);
            let value = value.over(samples);
            visit(Connected { first, value: value.times(weight), alone: value });
        }
    }

    /// f / p of a path, not weighted.
    fn value(&self, joint: Joint) -> I::Value {
        let (n, first) = (self.connections.length, joint.first);
        let place = self.walks[0].place.range(0, first);
        let mut value = self.estimator.ahead(self.arena, &self.tape, place, first);
        if value.is_zero() {
            return value;
        }
        // What goes on behind the edge may vanish without a shadow ray.
        let own = (n - first).min(self.estimator.reads() - 1);
        for k in (first..first + own).rev() {
            value = value.multiply(self.estimator.extended(self.before(
                joint,
                k + 1,
                End::First,
                LAST,
            )));
            if value.is_zero() {
                return value;
            }
        }
        if joint.ends {
            let density = self.density_of_last(joint).value();
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
        self.estimator.ending(self.arena, &self.tape, place, 0)
    }

    /// The terms of all other techniques, relative to that of a sample of the technique that made a path.
    fn others(&mut self, joint: Joint) -> DensityOf<I> {
        let (n, first) = (self.connections.length, joint.first);
        if joint.ends {
            let own = self.density_of_last(joint);
            let mut sum = self.joints.masses[n];
            if !sum.is_zero() {
                let density = self.by_step(joint, End::First, n - 1, false);
                sum = sum * self.heuristic.term(density / own);
            }
            let further = self.chain(joint, End::First, first);
            if further.is_zero() {
                return sum;
            }
            let density = self.by_step(joint, End::Second, n - 1, false);
            return sum + further * self.heuristic.term(density / own);
        }
        if first < n {
            return self.chain(joint, End::First, first)
                + self.chain(joint, End::Second, n - first);
        }
        let further = self.chain(joint, End::First, n);
        if !self.connections.ends_after(n - 1) || self.joints.masses[n - 1].is_zero() {
            return further;
        }
        let density = self.density(joint, End::First, n - 1, self.ending, false);
        let own = self.own(End::First, n - 1);
        further + self.joints.masses[n - 1] * self.heuristic.term(density / own)
    }

    /// The sum of the techniques that join a path before the end of a piece of `len` vertices.
    fn chain(&mut self, joint: Joint, end: End, len: usize) -> DensityOf<I> {
        let start = len.saturating_sub(READS);
        let sum = self.joints.sums[end as usize][start];
        (start..len).fold(sum, |sum, k| self.extended(joint, end, k, sum, len))
    }

    /// The sum of the techniques that join a path before vertex k + 1 of a piece of `len` vertices, from that of those
    /// that do before vertex k.
    #[inline]
    fn extended(
        &mut self,
        joint: Joint,
        end: End,
        k: usize,
        sum: DensityOf<I>,
        len: usize,
    ) -> DensityOf<I> {
        let sum = self.mass(joint, end, k, len) + sum;
        if sum.is_zero() {
            return sum;
        }
        let i = self.index(end, k);
        let other = self.by_step(joint, end.other(), i, k + READS < len);
        sum * self.heuristic.term(other / self.own(end, k))
    }

    /// The masses of all techniques, and the sums of all but the last two vertices of either walk.
    fn sum_up(&mut self) {
        let n = self.connections.length;
        self.joints.masses.clear();
        let (mut count, mut mass) = (0, PathDensity::ZERO);
        for first in 0..=n {
            let samples = (self.connections.samples)(first);
            if samples != count {
                let number = PathDensity::new(RealOf::<I>::of(samples as f64));
                (count, mass) = (samples, self.heuristic.term(number));
            }
            self.joints.masses.push(mass);
        }
        for end in [End::First, End::Second] {
            let len = self.walks[end as usize].len;
            // Of the other piece only the length matters.
            let first = if end == End::First { len } else { n - len };
            let joint = Joint { first, ends: false };
            let mut sum = PathDensity::ZERO;
            self.joints.sums[end as usize].clear();
            self.joints.sums[end as usize].push(sum);
            for k in 0..len.saturating_sub(READS) {
                sum = self.extended(joint, end, k, sum, len);
                self.joints.sums[end as usize].push(sum);
            }
        }
    }

    /// What stands for the technique that joins a path behind `k` vertices of a piece of `len`: the term of its
    /// number of samples. Where it draws the last vertex for itself, that has another density than its walk's.
    #[inline]
    fn mass(&mut self, joint: Joint, end: End, k: usize, len: usize) -> DensityOf<I> {
        let n = self.connections.length;
        let first = if end == End::First { k } else { n - k };
        let mass = self.joints.masses[first];
        if mass.is_zero() || !self.connections.ends_after(first) {
            return mass;
        }
        if end == End::First {
            return PathDensity::ZERO; // It does not continue what the second walk would have begun.
        }
        let density = self.density(joint, End::First, n - 1, self.ending, len > READS);
        mass * self.heuristic.term(density / self.own(End::Second, 0))
    }

    /// The density of vertex `i` of a path under the step of a walk that would make it. What depends on nothing but
    /// vertices of one piece is remembered.
    #[inline]
    fn by_step(&mut self, joint: Joint, end: End, i: usize, remember: bool) -> DensityOf<I> {
        let (place, k) = (self.walks[end as usize].place, self.index(end, i));
        if k >= place.len as usize {
            return PathDensity::ZERO;
        }
        self.density(joint, end, i, self.tape.way(place, k).strategy(), remember)
    }

    /// The density of vertex `i` of a path under a strategy that comes from one end.
    #[inline]
    fn density(
        &mut self,
        joint: Joint,
        end: End,
        i: usize,
        strategy: u32,
        remember: bool,
    ) -> DensityOf<I> {
        if !remember {
            return self.evaluated(joint, end, i, strategy);
        }
        let known = &self.strategies[strategy as usize];
        let class = length_class(known, known.reads(), self.index(end, i));
        let question = (strategy << 1 | end as u32, class);
        let id = self.tape.vertex_id(self.position(joint, i));
        let others = &self.joints.of(id).others;
        if let Some((_, density)) = others.iter().find(|(asked, _)| *asked == question) {
            return *density;
        }
        let density = self.evaluated(joint, end, i, strategy);
        let [last, before] = &mut self.joints.of(id).others;
        *before = core::mem::replace(last, (question, density));
        density
    }

    /// The same, not remembered.
    #[inline]
    fn evaluated(&self, joint: Joint, end: End, i: usize, strategy: u32) -> DensityOf<I> {
        let at = self.position(joint, i);
        let Some(target) = self.tape.vertex(at) else { return PathDensity::ZERO };
        let strategy = &self.strategies[strategy as usize];
        let dirac = self.tape.is_drawn_with(at, Dirac::Position).then_some(Dirac::Position);
        let reads = strategy.reads();
        let view = self.before(joint, i, end, reads.vertices).asking(dirac).limited(reads);
        count_densities(1);
        PathDensity::new(strategy.pdf(view, &target).of_kind(dirac))
    }

    /// The density with which the last vertex of a path was drawn for itself.
    fn density_of_last(&self, joint: Joint) -> DensityOf<I> {
        let known = self.last.and_then(|at| self.tape.own(Place::new(at, 1), 0));
        let i = self.connections.length - 1;
        known.map_or_else(|| self.evaluated(joint, End::First, i, self.ending), PathDensity::new)
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
        PathView::of_last(&self.tape, last, len, read)
    }
}
