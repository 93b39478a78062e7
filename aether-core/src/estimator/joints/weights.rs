//! The weights of paths of two pieces: sums over the techniques that would have joined them elsewhere.

use super::known::{Question, Ratio};
use super::{DensityOf, End, Joined, Joint, Pieces, READS};
use crate::combine::Separable;
use crate::estimator::{PathIntegrand, RealOf};
use crate::path_density::PathDensity;
use crate::real::Real;
use crate::sequence::{NONE, PathView, Place, length_class};
use crate::strategy::{Dirac, Strategy, Vertex};
use crate::work::count_densities;

impl<'r, I, S, N, D, H> Pieces<'r, I, S, N, D, H>
where
    I: PathIntegrand,
    S: Strategy<I::Vertex>,
    N: Fn(usize) -> usize,
    D: Fn(usize) -> bool,
    H: Separable<RealOf<I>>,
{
    /// The terms of all other techniques, relative to that of a sample of the technique that made a path.
    pub(super) fn others(&mut self, joined: &Joined<'_, I::Vertex>) -> DensityOf<I> {
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
        let mut sum = self.joints.sums[end as usize][start];
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
    pub(super) fn weigh_samples(&mut self) {
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
    pub(super) fn sum_up(&mut self) {
        let n = self.connections.length;
        for end in [End::First, End::Second] {
            let len = self.walks[end as usize].len;
            // Of the other piece only the length matters.
            let first = if end == End::First { len } else { n - len };
            let joint = Joint { first, ends: false };
            let mut sum = PathDensity::ZERO;
            self.joints.sums[end as usize].clear();
            self.joints.sums[end as usize].push(sum);
            for k in 0..len.saturating_sub(READS) {
                let ending =
                    |pieces: &mut Self, i| pieces.density(joint, End::First, i, pieces.ending);
                sum = self.mass(end, k, ending) + sum;
                if !sum.is_zero() {
                    sum = sum * self.heuristic.term(self.ratio(joint, end, k));
                }
                self.joints.sums[end as usize].push(sum);
            }
        }
    }

    /// The density with which the other walk would have made vertex k of a piece, far from the joint, over that under its
    /// own walk.
    fn ratio(&mut self, joint: Joint, end: End, k: usize) -> DensityOf<I> {
        let i = self.index(end, k);
        let Some(step) = self.step_of(end.other(), i) else { return PathDensity::ZERO };
        let run = self.tape.id(self.walks[end as usize].place, k + READS);
        let question = self.question(end.other(), i, step);
        if let Some(known) = self.joints.ratios[end as usize].get(k)
            && (known.run, known.question) == (run, question)
        {
            return known.value;
        }
        let value = self.density(joint, end.other(), i, step) / self.own(end, k);
        let ratios = &mut self.joints.ratios[end as usize];
        // A vertex before may have had no need of one.
        let none = Ratio { run: NONE, question, value };
        ratios.resize(ratios.len().max(k + 1), none);
        ratios[k] = Ratio { run, question, value };
        value
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
    pub(super) fn density_of_last(&self, joined: &Joined<'_, I::Vertex>) -> DensityOf<I> {
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
