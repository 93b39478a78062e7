//! Drawing vertices, and the densities of paths under their own and other strategies.

use crate::path_density::PathDensity;
use crate::real::Real;
use crate::sequence::tape::{Entry, Question};
use crate::sequence::{Arena, NONE, PathView, Place};
use crate::strategy::{Dirac, Reads, Strategy, Vertex};
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
        let Entry { strategy: id, part, .. } = self.tape.entry(place.at(i));
        if S::VERTICES > 1 && part.is_joint() {
            return self.draw_run(place, i, uniforms);
        }
        // A strategy is a pure function: it adds nothing to the arena that its path lives in.
        let strategies = self.strategies.borrow();
        let strategy = &strategies[id as usize];
        let reads = strategy.reads();
        let unfolded = self.tape.unfolded();
        let view = PathView::of_unfolded(&unfolded, place.range(0, i)).limited(reads);
        let Some(drawn) = strategy.sample(view, uniforms) else { return false };
        drop(unfolded);
        let mut question = Question::NOTHING;
        if drawn.value.is_some() {
            count_densities(1);
            if reads.vertices <= REMEMBERED {
                question = Question::new(id, drawn.dirac, length_class(strategy, reads, i));
            }
        }
        self.tape.take(place, i, &drawn, question);
        true
    }

    /// The conditional density of vertex `k` of `path` under step `k` of `technique`, given the
    /// vertices of `path` that the step comes from. Of a joint run, the last step has the density of
    /// all, the others have one.
    #[inline]
    pub(crate) fn factor(&self, technique: Place, k: usize, path: Place) -> V::Real {
        if self.tape.same_step(technique, path, k)
            && let Some(known) = self.tape.own(path, k)
        {
            return known;
        }
        self.other_factor(technique, k, path)
    }

    /// The same of a step that is not known to have made the vertex.
    fn other_factor(&self, technique: Place, k: usize, path: Place) -> V::Real {
        let step = self.tape.step(technique, k);
        if S::VERTICES > 1 && step.part.is_joint() {
            return self.run_factor(technique, k, path);
        }
        let factor = self.step_factor(step.strategy, step.backward, k, path);
        if step.merged == NONE {
            return factor;
        }
        let merger = self.tape.merger(step.merged);
        let other = self.step_factor(merger.strategy, !step.backward, k, path);
        factor * other * merger.kernel
    }

    /// The conditional density of vertex `k` of a path under a strategy that comes from one side.
    fn step_factor(&self, strategy: u32, backward: bool, k: usize, path: Place) -> V::Real {
        let before = if backward { path.len as usize - 1 - k } else { k };
        let (reads, class) = {
            let strategy = &self.strategies.borrow()[strategy as usize];
            let reads = strategy.reads();
            (reads, length_class(strategy, reads, before))
        };
        if reads.vertices > REMEMBERED {
            let dirac = self.tape.kind(path, k, backward);
            return self.evaluate((path, k), (strategy, backward), dirac);
        }
        let step = (strategy, backward);
        let (dirac, key) = self.tape.key((path, k), step, reads.vertices, class);
        // Mostly it is what drawing the vertex told.
        let told = self.tape.told(&key, reads.vertices);
        if let Some(known) = told.or_else(|| self.memo.borrow().get(&key)) {
            return known;
        }
        let value = self.evaluate((path, k), step, dirac);
        self.memo.borrow_mut().insert(key, value);
        value
    }

    /// The same, not remembered, as a density or a probability.
    fn evaluate(
        &self,
        (path, k): (Place, usize),
        (strategy, backward): (u32, bool),
        dirac: Option<Dirac>,
    ) -> V::Real {
        let n = path.len as usize;
        let before = if backward { path.range(k + 1, n).reverse() } else { path.range(0, k) };
        let tape = self.tape.unfolded();
        let Some(target) = tape.vertex(path.at(k)) else { return V::Real::ZERO };
        let strategies = self.strategies.borrow();
        let strategy = &strategies[strategy as usize];
        let view = PathView::of_unfolded(&tape, before).asking(dirac).limited(strategy.reads());
        count_densities(1);
        strategy.pdf(view, &target).of_kind(dirac)
    }

    /// Whether `technique` can produce every Dirac factor of `path`: each belongs to a vertex, and
    /// some step must come from there.
    fn covers(&self, technique: Place, path: Place) -> bool {
        let n = path.len as usize;
        (0..n).all(|i| {
            let forward = i + 1 < n && self.tape.step(technique, i + 1).goes(false);
            let backward = i > 0 && self.tape.step(technique, i - 1).goes(true);
            forward || backward || !self.tape.carries(path, i, Dirac::Direction)
        })
    }

    /// Whether `technique` might produce `path` at all. A piece of a joint run is no technique: it has
    /// a density, but only as an integral over the vertices that are missing.
    pub(super) fn comparable(&self, technique: Place, path: Place) -> bool {
        technique.len == path.len
            && (S::VERTICES == 1 || self.tape.is_whole(technique))
            && (technique == path || self.tape.is_undirected() || self.covers(technique, path))
    }

    /// The density of `path` under `technique`.
    pub(crate) fn density(&self, technique: Place, path: Place) -> PathDensity<V::Real> {
        if !self.comparable(technique, path) {
            return PathDensity::ZERO;
        }
        (0..path.len as usize)
            .map(|k| self.factor(technique, k, path))
            .fold(PathDensity::ONE, |product, factor| product * factor)
    }

    /// The density of a path under its own strategies, from what is known about the run of steps
    /// from either end.
    pub(crate) fn own_density(&self, place: Place) -> PathDensity<V::Real> {
        let n = place.len as usize;
        let ahead = self.steps_ahead(place);
        if ahead < n && self.is_run(place.reverse(), n - ahead) {
            return self.run_density(place.range(0, ahead))
                * self.run_density(place.range(ahead, n).reverse());
        }
        if ahead == n { self.run_density(place) } else { self.density(place, place) }
    }

    /// How many steps at the beginning of a path are taken forwards.
    pub(crate) fn steps_ahead(&self, place: Place) -> usize {
        let n = place.len as usize;
        if self.is_run(place, n) {
            return n;
        }
        (0..n).position(|k| self.tape.step(place, k).backward).unwrap_or(n)
    }

    /// Whether the first `len` steps are known to be an unbroken run.
    #[inline]
    fn is_run(&self, place: Place, len: usize) -> bool {
        len == 0 || {
            let last = self.tape.step(place, len - 1);
            !last.backward && last.run as usize == len
        }
    }

    /// The density of a path all of whose steps are taken forwards.
    fn run_density(&self, place: Place) -> PathDensity<V::Real> {
        let n = place.len as usize;
        let known =
            |k: usize| self.tape.run_name(place, k).and_then(|run| self.tape.run_density(run));
        let found = (0..n).rev().find_map(|k| known(k).map(|density| (k + 1, density)));
        let (start, mut density) = found.unwrap_or((0, PathDensity::ONE));
        for k in start..n {
            density = density * self.factor(place, k, place);
            if let Some(run) = self.tape.run_name(place, k) {
                self.tape.set_run_density(run, density);
            }
        }
        density
    }
}

/// The class of the length of a path before a vertex, as far as it matters to a strategy.
#[inline]
fn length_class<V: Vertex, S: Strategy<V>>(strategy: &S, reads: Reads, len: usize) -> u32 {
    if reads.length { strategy.length_class(len) } else { 0 }
}
