//! Weights of paths.

use core::ops::Deref;

use crate::combine::{Combine, Heuristic};
use crate::real::Real;
use crate::sequence::{Arena, Listed, RandomSequence};
use crate::strategy::{Strategy, Vertex};

/// A list of paths that lives in their arena, so that collecting them needs no heap.
#[derive(Debug)]
pub struct Paths<'a, V: Vertex, S> {
    arena: &'a Arena<V, S>,
    start: usize,
    len: usize,
}

impl<V: Vertex, S> Clone for Paths<'_, V, S> {
    fn clone(&self) -> Self {
        *self
    }
}
impl<V: Vertex, S> Copy for Paths<'_, V, S> {}

impl<V: Vertex, S: Strategy<V>> Arena<V, S> {
    /// A list of paths of this arena, in memory of the arena. Paths that do not exist (slices out of
    /// range) are left out.
    ///
    /// # Panics
    /// If a path is of another arena: its density under the techniques of this one is not known.
    pub fn collect<'a>(
        &'a self,
        paths: impl IntoIterator<Item = RandomSequence<'a, V, S>>,
    ) -> Paths<'a, V, S> {
        self.collect_counted(paths.into_iter().map(|path| (path, 1)))
    }

    /// [`Arena::collect`] with the number of samples that each technique takes.
    ///
    /// # Panics
    /// As [`Arena::collect`].
    pub fn collect_counted<'a>(
        &'a self,
        paths: impl IntoIterator<Item = (RandomSequence<'a, V, S>, usize)>,
    ) -> Paths<'a, V, S> {
        let (mut start, mut len) = (self.lists.borrow().len(), 0);
        for (path, count) in paths {
            assert!(
                core::ptr::eq(path.arena, self),
                "paths of different arenas cannot be combined: they must all be of the arena that made the first one"
            );
            if !path.handle.absent {
                let mut lists = self.lists.borrow_mut();
                if lists.len() != start + len {
                    // Making the path has collected others: this list goes on at the end.
                    let end = lists.len();
                    lists.extend_from_within(start..start + len);
                    start = end;
                }
                let samples = V::Real::of(count as f64);
                lists.push(Listed { handle: path.handle, samples, unlike: None });
                len += 1;
            }
        }
        Paths { arena: self, start, len }
    }
}

impl<'a, V: Vertex, S: Strategy<V>> Paths<'a, V, S> {
    /// How many there are.
    pub fn len(&self) -> usize {
        self.len
    }

    /// Whether there is none.
    pub fn is_empty(&self) -> bool {
        self.len == 0
    }

    /// Path `i`, if there is one.
    pub fn get(&self, i: usize) -> Option<RandomSequence<'a, V, S>> {
        (i < self.len).then(|| self.path(i))
    }

    #[inline]
    fn listed(&self, i: usize) -> Listed<V::Real> {
        self.arena.lists.borrow()[self.start + i]
    }

    #[inline]
    fn path(&self, i: usize) -> RandomSequence<'a, V, S> {
        RandomSequence { arena: self.arena, handle: self.listed(i).handle }
    }

    #[inline]
    fn count(&self, i: usize) -> V::Real {
        self.listed(i).samples
    }

    /// The weight of path `own`.
    fn weight(&self, own: usize, heuristic: &impl Heuristic<V::Real>) -> V::Real {
        let samples = self.count(own);
        if samples == V::Real::ZERO {
            return V::Real::ZERO;
        }
        let mut ratios = core::mem::take(&mut *self.arena.ratios.borrow_mut());
        let own_list = self.start..self.start + self.len;
        // The lists are free again before the heuristic, which may be anybody's, is asked.
        self.arena.density_ratios(&mut self.arena.lists.borrow_mut()[own_list], own, &mut ratios);
        let weight = heuristic.weight(&ratios, own) / samples;
        *self.arena.ratios.borrow_mut() = ratios;
        weight
    }
}

/// A path with its weight among several techniques. Dereferences to the path.
#[derive(Clone, Copy, Debug)]
pub struct Weighted<'a, V: Vertex, S> {
    /// The path.
    pub path: RandomSequence<'a, V, S>,
    /// The heuristic's weight over the number of samples that the technique takes.
    pub weight: V::Real,
}

impl<'a, V: Vertex, S> Deref for Weighted<'a, V, S> {
    type Target = RandomSequence<'a, V, S>;
    fn deref(&self) -> &Self::Target {
        &self.path
    }
}

/// The weighted paths, in order; each weight is computed when its turn comes.
#[derive(Clone, Debug)]
pub struct Combined<'a, V: Vertex, S, H> {
    paths: Option<Paths<'a, V, S>>,
    next: usize,
    heuristic: H,
}

impl<'a, V: Vertex, S: Strategy<V>, H: Heuristic<V::Real>> Combined<'a, V, S, H> {
    /// The next path that is a sample, and its number in the list.
    pub(crate) fn next_sample(&mut self) -> Option<(usize, RandomSequence<'a, V, S>)> {
        let paths = self.paths?;
        let lists = paths.arena.lists.borrow();
        while self.next < paths.len {
            let (i, handle) = (self.next, lists[paths.start + self.next].handle);
            self.next += 1;
            if handle.complete() {
                return Some((i, RandomSequence { arena: paths.arena, handle }));
            }
        }
        None
    }

    /// How many samples a technique takes.
    pub(crate) fn samples_of(&self, i: usize) -> V::Real {
        self.paths.map_or(V::Real::ONE, |paths| paths.count(i))
    }

    pub(crate) fn weight_of(&self, i: usize) -> V::Real {
        self.paths.map_or(V::Real::ZERO, |paths| paths.weight(i, &self.heuristic))
    }
}

impl<'a, V: Vertex, S: Strategy<V>, H: Heuristic<V::Real>> Iterator for Combined<'a, V, S, H> {
    type Item = Weighted<'a, V, S>;
    fn next(&mut self) -> Option<Weighted<'a, V, S>> {
        let (i, path) = self.next_sample()?;
        Some(Weighted { path, weight: self.weight_of(i) })
    }
}

impl<'a, V, S, H> Combine<H> for Paths<'a, V, S>
where
    V: Vertex,
    S: Strategy<V>,
    H: Heuristic<V::Real>,
{
    type Output = Combined<'a, V, S, H>;
    fn combine_with(self, heuristic: H) -> Self::Output {
        Combined { paths: Some(self), next: 0, heuristic }
    }
}

macro_rules! lists {
    ($([$($n:tt)*] $list:ty, $item:ident => $path:expr, $count:expr;)*) => {
        $(impl<'a, V, S, H, $($n)*> Combine<H> for $list
        where
            V: Vertex,
            S: Strategy<V>,
            H: Heuristic<V::Real>,
        {
            type Output = Combined<'a, V, S, H>;
            fn combine_with(self, heuristic: H) -> Self::Output {
                let pairs = || self.iter().map(|$item| ($path, $count));
                let paths =
                    pairs().next().map(|(first, _)| first.arena.collect_counted(pairs()));
                Combined { paths, next: 0, heuristic }
            }
        })*
    };
}
lists! {
    [] &[RandomSequence<'a, V, S>], path => *path, 1;
    [] &Vec<RandomSequence<'a, V, S>>, path => *path, 1;
    [const N: usize] &[RandomSequence<'a, V, S>; N], path => *path, 1;
    [const N: usize] [RandomSequence<'a, V, S>; N], path => *path, 1;
    [] &[(RandomSequence<'a, V, S>, usize)], pair => pair.0, pair.1;
    [] &Vec<(RandomSequence<'a, V, S>, usize)>, pair => pair.0, pair.1;
    [const N: usize] &[(RandomSequence<'a, V, S>, usize); N], pair => pair.0, pair.1;
    [const N: usize] [(RandomSequence<'a, V, S>, usize); N], pair => pair.0, pair.1;
}
