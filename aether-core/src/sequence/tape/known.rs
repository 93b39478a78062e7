//! What is known of steps and of runs of them, and how steps of two places compare.

use super::{Entry, NONE, Place, Question, Tape};
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
        let (n, entries) = (a.len as usize, self.entries.borrow());
        if n == 0 || a == b {
            return (0, 0);
        }
        let steps = |place: Place| {
            let (first, last) = (place.at(0), place.at(n - 1));
            &entries[first.min(last)..first.max(last) + 1]
        };
        let turned = a.reversed != b.reversed;
        let (steps, others) = (steps(a), steps(b));
        let unlike = |k: &usize| {
            let other = if turned { n - 1 - k } else { *k };
            !alike(&steps[*k], &others[other], turned)
        };
        // Counted along the tape, which `a` may be read against.
        let Some(first) = (0..n).find(unlike) else { return (0, 0) };
        let end = (first..n).rfind(unlike).unwrap_or(first) + 1;
        let (first, end) = if a.reversed { (n - end, n - first) } else { (first, end) };
        (first as u32, end as u32)
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
    a.strategy == b.strategy
        && (a.backward != b.backward) == turned
        && a.part == b.part
        && a.merged == b.merged
}
