//! Joint runs: several vertices that one draw yields, and that have one density together.

use crate::real::Real;
use crate::sequence::evaluate::Densities;
use crate::sequence::tape::Unfolded;
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
        let Some(run) = self.tape.joint_run(place, i).filter(|_| step.way.part().index() == 0)
        else {
            return false;
        };
        let id = step.way.strategy();
        let strategy = self.strategies.borrow()[id as usize].clone();
        let (reads, before) = (strategy.reads(), place.range(0, i));
        let view = PathView::of_tape(&self.tape, before).limited(reads);
        let Some(drawn) = strategy.sample_joint(view, uniforms) else { return false };
        if drawn.vertices().len() != step.way.part().len() {
            return false;
        }
        self.tape.take_run(place, i, &drawn);
        if let Some(value) = drawn.value {
            count_densities(1);
            if let Some(key) = run_key(&self.tape.unfolded(), id, run, before, reads) {
                self.memo.borrow_mut().insert(key, value);
            }
        }
        true
    }
}

/// What the density of the vertices of a run depends on; `None` if that is too much to be
/// remembered.
fn run_key<V: Vertex>(
    tape: &Unfolded<'_, V>,
    strategy: u32,
    run: Place,
    before: Place,
    reads: Reads,
) -> Option<Key> {
    let (n, len) = (run.len as usize, before.len as usize);
    let mut key = [NONE; 6];
    let room = (key.len() - 1).checked_sub(n + usize::from(reads.length))?;
    if reads.vertices > room {
        return None;
    }
    key[0] = strategy * 4;
    for k in 0..n {
        key[1 + k] = tape.id(run, k);
    }
    for k in 0..reads.vertices.min(len) {
        key[1 + n + k] = tape.id(before, len - 1 - k);
    }
    if reads.length {
        key[5] = before.len;
    }
    Some(key)
}

impl<V: Vertex, S: Strategy<V>> Densities<'_, V, S> {
    /// The density of the vertices of `path` where `technique` has the joint run of step `k`, if `k` is
    /// the last step of the run, and one if not. Zero if the technique has only a piece of the run.
    pub(super) fn run_factor(&mut self, technique: Place, k: usize, path: Place) -> V::Real {
        let way = self.tape.way(technique, k);
        if self.tape.tape.joint_run(technique, k).is_none() {
            return V::Real::ZERO;
        }
        if !way.part().is_last() {
            return V::Real::ONE;
        }
        let (n, len, backward) = (path.len as usize, way.part().len(), way.is_backward());
        let (run, before) = if backward {
            (path.range(k, k + len).reverse(), path.range(k + len, n).reverse())
        } else {
            (path.range(k + 1 - len, k + 1), path.range(0, k + 1 - len))
        };
        let first = if backward { k } else { k + 1 - len };
        let atom = |k: usize| self.tape.kind(path, k, backward).is_some();
        if (first..first + len).any(atom) {
            return V::Real::ZERO;
        }
        let (tape, strategy) = (&self.tape, &self.strategies[way.strategy() as usize]);
        let key = run_key(tape, way.strategy(), run, before, strategy.reads());
        let value = || evaluate_run(tape, strategy, run, before);
        match key {
            Some(key) => self.memo.get_or_insert_with(&key, value),
            None => value(),
        }
    }
}

fn evaluate_run<V: Vertex, S: Strategy<V>>(
    tape: &Unfolded<'_, V>,
    strategy: &S,
    run: Place,
    before: Place,
) -> V::Real {
    let len = run.len as usize;
    let Some(last) = tape.vertex(run.at(len - 1)) else { return V::Real::ZERO };
    let vertex = |j: usize| tape.vertex(run.at(j.min(len - 1))).unwrap_or(last);
    let targets: [V; MOST_VERTICES] = core::array::from_fn(vertex);
    let view = PathView::of_unfolded(tape, before, strategy.reads());
    count_densities(1);
    let value = strategy.pdf_joint(view, &targets[..len]);
    if value > V::Real::ZERO { value } else { V::Real::ZERO }
}
