//! The weights of paths of two pieces: sums over the techniques that would have joined them elsewhere.

use super::known::{Question, Tail};
use super::{BEHIND, DensityOf, End, Joined, Joint, Pieces, READS, window};
use crate::combine::Separable;
use crate::estimator::{PathIntegrand, RealOf};
use crate::path_density::PathDensity;
use crate::real::{Real, Scalar};
use crate::sequence::PathView;
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
        let Joint { length: n, first } = joined.joint;
        if joined.last.is_some() {
            let own = self.density_of_last(joined);
            let mut sum = self.row[n].mass;
            if !sum.is_zero() {
                let density = self.last_by_step::<false>(joined);
                sum = sum * self.heuristic.term(PathDensity::quotient(density, own));
            }
            let further = self.ahead(joined);
            if further.is_zero() {
                return sum;
            }
            let density = self.last_by_step::<true>(joined);
            return sum + further * self.heuristic.term(PathDensity::quotient(density, own));
        }
        let ahead = self.ahead(joined);
        if first < n {
            return ahead + self.behind(joined);
        }
        let mass = self.row[n - 1].mass;
        if !self.ends || mass.is_zero() {
            return ahead;
        }
        let density = self.near::<false>(joined, joined.place(n - 1), self.ending);
        let own = self.own(End::First, n - 1);
        ahead + mass * self.heuristic.term(PathDensity::quotient(density, own))
    }

    /// The sum of the techniques that join a path before the end of its first piece.
    #[inline(never)]
    fn ahead(&self, joined: &Joined<'_, I::Vertex>) -> DensityOf<I> {
        self.chain(joined, End::First, joined.joint.first)
    }

    /// The sum of the techniques that join a path behind the beginning of its second piece.
    #[inline(never)]
    fn behind(&self, joined: &Joined<'_, I::Vertex>) -> DensityOf<I> {
        self.chain(joined, End::Second, joined.joint.length - joined.joint.first)
    }

    /// The sum of the techniques that join a path before the end of a piece of `len` vertices. What it starts from is
    /// that of those that do before the last vertices of the piece, for which alone the joint matters.
    #[inline(always)]
    fn chain(&self, joined: &Joined<'_, I::Vertex>, end: End, len: usize) -> DensityOf<I> {
        const { assert!(READS == 2, "a link for each vertex that a strategy reads") };
        let mut sum = self.joints.sides[end as usize].sums[len.saturating_sub(READS)];
        if len > 1 {
            sum = self.link(joined, end, len, 1, sum);
        }
        if len > 0 {
            sum = self.link(joined, end, len, 0, sum);
        }
        sum
    }

    /// The sum behind a vertex of a piece of `len` vertices, so many before its last one, from that before it. In line, as
    /// where all of it lies in the window is known with the end and the distance.
    #[inline(always)]
    fn link(
        &self,
        joined: &Joined<'_, I::Vertex>,
        end: End,
        len: usize,
        distance: usize,
        before: DensityOf<I>,
    ) -> DensityOf<I> {
        let (n, k) = (joined.joint.length, len - 1 - distance);
        let mut mass = self.mass(n, end, k);
        if self.is_ending(n, end, k) {
            let density = match len > self.ending_reads {
                true => self.far_ending(),
                false => {
                    PathDensity::new(self.near::<false>(joined, joined.place(n - 1), self.ending))
                }
            };
            mass = mass * self.heuristic.term(density / self.own(End::Second, 0));
        }
        if mass.is_zero() && before.is_zero() {
            return PathDensity::ZERO;
        }
        let place = if end == End::First { BEHIND - 1 - distance } else { BEHIND + distance };
        let Some(question) = self.question(n, end.other(), k) else { return PathDensity::ZERO };
        let other = self.at_place(joined, end.other(), place, question.0 >> 1);
        self.linked([mass, before], (other, self.own(end, k)))
    }

    /// A sum of terms times that of a ratio of densities.
    #[inline(always)]
    fn linked(
        &self,
        [mass, before]: [DensityOf<I>; 2],
        (other, own): (RealOf<I>, DensityOf<I>),
    ) -> DensityOf<I> {
        let term = |ratio| self.heuristic.plain_term(ratio);
        let plain = PathDensity::plain_sum_times([mass, before], (other, own), term);
        plain.unwrap_or_else(|| robust_sum_times(self.heuristic, [mass, before], (other, own)))
    }

    /// The density of the first vertex of the second walk as one that is drawn for itself, where that follows from the
    /// vertices of this walk alone: as it was found when the paths of this length were summed up.
    #[inline]
    fn far_ending(&self) -> DensityOf<I> {
        self.joints.sides[End::Second as usize].ending.map_or(PathDensity::ZERO, |(_, known)| known)
    }

    /// The sums of all but the last two vertices of either walk, for paths with so many vertices.
    pub(super) fn sum_up(&mut self, n: usize) {
        self.sum_up_from(n, End::First);
        self.sum_up_from(n, End::Second);
    }

    /// The same of one walk. In line, as much is known with the end.
    #[inline(always)]
    fn sum_up_from(&mut self, n: usize, end: End) {
        let len = self.walks[end as usize].len.min(n);
        let is_ending_known = end == End::First || len <= self.ending_reads || self.know_ending(n);
        let far = len.saturating_sub(READS);
        if far == 0 {
            return; // All of it is next to the joint.
        }
        let known = self.joints.sides[end as usize].sums.len() - 1;
        if known > 0 && !(is_ending_known && self.is_as_before(n, end, known)) {
            self.joints.sides[end as usize].forget_sums();
        }
        let side = &self.joints.sides[end as usize];
        let (first, mut sum) = (side.sums.len() - 1, side.sums[side.sums.len() - 1]);
        for k in first..far {
            sum = self.sum_behind(n, end, k, sum);
            self.joints.sides[end as usize].sums.push(sum);
        }
        self.joints.sides[end as usize].summed = n;
    }

    /// Whether the sums of a side of which so many are known are those of paths with n vertices.
    #[inline(always)]
    fn is_as_before(&self, n: usize, end: End, known: usize) -> bool {
        let [side, other] = [end, end.other()].map(|end| &self.joints.sides[end as usize]);
        let likeness = self.connections.techniques.likeness(n);
        let alike = if end == End::First { likeness.ahead } else { likeness.behind };
        side.summed + 1 == n
            && known <= alike
            && other.is_steady(n - 1, known)
            && self.ends == self.connections.end(n - 1)
    }

    /// Finds the density of the first vertex of the second walk as one that is drawn for itself, far from the joint;
    /// returns whether it was known.
    fn know_ending(&mut self, n: usize) -> bool {
        if !self.ends {
            return true;
        }
        let question = self.asked(self.ending, End::First, n - 1);
        let known = self.joints.sides[End::Second as usize].ending;
        if known.is_some_and(|(asked, _)| asked == question) {
            return true;
        }
        let next = READS.min(self.walks[End::Second as usize].len.min(n) - 1);
        let density = PathDensity::new(self.density(n, End::Second, (0, next), question));
        self.joints.sides[End::Second as usize].ending = Some((question, density));
        false
    }

    /// The sum behind vertex k of a walk, far from the joint, from that before it.
    #[inline(always)]
    fn sum_behind(&mut self, n: usize, end: End, k: usize, before: DensityOf<I>) -> DensityOf<I> {
        let mut mass = self.mass(n, end, k);
        if self.is_ending(n, end, k) {
            mass = mass * self.heuristic.term(self.far_ending() / self.own(End::Second, 0));
        }
        let sum = mass + before;
        if sum.is_zero() {
            return sum;
        }
        sum * self.heuristic.term(self.ratio(n, end, k))
    }

    /// The density with which the other walk would have made vertex k of a piece, far from the joint, over that under its
    /// own walk: mostly it is the same for paths of several lengths.
    #[inline(always)]
    fn ratio(&mut self, n: usize, end: End, k: usize) -> DensityOf<I> {
        let Some(question) = self.question(n, end.other(), k) else { return PathDensity::ZERO };
        match &self.joints.sides[end as usize].pieces[k + 1].ratios {
            [Some((asked, ratio)), _] if *asked == question => *ratio,
            [_, Some((asked, ratio))] if *asked == question => *ratio,
            _ if end == End::First => self.new_ratio::<false>(n, k, question),
            _ => self.new_ratio::<true>(n, k, question),
        }
    }

    /// The same, not known: a function for either walk, in which all that follows from that is known.
    #[inline(never)]
    fn new_ratio<const IS_SECOND: bool>(
        &mut self,
        n: usize,
        k: usize,
        question: Question,
    ) -> DensityOf<I> {
        let end = if IS_SECOND { End::Second } else { End::First };
        let density = self.density(n, end, (k, READS), question);
        let piece = &mut self.joints.sides[end as usize].pieces[k + 1];
        let ratio = PathDensity::quotient(density, piece.own);
        piece.ratios = [Some((question, ratio)), piece.ratios[0]];
        ratio
    }

    /// How the walk from one end would make vertex k of the other walk in a path of n vertices, if it has a step for it.
    #[inline(always)]
    fn question(&self, n: usize, end: End, k: usize) -> Option<Question> {
        self.joints.sides[end as usize].steps.get(n - 1 - k).map(|(question, _)| *question)
    }

    /// What stands for the technique that joins a path of n vertices behind `k` vertices of a piece: the term of its
    /// number of samples. Nothing of one that draws the last vertex for itself behind all of the first piece: it does not
    /// continue what the second walk would have begun.
    #[inline(always)]
    fn mass(&self, n: usize, end: End, k: usize) -> DensityOf<I> {
        match end {
            End::First if self.ends && k + 1 == n => PathDensity::ZERO,
            End::First => self.row[k].mass,
            End::Second => self.row[n - k].mass,
        }
    }

    /// Whether the technique that joins a path of n vertices behind `k` vertices of the second piece draws the last vertex
    /// for itself, which has another density then than that of its walk.
    #[inline(always)]
    fn is_ending(&self, n: usize, end: End, k: usize) -> bool {
        end == End::Second && k == 1 && self.ends && !self.row[n - 1].mass.is_zero()
    }

    /// The density of vertex `k` of a walk in a path of n vertices, far from the joint, under a strategy of the other walk: it
    /// depends on nothing but the next vertices of this walk, so many, behind which the path may be joined as well.
    #[inline(always)]
    fn density(
        &self,
        n: usize,
        end: End,
        (k, next): (usize, usize),
        question: Question,
    ) -> RealOf<I> {
        let count = k + 1 + next;
        let tail = &self.joints.sides[end as usize].pieces[count].tail;
        let (first, tails, place) = match end {
            End::First => (count, [tail, &Tail::EMPTY], BEHIND - 1 - next),
            End::Second => (n - count, [&Tail::EMPTY, tail], BEHIND + next),
        };
        let joint = Joint { length: n, first };
        let joined = Joined { joint, last: None, window: window(self.tape, tails) };
        self.at_place(&joined, end.other(), place, question.0 >> 1)
    }

    /// The density of a last vertex that was drawn for itself under the step of a walk that would make it.
    #[inline(always)]
    fn last_by_step<const IS_SECOND: bool>(&self, joined: &Joined<'_, I::Vertex>) -> RealOf<I> {
        let (n, end) = (joined.joint.length, if IS_SECOND { End::Second } else { End::First });
        let k = joined.joint.index(end.other(), n - 1);
        let question = self.question(n, end, k);
        question.map_or(RealOf::<I>::ZERO, |question| {
            self.near::<IS_SECOND>(joined, BEHIND, question.0 >> 1)
        })
    }

    /// The density of the vertex at a place of the window under a strategy that comes from one end: a function for either.
    #[inline(never)]
    fn near<const IS_SECOND: bool>(
        &self,
        joined: &Joined<'_, I::Vertex>,
        place: usize,
        strategy: u32,
    ) -> RealOf<I> {
        let end = if IS_SECOND { End::Second } else { End::First };
        self.at_place(joined, end, place, strategy)
    }

    /// The same in line.
    #[inline(always)]
    fn at_place(
        &self,
        joined: &Joined<'_, I::Vertex>,
        end: End,
        place: usize,
        strategy: u32,
    ) -> RealOf<I> {
        let Some(target) = joined.window.vertices[place] else { return RealOf::<I>::ZERO };
        let is_fixed = joined.window.fixed >> place & 1 == 1;
        let backward = end == End::Second;
        let last = if backward { place + 1 } else { place - 1 };
        let len = joined.joint.index(end, joined.joint.first + place - BEHIND);
        let strategy = &self.strategies[strategy as usize];
        let view = PathView::of_window(&joined.window, last, backward, len);
        evaluated(strategy, view, target, is_fixed)
    }

    /// The density with which the last vertex of a path was drawn for itself.
    pub(super) fn density_of_last(&self, joined: &Joined<'_, I::Vertex>) -> DensityOf<I> {
        let known = joined.last.and_then(|last| last.value);
        PathDensity::new(known.unwrap_or_else(|| self.near::<false>(joined, BEHIND, self.ending)))
    }

    /// The density of vertex `k` of a walk under its own strategy.
    #[inline(always)]
    fn own(&self, end: End, k: usize) -> DensityOf<I> {
        self.joints.sides[end as usize].pieces[k + 1].own
    }
}

/// The sum of terms times that of a ratio of densities where something has left the range of plain numbers, also a density that is
/// zero.
#[cold]
#[inline(never)]
fn robust_sum_times<R: Scalar>(
    heuristic: &impl Separable<R>,
    [mass, before]: [PathDensity<R>; 2],
    (other, own): (R, PathDensity<R>),
) -> PathDensity<R> {
    (mass + before) * heuristic.term(PathDensity::quotient(other, own))
}

/// The density of a vertex under a strategy after a path, or its probability if it can be nowhere else.
#[inline(always)]
fn evaluated<V: Vertex, S: Strategy<V>>(
    strategy: &S,
    path: PathView<'_, V>,
    target: &V,
    is_fixed: bool,
) -> V::Real {
    let dirac = is_fixed.then_some(Dirac::Position);
    count_densities(1);
    strategy.pdf_limited(path.asking(dirac), target).of_kind(dirac)
}
