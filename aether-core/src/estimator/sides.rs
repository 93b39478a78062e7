//! Shifted paths beside a walk: what is known of them, without paths being made.

use crate::combine::Heuristic;
use crate::estimator::last::{Found, Last, Ways};
use crate::estimator::steps::{Fork, MOST_WAYS, RING};
use crate::estimator::{Estimator, Factors, PathIntegrand, RealOf, Value};
use crate::real::{Real, Single};
use crate::shift::{Moved, Shift, Turn, stretch};
use crate::strategy::{Dirac, Drawn, Strategy, Vertex};
use crate::uniform::Middle;

/// What is known of a shifted path.
#[derive(Clone, Copy)]
struct Along<R, T> {
    /// The integrand, per measure of the base path, over the density of the base path.
    carried: T,
    /// The density of its own walk, per measure of the base path, over that of the base path.
    ratio: R,
    /// How many of its last vertices are those of the base path.
    kept: usize,
    /// Whether some vertex is not.
    copied: bool,
}

impl<R: Single, T> Along<R, T> {
    /// Whether so many vertices before vertex `i` are those of the base path, or all of them.
    #[inline(always)]
    fn shares(&self, vertices: usize, i: usize) -> bool {
        self.kept >= vertices.min(i)
    }

    /// Whether both paths have met, and all that follows is kept.
    #[inline(always)]
    fn has_met(&self) -> bool {
        self.copied && self.kept > 0
    }
}

/// A vertex of a shifted path.
struct Placed<V: Vertex> {
    drawn: Drawn<V>,
    /// By how much the shift stretches here.
    jacobian: V::Real,
    /// Whether it is that of the base path.
    same: bool,
}

/// A shifted path beside the walk.
pub(super) struct Side<'m, V: Vertex, M, T> {
    shift: &'m M,
    /// Its last vertices, as those of the walk are kept.
    recent: [Option<Drawn<V>>; RING],
    /// What is known of it up to the vertex before the last one of the walk; `None` if there is none.
    along: Option<Along<V::Real, T>>,
    /// The same up to the vertex before that.
    behind: Option<Along<V::Real, T>>,
    /// The sum of differences.
    pub difference: T,
}

impl<'m, V: Vertex, M, T: Value<V::Real>> Side<'m, V, M, T> {
    /// Without any vertex.
    pub fn new(shift: &'m M) -> Self {
        let (carried, ratio) = (T::one(), V::Real::ONE);
        let along = Some(Along { carried, ratio, kept: 0, copied: false });
        let difference = T::zero();
        Side { shift, recent: [const { None }; RING], along, behind: along, difference }
    }

    /// Whether it carries anything.
    #[inline(always)]
    pub fn carries(&self) -> bool {
        self.along.is_some_and(|along| !along.carried.is_zero())
    }
}

/// The vertex of the walk up to which shifted paths are to go on.
pub(super) struct Next<'l, V: Vertex, S, T> {
    /// Its number.
    pub i: usize,
    /// What is before it on the walk.
    pub fork: &'l Fork<'l, V>,
    /// The vertex.
    pub drawn: &'l Drawn<V>,
    /// The strategy that made it.
    pub own: &'l S,
    /// How it was found.
    pub found: Found<V::Real, T>,
}

/// The same, if there is one.
type Ahead<'n, 'l, V, S, T> = Option<&'n Next<'l, V, S, T>>;

/// What shifted paths beside a walk are estimated with.
pub(super) struct Sides<'e, I: PathIntegrand, F> {
    pub estimator: &'e Estimator<I, Factors<I::Value>>,
    /// Whether nothing lies between two vertices.
    pub sees: &'e F,
}

impl<I: PathIntegrand, F: Fn(&I::Vertex, &I::Vertex) -> bool> Sides<'_, I, F> {
    /// Has a shifted path go on by one vertex, from where the walk goes on in a single direction or does not.
    #[inline(always)]
    pub fn go_on<S, M>(
        &self,
        side: &mut Side<'_, I::Vertex, M, I::Value>,
        next: &Next<'_, I::Vertex, S, I::Value>,
        directed: bool,
    ) where
        S: Strategy<I::Vertex>,
        M: Shift<I::Vertex, S>,
    {
        side.behind = side.along;
        side.along = self.gone_on(side, next, directed);
    }

    /// What is known of a shifted path up to the next vertex, which is noted.
    #[inline]
    fn gone_on<S, M>(
        &self,
        side: &mut Side<'_, I::Vertex, M, I::Value>,
        next: &Next<'_, I::Vertex, S, I::Value>,
        directed: bool,
    ) -> Option<Along<RealOf<I>, I::Value>>
    where
        S: Strategy<I::Vertex>,
        M: Shift<I::Vertex, S>,
    {
        let (along, i) = (side.behind?, next.i);
        let technique = side.shift.technique(i);
        let own = technique.as_ref().unwrap_or(next.own);
        let here = Fork::new(&side.recent, i);
        let end = (next.fork, next.drawn);
        let placed = self.placed::<S, M>(side.shift, &along, end, &here, (false, directed))?;
        let Placed { drawn, jacobian, same } = placed;
        let Found { density, gain } = next.found;
        let gain = if same && along.shares(self.estimator.reads() - 1, i) {
            gain
        } else if along.carried.is_zero() {
            I::Value::zero()
        } else {
            self.estimator.extended(here.then(&drawn)).times(jacobian).over(density)
        };
        let alike = same && technique.is_none() && along.shares(own.reads().vertices, i);
        let ratio = if alike {
            along.ratio
        } else {
            along.ratio * (here.density(own, &drawn) * jacobian / density)
        };
        side.recent[i % RING] = Some(drawn);
        let kept = if same { along.kept + 1 } else { 0 };
        let copied = along.copied || !same;
        Some(Along { carried: along.carried.multiply(gain), ratio, kept, copied })
    }

    /// The vertex of a shifted path in the place of one that the base path has, if there is one.
    #[inline]
    fn placed<S, M>(
        &self,
        shift: &M,
        along: &Along<RealOf<I>, I::Value>,
        (fork, drawn): (&Fork<'_, I::Vertex>, &Drawn<I::Vertex>),
        here: &Fork<'_, I::Vertex>,
        (ends, directed): (bool, bool),
    ) -> Option<Placed<I::Vertex>>
    where
        S: Strategy<I::Vertex>,
        M: Shift<I::Vertex, S>,
    {
        let same = |visible: bool| {
            let drawn = Drawn { visible, value: None, ..*drawn };
            Placed { drawn, jacobian: RealOf::<I>::ONE, same: true }
        };
        if along.has_met() {
            return Some(same(drawn.visible));
        }
        let paths = (fork.then(drawn), here.before());
        let turn = Turn::new(shift, paths, (ends, directed));
        let there = match shift.vertex(&turn) {
            Moved::Lost => return None,
            Moved::Kept if along.kept > 0 => return Some(same(drawn.visible)),
            Moved::Kept if here.last().is_none() => return Some(same(drawn.visible)),
            Moved::Kept => {
                // Scattering finds only what it sees: no other way leads to a path that goes on.
                let seen = !ends && self.is_seen(fork, drawn) && here.sees(drawn, self.sees);
                return (!turn.is_bound() && (ends || seen)).then(|| same(seen));
            }
            Moved::Copied(there) => there,
        };
        let copy = here.draw(&there, &mut Middle)?;
        // On the way back, a ray would have to find it, and another one where the path goes on.
        let found = !ends || copy.visible;
        let is_hidden = || found && !(self.is_seen(fork, drawn) && self.is_seen(here, &copy));
        if copy.dirac != drawn.dirac || is_hidden() {
            return None;
        }
        let back = Turn::new(shift, (here.then(&copy), fork.before()), (ends, directed));
        let Moved::Copied(back) = shift.inverse().vertex(&back) else { return None };
        let density = here.own_density(&there, &copy);
        let jacobian = stretch(fork.density(&back, drawn), density)?;
        Some(Placed { drawn: Drawn { value: None, ..copy }, jacobian, same: false })
    }

    /// Whether a vertex is known to be visible from the last of those before it, or is the first, or is seen.
    fn is_seen(&self, fork: &Fork<'_, I::Vertex>, drawn: &Drawn<I::Vertex>) -> bool {
        drawn.visible || fork.last().is_none() || fork.sees(drawn, self.sees)
    }

    /// Adds the weighted difference of a shifted path to a path that ends, of which vertex `next.i` is the last but
    /// one.
    #[inline(always)]
    pub fn compare<S, M, H>(
        &self,
        side: &mut Side<'_, I::Vertex, M, I::Value>,
        last: &mut Last<'_, I::Vertex, I::Value>,
        ways: &Ways<'_, S>,
        (next, directed): (Ahead<'_, '_, I::Vertex, S, I::Value>, bool),
        heuristic: &H,
    ) where
        S: Strategy<I::Vertex>,
        M: Shift<I::Vertex, S>,
        H: Heuristic<RealOf<I>>,
    {
        // Where both paths had met before, all that is read of the end is common to both.
        if last.tail.is_zero() && side.behind.is_some_and(|along| along.has_met()) {
            return;
        }
        let other = (last.drawn.dirac == Some(Dirac::Direction)) != directed;
        match next {
            // Unlike the walk, this path leaves the vertex before in a single direction, or does not.
            Some(next) if other && side.behind.is_some_and(|along| !along.has_met()) => {
                let (place, along) = (next.i % RING, side.along);
                let vertex = side.recent[place];
                side.along = self.gone_on(side, next, !directed);
                self.compare_ends(side, last, ways, next.i + 1, heuristic);
                (side.recent[place], side.along) = (vertex, along);
            }
            next => {
                let i = next.map_or(0, |next| next.i + 1);
                self.compare_ends(side, last, ways, i, heuristic);
            }
        }
    }

    /// The same where the shifted path has gone on to the vertex before the last one, whose number is `i`.
    #[inline]
    fn compare_ends<S, M, H>(
        &self,
        side: &mut Side<'_, I::Vertex, M, I::Value>,
        last: &mut Last<'_, I::Vertex, I::Value>,
        ways: &Ways<'_, S>,
        i: usize,
        heuristic: &H,
    ) where
        S: Strategy<I::Vertex>,
        M: Shift<I::Vertex, S>,
        H: Heuristic<RealOf<I>>,
    {
        let here = Fork::new(&side.recent, i);
        let placed = side.along.and_then(|along| {
            let end = (last.fork, last.drawn);
            Some((along, self.placed::<S, M>(side.shift, &along, end, &here, (true, false))?))
        });
        let there = match &placed {
            Some((along, placed)) => self.carried_to(along, placed, last, &here, i),
            None => I::Value::zero(),
        };
        if there.is_zero() && last.alone.is_zero() {
            return;
        }
        let (mut ratios, n) = ([RealOf::<I>::ZERO; 2 * MOST_WAYS], ways.count);
        let own = last.ratios(ways);
        ratios[..n].copy_from_slice(&own[..n]);
        if let Some(walk) = ways.walk
            && walk != last.way
            && !last.is_seen(self.sees)
        {
            ratios[walk] = RealOf::<I>::ZERO;
        }
        if let Some((along, placed)) = placed {
            for (k, strategy) in ways.iter() {
                let is_walk = ways.walk == Some(k);
                let hidden = is_walk && there.is_zero() && {
                    let shared = placed.same && along.kept > 0;
                    let seen = placed.drawn.visible
                        || if shared {
                            last.is_seen(self.sees)
                        } else {
                            here.sees(&placed.drawn, self.sees)
                        };
                    !seen
                };
                if hidden {
                    continue;
                }
                let technique = if is_walk { side.shift.technique(i) } else { None };
                let strategy = technique.as_ref().unwrap_or(strategy);
                let alike = placed.same
                    && technique.is_none()
                    && along.shares(strategy.reads().vertices, i);
                let ratio = if alike {
                    own[k]
                } else {
                    here.density(strategy, &placed.drawn) / last.density
                };
                let ratio = along.ratio * placed.jacobian * ratio;
                // Zero times infinity: what cannot arise does not arise at a pole either.
                ratios[n + k] = if ratio > RealOf::<I>::ZERO { ratio } else { RealOf::<I>::ZERO };
            }
        }
        let weight = heuristic.weight(&ratios[..2 * n], last.way);
        let less = last.alone.times(-weight);
        side.difference = side.difference.plus(there.times(weight)).plus(less);
    }

    /// What the shifted path carries, as a sample of its base path.
    #[inline]
    fn carried_to(
        &self,
        along: &Along<RealOf<I>, I::Value>,
        placed: &Placed<I::Vertex>,
        last: &mut Last<'_, I::Vertex, I::Value>,
        here: &Fork<'_, I::Vertex>,
        i: usize,
    ) -> I::Value {
        if placed.same && along.shares(self.estimator.reads() - 1, i) {
            return along.carried.multiply(last.tail);
        }
        // The last edge is that of the base path, whose visibility is known.
        let shared = placed.same && along.kept > 0;
        if along.carried.is_zero() || (shared && !last.is_seen(self.sees)) {
            return I::Value::zero();
        }
        let drawn = Drawn { visible: shared || placed.drawn.visible, ..placed.drawn };
        let path = here.then(&drawn);
        let closing = self.estimator.closing(path);
        if closing.is_zero() {
            return closing;
        }
        let tail = self.estimator.extended(path).multiply(closing);
        along.carried.multiply(tail.times(placed.jacobian).over(last.density))
    }
}
