//! Drawing vertices, and the densities of paths under their own and other strategies.

use crate::path_density::PathDensity;
use crate::real::Real;
use crate::sequence::tape::{Entry, NOTHING};
use crate::sequence::{Arena, Key, NONE, PathView, Place};
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
        // A copy, so that nothing of the arena is borrowed while user code runs.
        let strategy = self.strategies.borrow()[id as usize].clone();
        let reads = strategy.reads();
        let before = place.range(0, i);
        let view = PathView::of_tape(&self.tape, before).limited(reads);
        let Some(drawn) = strategy.sample(view, uniforms) else { return false };
        let mut key = NOTHING;
        if drawn.value.is_some() {
            count_densities(1);
            let vertex = self.tape.vertex_count() as u32;
            key = self.key(id, drawn.dirac, before, reads, vertex).unwrap_or(NOTHING);
        }
        self.tape.take(place, i, &drawn, key);
        true
    }

    /// What the density of a vertex depends on; `None` if that is too much to be remembered.
    fn key(
        &self,
        strategy: u32,
        dirac: Option<Dirac>,
        before: Place,
        reads: Reads,
        vertex: u32,
    ) -> Option<Key> {
        if reads.vertices > REMEMBERED {
            return None;
        }
        let kind = match dirac {
            None => 0,
            Some(Dirac::Position) => 1,
            Some(Dirac::Direction) => 2,
        };
        let len = before.len as usize;
        let mut key = [strategy * 4 + kind, vertex, NONE, NONE, NONE, 0];
        for k in 0..reads.vertices.min(len) {
            key[2 + k] = self.tape.entry(before.at(len - 1 - k)).vertex;
        }
        if reads.length {
            key[5] = before.len;
        }
        Some(key)
    }

    /// The conditional density of vertex `k` of `path` under step `k` of `technique`, given the
    /// vertices of `path` that the step comes from. Of a joint run, the last step has the density of
    /// all, the others have one.
    pub(crate) fn factor(&self, technique: Place, k: usize, path: Place) -> V::Real {
        if self.tape.same_step(technique, path, k)
            && let Some(known) = self.tape.own(path, k)
        {
            return known;
        }
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
        let n = path.len as usize;
        let before = if backward { path.range(k + 1, n).reverse() } else { path.range(0, k) };
        let dirac = self.tape.kind(path, k, backward);
        let vertex = self.tape.entry(path.at(k)).vertex;
        let reads = self.strategies.borrow()[strategy as usize].reads();
        let key = self.key(strategy, dirac, before, reads, vertex);
        if let Some(key) = key {
            // Mostly it is what drawing the vertex told.
            let told = self.tape.told(vertex, &key);
            if let Some(known) = told.or_else(|| self.memo.borrow().get(&key)) {
                return known;
            }
        }
        let Some(target) = self.tape.vertex(path.at(k)) else { return V::Real::ZERO };
        let strategy = self.strategies.borrow()[strategy as usize].clone();
        let view = PathView::of_tape(&self.tape, before).asking(dirac).limited(reads);
        count_densities(1);
        let value = strategy.pdf(view, &target).of_kind(dirac);
        if let Some(key) = key {
            self.memo.borrow_mut().insert(key, value);
        }
        value
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
    fn comparable(&self, technique: Place, path: Place) -> bool {
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

    /// The densities of `path` under two techniques without the factors that they share.
    #[inline]
    fn quotient(&self, a: Place, b: Place, path: Place) -> [PathDensity<V::Real>; 2] {
        let mut densities = [PathDensity::ONE; 2];
        let mut from = 0;
        while let Some(k) = self.tape.next_unlike(a, b, from) {
            densities[0] = densities[0] * self.factor(a, k, path);
            densities[1] = densities[1] * self.factor(b, k, path);
            from = k + 1;
        }
        densities
    }

    /// How much likelier each technique makes `path` than technique `own`, which made it: calls
    /// `visit` with each other technique and the ratio of densities.
    ///
    /// Neighbouring techniques share most factors, so each is compared with the one before, going
    /// outwards from `own`, and directly with `own` where zeros or poles get in the way.
    pub(crate) fn density_ratios(
        &self,
        count: usize,
        own: usize,
        technique: impl Fn(usize) -> Place,
        mut visit: impl FnMut(usize, V::Real),
    ) {
        let path = technique(own);
        if S::VERTICES > 1 && !self.tape.is_whole(path) {
            // It is no sample of its own technique, whose density is zero.
            let others = (0..count).filter(|j| *j != own);
            return others.for_each(|j| visit(j, V::Real::INFINITY));
        }
        let start = (path, PathDensity::ONE);
        let mut compare = |(from, ratio): (Place, PathDensity<V::Real>), j| {
            let place = technique(j);
            if !self.comparable(place, path) {
                visit(j, V::Real::ZERO);
                return (from, ratio);
            }
            let [new, old] = self.quotient(place, from, path);
            if new.is_regular() && old.is_regular() {
                let ratio = ratio * (new / old);
                visit(j, ratio.value());
                return (place, ratio);
            }
            let [new, old] = self.quotient(place, path, path);
            visit(j, new.ratio(old));
            (from, ratio)
        };
        (own + 1..count).fold(start, &mut compare);
        (0..own).rev().fold(start, compare);
    }
}
