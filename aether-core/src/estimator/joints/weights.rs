//! The weights of paths of two pieces: sums over the techniques that would have joined them elsewhere.

use super::known::Question;
use super::{DensityOf, End, Joined, Joint, Pieces, READS};
use crate::combine::Separable;
use crate::estimator::{PathIntegrand, RealOf};
use crate::path_density::PathDensity;
use crate::sequence::{PathView, Place};
use crate::strategy::{Dirac, Strategy, Vertex};
use crate::work::count_densities;

impl<'r, I, S, H, D> Pieces<'r, I, S, H, D>
where
    I: PathIntegrand,
    S: Strategy<I::Vertex>,
    H: Separable<RealOf<I>>,
    D: Fn(usize, usize) -> bool,
{
    /// The terms of all other techniques, relative to that of a sample of the technique that made a path.
    pub(super) fn others(&self, joined: &Joined<'_, I::Vertex>) -> DensityOf<I> {
        let Joint { length: n, first, last } = joined.joint;
        if last.is_some() {
            let own = self.density_of_last(joined);
            let mut sum = self.row[n].mass;
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
        let ahead = self.chain(joined, End::First, first);
        if first < n {
            return ahead + self.chain(joined, End::Second, n - first);
        }
        let mass = self.row[n - 1].mass;
        if !self.ends || mass.is_zero() {
            return ahead;
        }
        let density = self.near(joined, End::First, n - 1, self.ending);
        let own = self.own(End::First, n - 1);
        ahead + mass * self.heuristic.term(density / own)
    }

    /// The sum of the techniques that join a path before the end of a piece of `len` vertices. What it starts from is
    /// that of those that do before the last vertices of the piece, for which alone the joint matters.
    fn chain(&self, joined: &Joined<'_, I::Vertex>, end: End, len: usize) -> DensityOf<I> {
        let (start, far) = (len.saturating_sub(READS), len > READS);
        let mut sum = self.joints.sides[end as usize].sums[start];
        for k in start..len {
            let ending = |i: usize| match far {
                true => self.far_ending(),
                false => self.near(joined, End::First, i, self.ending),
            };
            sum = self.mass(joined.joint.length, end, k, ending) + sum;
            if !sum.is_zero() {
                let i = joined.joint.index(end, k);
                let other = self.near_by_step(joined, end.other(), i);
                sum = sum * self.heuristic.term(other / self.own(end, k));
            }
        }
        sum
    }

    /// The density of the first vertex of the second walk as one that is drawn for itself, where that follows from the
    /// vertices of this walk alone: as it was found when the paths of this length were summed up.
    #[inline]
    fn far_ending(&self) -> DensityOf<I> {
        self.joints.sides[End::Second as usize].ending.map_or(PathDensity::ZERO, |(_, known)| known)
    }

    /// The sums of all but the last two vertices of either walk, for paths with so many vertices.
    pub(super) fn sum_up(&mut self, n: usize) {
        for end in [End::First, End::Second] {
            let len = self.walks[end as usize].len.min(n);
            // Of the other piece only the length matters.
            let first = if end == End::First { len } else { n - len };
            let joint = Joint { length: n, first, last: None };
            let far = len.saturating_sub(READS);
            if far == 0 {
                continue; // All of it is next to the joint.
            }
            let is_ending_known = end == End::First || self.know_ending(joint);
            if !is_ending_known || !self.is_as_before(n, end) {
                self.joints.sides[end as usize].forget_sums();
            }
            for k in self.joints.sides[end as usize].sums.len()..far + 1 {
                let sum = self.sum_behind(joint, end, k - 1);
                self.joints.sides[end as usize].sums.push(sum);
            }
            self.joints.sides[end as usize].summed = n;
        }
    }

    /// Whether the sums of a side that are known are those of paths with n vertices.
    fn is_as_before(&self, n: usize, end: End) -> bool {
        let [side, other] = [end, end.other()].map(|end| &self.joints.sides[end as usize]);
        let (known, likeness) = (side.sums.len() - 1, self.connections.techniques.likeness(n));
        let alike = if end == End::First { likeness.ahead } else { likeness.behind };
        known == 0
            || side.summed + 1 == n
                && known <= alike
                && other.is_steady(n - 1, known)
                && self.ends == self.connections.end(n - 1)
    }

    /// Finds the density of the first vertex of the second walk as one that is drawn for itself, far from the joint;
    /// returns whether it was known.
    fn know_ending(&mut self, joint: Joint) -> bool {
        let n = joint.length;
        if !self.ends {
            return true;
        }
        let question = self.asked(self.ending, End::First, n - 1);
        let known = self.joints.sides[End::Second as usize].ending;
        if known.is_some_and(|(asked, _)| asked == question) {
            return true;
        }
        let density = self.density(joint, End::First, n - 1, question);
        self.joints.sides[End::Second as usize].ending = Some((question, density));
        false
    }

    /// The sum behind vertex k of a walk, far from the joint, from that before it.
    fn sum_behind(&mut self, joint: Joint, end: End, k: usize) -> DensityOf<I> {
        let before = self.joints.sides[end as usize].sums[k];
        let sum = self.mass(joint.length, end, k, |_| self.far_ending()) + before;
        if sum.is_zero() {
            return sum;
        }
        let question = self.question(joint, end.other(), joint.index(end, k));
        sum * self.heuristic.term(self.ratio(joint, end, k, question))
    }

    /// The density with which the other walk would have made vertex k of a piece, far from the joint, over that under its
    /// own walk: mostly it is the same for paths of several lengths.
    fn ratio(
        &mut self,
        joint: Joint,
        end: End,
        k: usize,
        question: Option<Question>,
    ) -> DensityOf<I> {
        let i = joint.index(end, k);
        let Some(question) = question else { return PathDensity::ZERO };
        let known = self.joints.sides[end as usize].ratios[k];
        if let Some((_, ratio)) = known.iter().flatten().find(|(asked, _)| *asked == question) {
            return *ratio;
        }
        let ratio = self.density(joint, end.other(), i, question) / self.own(end, k);
        self.joints.sides[end as usize].ratios[k] = [Some((question, ratio)), known[0]];
        ratio
    }

    /// How the walk from one end would make vertex `i` of a path, if it has a step for it.
    #[inline(always)]
    fn question(&self, joint: Joint, end: End, i: usize) -> Option<Question> {
        let step = joint.index(end, i);
        self.joints.sides[end as usize].questions.get(step).copied()
    }

    /// What stands for the technique that joins a path of n vertices behind `k` vertices of a piece: the term of its
    /// number of samples. Where it draws the last vertex for itself, that has another density than its walk's:
    /// `ending`, of the vertex with this number.
    #[inline]
    fn mass(
        &self,
        n: usize,
        end: End,
        k: usize,
        ending: impl FnOnce(usize) -> DensityOf<I>,
    ) -> DensityOf<I> {
        let first = if end == End::First { k } else { n - k };
        let mass = self.row[first].mass;
        if !(self.ends && first + 1 == n) || mass.is_zero() {
            return mass;
        }
        if end == End::First {
            return PathDensity::ZERO; // It does not continue what the second walk would have begun.
        }
        mass * self.heuristic.term(ending(n - 1) / self.own(End::Second, 0))
    }

    /// The density of vertex `i` of a path, far from the joint, under a strategy that comes from one end: it depends on
    /// nothing but vertices of one piece.
    fn density(&self, joint: Joint, end: End, i: usize, question: Question) -> DensityOf<I> {
        let at = self.position(joint, i);
        let Some(target) = self.tape.at_hand(at) else { return PathDensity::ZERO };
        let strategy = &self.strategies[(question.0 >> 1) as usize];
        let is_fixed = self.tape.is_drawn_with(at, Dirac::Position);
        let view = self.before(joint, i, end, strategy.reads().vertices);
        evaluated(strategy, view, target, is_fixed)
    }

    /// The density of vertex `i` of a path, next to the joint, under the step of a walk that would make it.
    #[inline]
    fn near_by_step(&self, joined: &Joined<'_, I::Vertex>, end: End, i: usize) -> DensityOf<I> {
        let question = self.question(joined.joint, end, i);
        question.map_or(PathDensity::ZERO, |question| self.near(joined, end, i, question.0 >> 1))
    }

    /// The density of vertex `i` of a path, next to the joint, under a strategy that comes from one end.
    #[inline(never)]
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
        let len = joined.joint.index(end, i);
        let view = PathView::of_window(&joined.window, last, backward, len);
        evaluated(&self.strategies[strategy as usize], view, target, is_fixed)
    }

    /// The density with which the last vertex of a path was drawn for itself.
    pub(super) fn density_of_last(&self, joined: &Joined<'_, I::Vertex>) -> DensityOf<I> {
        let last = joined.joint.last;
        let known = last.and_then(|at| self.tape.own(Place::new(at as usize, 1), 0));
        let i = joined.joint.length - 1;
        known.map_or_else(|| self.near(joined, End::First, i, self.ending), PathDensity::new)
    }

    /// The density of vertex `k` of a walk under its own strategy.
    #[inline(always)]
    fn own(&self, end: End, k: usize) -> DensityOf<I> {
        self.joints.sides[end as usize].stops[k].own
    }
}

/// The density of a vertex under a strategy after a path, or its probability if it can be nowhere else.
#[inline(always)]
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
