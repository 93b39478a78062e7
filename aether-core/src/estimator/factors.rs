//! What an estimator of paths remembers: factors of the integrand, and what runs of vertices carry.

use crate::estimator::joints::Carried;
use crate::estimator::{Estimator, PathIntegrand};
use crate::sequence::{KEY, Key, Memo, NONE, PathView, Place, Unfolded};
use crate::strategy::Reads;

/// What an [`Estimator`] of paths remembers about the contents of one arena.
#[derive(Clone, Debug)]
pub struct Factors<T> {
    contents: Option<(u64, u64)>,
    /// f / p of the steps up to the end of a run, by its name.
    runs: Vec<Option<T>>,
    /// The same of runs that are the last part of a path, with the factors of the integrand that depend on
    /// nothing before them.
    pub(super) endings: Vec<Option<T>>,
    /// Factors of the integrand, by the vertices that they depend on.
    memo: Memo<T>,
    /// What pieces of two walks carry.
    pub(super) carried: [Carried<T>; 2],
}

impl<T: Copy> Factors<T> {
    /// Nothing yet.
    pub(super) fn new() -> Self {
        Factors {
            contents: None,
            runs: Vec::new(),
            endings: Vec::new(),
            memo: Memo::new(),
            carried: Default::default(),
        }
    }

    /// What is remembered is of no contents any more.
    pub(super) fn forget(&mut self) {
        self.contents = None;
    }
}

impl<I: PathIntegrand> Estimator<I, Factors<I::Value>> {
    /// How many vertices a factor depends on.
    #[inline(always)]
    pub(super) fn reads(&self) -> usize {
        self.integrand.reads().max(1)
    }

    /// What the integrand is shown of a path.
    #[inline(always)]
    pub(super) fn shown(&self) -> Reads {
        Reads { vertices: self.reads(), length: false }
    }

    /// Forgets everything if it is about other contents.
    pub(super) fn remember(&self, contents: (u64, u64)) {
        let mut factors = self.factors.borrow_mut();
        if factors.contents != Some(contents) {
            factors.contents = Some(contents);
            factors.runs.clear();
            factors.endings.clear();
            factors.memo.clear();
            factors.carried.iter_mut().for_each(Carried::clear);
        }
    }

    /// What a run carries, by its name.
    pub(super) fn run(&self, name: u32) -> Option<I::Value> {
        known_at(&self.factors.borrow().runs, name)
    }

    /// Remembers it.
    pub(super) fn set_run(&self, name: u32, value: I::Value) {
        remember_at(&mut self.factors.borrow_mut().runs, name, value);
    }

    /// The factor that vertex `k` of a path brings.
    pub(super) fn factor(&self, tape: &Unfolded<'_, I::Vertex>, path: Place, k: usize) -> I::Value {
        let reads = self.reads();
        if reads > KEY {
            return self.new_factor(tape, path, k);
        }
        let mut key: Key = [NONE; KEY];
        for (back, part) in key.iter_mut().enumerate().take(reads.min(k + 1)) {
            *part = tape.id(path, k - back);
        }
        let known = self.factors.borrow().memo.get(&key);
        known.unwrap_or_else(|| {
            let value = self.new_factor(tape, path, k);
            self.factors.borrow_mut().memo.insert(key, value);
            value
        })
    }

    /// The same, not remembered.
    #[inline]
    pub(super) fn new_factor(
        &self,
        tape: &Unfolded<'_, I::Vertex>,
        path: Place,
        k: usize,
    ) -> I::Value {
        self.extended(PathView::of_unfolded(tape, path.range(0, k + 1), self.shown()))
    }

    /// The factor that closes a path.
    #[inline(always)]
    pub(super) fn closing(&self, path: PathView<'_, I::Vertex>) -> I::Value {
        self.integrand.end(path.limited(self.shown()))
    }

    /// The factor that the last vertex of a path brings.
    #[inline(always)]
    pub(super) fn extended(&self, path: PathView<'_, I::Vertex>) -> I::Value {
        self.integrand.extend(path.limited(self.shown()))
    }
}

/// What is remembered under a name.
#[inline(always)]
pub(super) fn known_at<T: Copy>(values: &[Option<T>], name: u32) -> Option<T> {
    values.get(name as usize).copied().flatten()
}

/// Remembers a value under a name.
#[inline(always)]
pub(super) fn remember_at<T: Copy>(values: &mut Vec<Option<T>>, name: u32, value: T) {
    let i = name as usize;
    if i >= values.len() {
        values.resize(i + 1, None);
    }
    values[i] = Some(value);
}
