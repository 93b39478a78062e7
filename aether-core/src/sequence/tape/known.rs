//! What is known of steps and of runs of them, and how steps of two places compare.

use super::{NONE, Place, Tape};
use crate::path_density::PathDensity;
use crate::sequence::Key;
use crate::strategy::Vertex;

impl<V: Vertex> Tape<V> {
    /// What drawing a vertex told of its density, if that depends on `key`.
    #[inline]
    pub fn told(&self, vertex: u32, key: &Key) -> Option<V::Real> {
        let vertices = self.vertices.borrow();
        vertices.get(vertex as usize).filter(|kept| kept.key == *key)?.value
    }

    /// The density with which vertex `k` of a place was drawn, if drawing it told: of a step of a run that
    /// the place sees from its origin, before which there are the same vertices as then.
    #[inline]
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
        if a == b {
            return true;
        }
        let entries = self.entries.borrow();
        let same_way = a.reversed == b.reversed;
        let (a, b) = (&entries[a.at(k)], &entries[b.at(k)]);
        a.strategy == b.strategy
            && (a.backward == b.backward) == same_way
            && a.part == b.part
            && a.merged == b.merged
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
    #[inline]
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

    /// The first step, from `k` on, that two places of one length do not make alike, whatever its vertex.
    #[inline]
    pub fn next_unlike(&self, a: Place, b: Place, k: usize) -> Option<usize> {
        let entries = self.entries.borrow();
        let same_way = a.reversed == b.reversed;
        (k..a.len as usize).find(|k| {
            let (a, b) = (&entries[a.at(*k)], &entries[b.at(*k)]);
            a.strategy != b.strategy
                || (a.backward == b.backward) != same_way
                || a.part != b.part
                || a.merged != b.merged
        })
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
