//! Joint runs: several vertices that one draw yields, and that have one density together.

use crate::real::Real;
use crate::sequence::{Arena, Key, NONE, PathView, Place};
use crate::strategy::{MOST_VERTICES, Reads, Strategy, Vertex};
use crate::uniform::UniformSource;
use crate::work::count_densities;

impl<V: Vertex, S: Strategy<V>> Arena<V, S> {
    /// Draws the joint run that begins with step `i`; returns whether there is one.
    pub(super) fn draw_run<U: UniformSource<V::Real> + ?Sized>(
        &self,
        place: Place,
        i: usize,
        uniforms: &mut U,
    ) -> bool {
        let step = self.tape.step(place, i);
        let Some(run) = self.tape.joint_run(place, i).filter(|_| step.part.index() == 0) else {
            return false;
        };
        let strategy = self.strategies.borrow()[step.strategy as usize].clone();
        let (reads, before) = (strategy.reads(), place.range(0, i));
        let view = PathView::of_tape(&self.tape, before).limited(reads);
        let Some(drawn) = strategy.sample_joint(view, uniforms) else { return false };
        if drawn.vertices().len() != step.part.len() {
            return false;
        }
        self.tape.take_run(place, i, &drawn);
        if let Some(value) = drawn.value {
            count_densities(1);
            if let Some(key) = self.run_key(step.strategy, run, before, reads) {
                self.memo.borrow_mut().insert(key, value);
            }
        }
        true
    }

    /// What the density of the vertices of a run depends on; `None` if that is too much to be
    /// remembered.
    fn run_key(&self, strategy: u32, run: Place, before: Place, reads: Reads) -> Option<Key> {
        let (n, len) = (run.len as usize, before.len as usize);
        let mut key = [NONE; 6];
        let room = key.len() - 1 - n - usize::from(reads.length);
        if reads.vertices > room {
            return None;
        }
        key[0] = strategy * 4;
        for k in 0..n {
            key[1 + k] = self.tape.entry(run.at(k)).vertex;
        }
        for k in 0..reads.vertices.min(len) {
            key[1 + n + k] = self.tape.entry(before.at(len - 1 - k)).vertex;
        }
        if reads.length {
            key[5] = before.len;
        }
        Some(key)
    }

    /// The density of the vertices of `path` where `technique` has the joint run of step `k`, if `k` is
    /// the last step of the run, and one if not. Zero if the technique has only a piece of the run.
    pub(super) fn run_factor(&self, technique: Place, k: usize, path: Place) -> V::Real {
        let step = self.tape.step(technique, k);
        if self.tape.joint_run(technique, k).is_none() {
            return V::Real::ZERO;
        }
        if !step.part.is_last() {
            return V::Real::ONE;
        }
        let (n, len) = (path.len as usize, step.part.len());
        let (run, before) = if step.backward {
            (path.range(k, k + len).reverse(), path.range(k + len, n).reverse())
        } else {
            (path.range(k + 1 - len, k + 1), path.range(0, k + 1 - len))
        };
        let first = if step.backward { k } else { k + 1 - len };
        let atom = |k: usize| self.tape.kind(path, k, step.backward).is_some();
        if (first..first + len).any(atom) {
            return V::Real::ZERO;
        }
        let reads = self.strategies.borrow()[step.strategy as usize].reads();
        let key = self.run_key(step.strategy, run, before, reads);
        if let Some(known) = key.and_then(|key| self.memo.borrow().get(&key)) {
            return known;
        }
        let value = self.evaluate_run(step.strategy, run, before, reads);
        if let Some(key) = key {
            self.memo.borrow_mut().insert(key, value);
        }
        value
    }

    fn evaluate_run(&self, strategy: u32, run: Place, before: Place, reads: Reads) -> V::Real {
        let len = run.len as usize;
        let Some(last) = self.tape.vertex(run.at(len - 1)) else { return V::Real::ZERO };
        let vertex = |j: usize| self.tape.vertex(run.at(j.min(len - 1))).unwrap_or(last);
        let targets: [V; MOST_VERTICES] = core::array::from_fn(vertex);
        let strategy = self.strategies.borrow()[strategy as usize].clone();
        let view = PathView::of_tape(&self.tape, before).limited(reads);
        count_densities(1);
        let value = strategy.pdf_joint(view, &targets[..len]);
        if value > V::Real::ZERO { value } else { V::Real::ZERO }
    }
}
