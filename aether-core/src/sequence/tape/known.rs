//! What is known of steps and of runs of them, and how steps of two places compare.

use super::{Entry, NONE, Place, Question, Tape, Way};
use crate::path_density::PathDensity;
use crate::sequence::Key;
use crate::strategy::{Dirac, Vertex};

impl<V: Vertex> Tape<V> {
    /// What the density of vertex `k` of a path depends on, under a strategy that comes from one side and reads
    /// so many vertices, three at most; and which kind of density it is.
    #[inline(always)]
    pub fn key(
        &self,
        (path, k): (Place, usize),
        (strategy, backward): (u32, bool),
        reads: usize,
        class: u32,
    ) -> (Option<Dirac>, Key) {
        let dirac = self.kind(path, k, backward);
        let Question { tag, class } = Question::new(strategy, dirac, class);
        let entries = self.entries.borrow();
        let mut key = [tag, entries[path.at(k)].vertex, NONE, NONE, NONE, class];
        let before = if backward { path.len as usize - 1 - k } else { k };
        for (j, part) in key[2..5].iter_mut().enumerate().take(reads.min(before)) {
            *part = entries[path.at(if backward { k + 1 + j } else { k - 1 - j })].vertex;
        }
        (dirac, key)
    }

    /// What drawing a vertex told of its density, if that depends on `key`, in which there is room for so many
    /// vertices that are read.
    #[inline]
    pub fn told(&self, key: &Key, reads: usize) -> Option<V::Real> {
        let vertices = self.vertices.borrow();
        let kept = vertices.get(key[1] as usize)?;
        if kept.question != (Question { tag: key[0], class: key[5] }) {
            return None;
        }
        let entries = self.entries.borrow();
        let before = |j: usize| {
            let is_there = j < kept.before as usize;
            if is_there { entries[kept.at as usize - 1 - j].vertex } else { NONE }
        };
        if (0..reads).all(|j| key[2 + j] == before(j)) { kept.value } else { None }
    }

    /// The density with which vertex `k` of a place was drawn, if drawing it told: of a step of a run that
    /// the place sees from its origin, before which there are the same vertices as then.
    #[inline(always)]
    pub fn own(&self, place: Place, k: usize) -> Option<V::Real> {
        let entries = self.entries.borrow();
        let entry = &entries[place.at(k)];
        let n = place.len as usize;
        let seen = if entry.backward == place.reversed { k + 1 } else { n - k };
        if entry.run as usize != seen || entry.merged != NONE {
            return None;
        }
        self.vertices.borrow().get(entry.vertex as usize)?.value
    }

    /// Whether step `k` of two places goes the same way by the same strategy.
    #[inline]
    pub fn same_step(&self, a: Place, b: Place, k: usize) -> bool {
        let entries = self.entries.borrow();
        a == b || alike(&entries[a.at(k)], &entries[b.at(k)], a.reversed != b.reversed)
    }

    /// The ways in which two places make vertex `k`.
    #[inline(always)]
    pub fn ways(&self, [a, b]: [Place; 2], k: usize) -> [Way; 2] {
        let entries = self.entries.borrow();
        [a, b].map(|place| entries[place.at(k)].way(place.reversed))
    }

    /// The name of the run that ends at step `k`, if it begins where the path does and a draw ends there.
    #[inline]
    pub fn run_name(&self, place: Place, k: usize) -> Option<u32> {
        let entry = &self.entries.borrow()[place.at(k)];
        let named =
            entry.backward == place.reversed && entry.run as usize == k + 1 && entry.part.is_last();
        named.then_some(entry.vertex)
    }

    /// Of a path that is one run, the names of the run without its last draw and of all of it, and the density
    /// of the last vertex, if drawing it told.
    #[inline(always)]
    pub fn last_of_run(&self, place: Place) -> Option<(u32, u32, V::Real)> {
        let before = (place.len as usize).checked_sub(2)?;
        let entries = self.entries.borrow();
        let last = &entries[place.at(before + 1)];
        if last.backward != place.reversed || last.run != place.len || last.part.is_joint() {
            return None;
        }
        let value = self.vertices.borrow().get(last.vertex as usize)?.value?;
        Some((entries[place.at(before)].vertex, last.vertex, value))
    }

    /// Whether no step of the tape leads in a single direction.
    #[inline]
    pub fn is_undirected(&self) -> bool {
        !self.directed.get()
    }

    /// The range from the first to the last step that two places of one length do not make alike,
    /// whatever the vertices.
    pub fn unlike(&self, a: Place, b: Place) -> (u32, u32) {
        let (n, turned) = (a.len as usize, a.reversed != b.reversed);
        if a == b {
            return (0, 0);
        }
        let entries = self.entries.borrow();
        let steps = |k: usize| (&entries[a.at(k)], &entries[b.at(k)]);
        let unlike = |k: &usize| {
            let (a, b) = steps(*k);
            !alike(a, b, turned)
        };
        let Some(last) = (0..n).rfind(unlike) else { return (0, 0) };
        let mut first = last;
        for k in (0..last).rev() {
            let (step, other) = steps(k);
            if !alike(step, other, turned) {
                first = k;
            } else if step.vertex == other.vertex
                && step.run as usize == k + 1
                && other.run as usize == k + 1
                && step.backward == a.reversed
            {
                // Both have all steps up to here from the same run.
                break;
            }
        }
        (first as u32, last as u32 + 1)
    }

    /// The density of a run, by its name.
    pub fn run_density(&self, name: u32) -> Option<PathDensity<V::Real>> {
        self.runs.borrow().get(name as usize).copied().flatten()
    }

    pub fn set_run_density(&self, name: u32, density: PathDensity<V::Real>) {
        let runs = &mut self.runs.borrow_mut();
        if runs.len() <= name as usize {
            runs.resize(name as usize + 1, None);
        }
        runs[name as usize] = Some(density);
    }
}

/// Whether two steps go the same way by the same strategy, if one of them is read in the direction opposite to
/// that of the other where they are `turned`.
#[inline]
fn alike(a: &Entry, b: &Entry, turned: bool) -> bool {
    a.way(false) == b.way(turned)
}
