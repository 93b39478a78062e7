//! Drawing vertices, and the densities of paths under their own and other strategies.

use core::cell::{Ref, RefMut};

use crate::path_density::PathDensity;
use crate::real::Real;
use crate::sequence::tape::{Question, Unfolded, Way};
use crate::sequence::{Arena, Memo, PathView, Place};
use crate::strategy::{Dirac, Drawn, Reads, Strategy, Vertex};
use crate::uniform::UniformSource;
use crate::work::count_densities;

/// Most preceding vertices that a remembered density may depend on.
const REMEMBERED: usize = 3;

impl<V: Vertex, S: Strategy<V>> Arena<V, S> {
    /// Draws the vertex of step `i`, and with it those of its joint run; returns whether there is one.
    pub(crate) fn draw<U: UniformSource<V::Real> + ?Sized>(
        &self,
        place: Place,
        i: usize,
        uniforms: &mut U,
    ) -> bool {
        let unfolded = self.tape.unfolded();
        let way = unfolded.way(place, i);
        if S::VERTICES > 1 && way.part().is_joint() {
            drop(unfolded);
            return self.draw_run(place, i, uniforms);
        }
        // A strategy is a pure function: it adds nothing to the arena that its path lives in.
        let strategies = self.strategies.borrow();
        let strategy = &strategies[way.strategy() as usize];
        let reads = strategy.reads();
        let view = PathView::of_unfolded(&unfolded, place.range(0, i), reads);
        let Some(drawn) = strategy.sample(view, uniforms) else { return false };
        drop(unfolded);
        if drawn.value.is_some() {
            count_densities(1);
        }
        self.tape.take(place, i, &drawn, answered(strategy, way.strategy(), &drawn, i));
        true
    }

    /// What is needed to evaluate densities, as long as nothing is added to the arena.
    #[inline]
    pub(crate) fn densities(&self) -> Densities<'_, V, S> {
        Densities {
            tape: self.tape.unfolded(),
            strategies: Ref::map(self.strategies.borrow(), Vec::as_slice),
            memo: self.memo.borrow_mut(),
        }
    }

    /// The conditional density of vertex `k` of `path` under step `k` of `technique`, given the
    /// vertices of `path` that the step comes from. Of a joint run, the last step has the density of
    /// all, the others have one.
    #[inline]
    pub(crate) fn factor(&self, technique: Place, k: usize, path: Place) -> V::Real {
        self.densities().factor(technique, k, path)
    }

    /// The density of `path` under `technique`.
    pub(crate) fn density(&self, technique: Place, path: Place) -> PathDensity<V::Real> {
        self.densities().of(technique, path)
    }

    /// The density of a path under its own strategies, from what is known about the run of steps
    /// from either end.
    pub(crate) fn own_density(&self, place: Place) -> PathDensity<V::Real> {
        let n = place.len as usize;
        let mut densities = self.densities();
        let ahead = densities.tape.steps_ahead(place);
        if ahead < n && densities.tape.is_run(place.reverse(), n - ahead) {
            return densities.of_run(place.range(0, ahead))
                * densities.of_run(place.range(ahead, n).reverse());
        }
        if ahead == n { densities.of_run(place) } else { densities.of(place, place) }
    }
}

/// Conditional densities of vertices, and densities of paths: each is evaluated once.
pub(crate) struct Densities<'r, V: Vertex, S> {
    pub tape: Unfolded<'r, V>,
    pub(super) strategies: Ref<'r, [S]>,
    pub(super) memo: RefMut<'r, Memo<V::Real>>,
}

impl<V: Vertex, S: Strategy<V>> Densities<'_, V, S> {
    /// [`Arena::factor`].
    #[inline]
    pub fn factor(&mut self, technique: Place, k: usize, path: Place) -> V::Real {
        self.factor_by(self.tape.way(technique, k), technique, k, path)
    }

    /// The same of a step whose way is known.
    #[inline]
    pub fn factor_by(&mut self, way: Way, technique: Place, k: usize, path: Place) -> V::Real {
        if way == self.tape.way(path, k)
            && let Some(known) = self.tape.own(path, k)
        {
            return known;
        }
        self.other_factor(technique, way, k, path)
    }

    /// The same of a step that is not known to have made the vertex.
    pub(super) fn other_factor(
        &mut self,
        technique: Place,
        way: Way,
        k: usize,
        path: Place,
    ) -> V::Real {
        if S::VERTICES > 1 && way.part().is_joint() {
            return self.run_factor(technique, k, path);
        }
        let backward = way.is_backward();
        let factor = self.step_factor(way.strategy(), backward, k, path);
        let Some(merger) = way.merger() else { return factor };
        let merger = self.tape.tape.merger(merger);
        let other = self.step_factor(merger.strategy, !backward, k, path);
        factor * other * merger.kernel
    }

    /// The conditional density of vertex `k` of a path under a strategy that comes from one side.
    fn step_factor(&mut self, id: u32, backward: bool, k: usize, path: Place) -> V::Real {
        let strategy = &self.strategies[id as usize];
        let reads = strategy.reads();
        let tape = &self.tape;
        if reads.vertices > REMEMBERED {
            let dirac = tape.kind(path, k, backward);
            return evaluate(tape, strategy, (path, k), backward, dirac);
        }
        let before = if backward { path.len as usize - 1 - k } else { k };
        let class = length_class(strategy, reads, before);
        let (dirac, key) = tape.key((path, k), (id, backward), reads.vertices, class);
        // Mostly it is what drawing the vertex told.
        if let Some(known) = tape.told(&key, reads.vertices) {
            return known;
        }
        self.memo.get_or_insert_with(&key, || evaluate(tape, strategy, (path, k), backward, dirac))
    }

    /// Whether `technique` can produce every Dirac factor of `path`: each belongs to a vertex, and
    /// some step must come from there.
    fn covers(&self, technique: Place, path: Place) -> bool {
        let n = path.len as usize;
        let goes = |k: usize, backward: bool| self.tape.way(technique, k).goes(backward);
        (0..n).all(|i| {
            let forward = i + 1 < n && goes(i + 1, false);
            let backward = i > 0 && goes(i - 1, true);
            forward || backward || !self.tape.carries(path, i, Dirac::Direction)
        })
    }

    /// Whether `technique` might produce `path` at all. A piece of a joint run is no technique: it has
    /// a density, but only as an integral over the vertices that are missing.
    pub(super) fn comparable(&self, technique: Place, path: Place) -> bool {
        technique.len == path.len
            && (S::VERTICES == 1 || self.tape.tape.is_whole(technique))
            && (technique == path || self.tape.tape.is_undirected() || self.covers(technique, path))
    }

    /// The density of `path` under `technique`.
    fn of(&mut self, technique: Place, path: Place) -> PathDensity<V::Real> {
        if !self.comparable(technique, path) {
            return PathDensity::ZERO;
        }
        (0..path.len as usize)
            .map(|k| self.factor(technique, k, path))
            .fold(PathDensity::ONE, |product, factor| product * factor)
    }

    /// The density of a path all of whose steps are taken forwards.
    fn of_run(&mut self, place: Place) -> PathDensity<V::Real> {
        let n = place.len as usize;
        let tape = self.tape.tape;
        let known = |k: usize| self.tape.run_name(place, k).and_then(|run| tape.run_density(run));
        let found = (0..n).rev().find_map(|k| known(k).map(|density| (k + 1, density)));
        let (start, mut density) = found.unwrap_or((0, PathDensity::ONE));
        for k in start..n {
            density = density * self.factor(place, k, place);
            if let Some(run) = self.tape.run_name(place, k) {
                tape.set_run_density(run, density);
            }
        }
        density
    }
}

/// The conditional density of vertex `k` of a path under a strategy that comes from one side, as a density or a
/// probability.
fn evaluate<V: Vertex, S: Strategy<V>>(
    tape: &Unfolded<'_, V>,
    strategy: &S,
    (path, k): (Place, usize),
    backward: bool,
    dirac: Option<Dirac>,
) -> V::Real {
    let n = path.len as usize;
    let before = if backward { path.range(k + 1, n).reverse() } else { path.range(0, k) };
    let Some(target) = tape.vertex(path.at(k)) else { return V::Real::ZERO };
    let view = PathView::of_unfolded(tape, before, strategy.reads()).asking(dirac);
    count_densities(1);
    strategy.pdf(view, &target).of_kind(dirac)
}

/// The question that drawing a vertex has answered, as number `i` of its path.
#[inline(always)]
pub(super) fn answered<V: Vertex, S: Strategy<V>>(
    strategy: &S,
    id: u32,
    drawn: &Drawn<V>,
    i: usize,
) -> Question {
    let reads = strategy.reads();
    if drawn.value.is_none() || reads.vertices > REMEMBERED {
        return Question::NOTHING;
    }
    Question::new(id, drawn.dirac, length_class(strategy, reads, i))
}

/// The class of the length of a path before a vertex, as far as it matters to a strategy.
#[inline]
pub(crate) fn length_class<V: Vertex, S: Strategy<V>>(
    strategy: &S,
    reads: Reads,
    len: usize,
) -> u32 {
    if reads.length { strategy.length_class(len) } else { 0 }
}
