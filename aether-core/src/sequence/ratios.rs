//! How much likelier each of several techniques makes a path than the one that made it.

use crate::path_density::PathDensity;
use crate::real::Real;
use crate::sequence::tape::Way;
use crate::sequence::{Arena, Place};
use crate::strategy::{Strategy, Vertex};

/// The conditional densities that were asked for last, of each vertex of one path: techniques that follow each
/// other in a list mostly make a vertex in the same way.
#[derive(Clone, Debug)]
pub(crate) struct LastFactors<R> {
    vertices: Vec<[(Way, R); 2]>,
}

impl<R: Real> LastFactors<R> {
    pub fn new() -> Self {
        LastFactors { vertices: Vec::new() }
    }

    /// Nothing is known of the vertices of a path of this length.
    fn start(&mut self, len: usize) {
        self.vertices.clear();
        self.vertices.resize(len, [(Way::NONE, R::ZERO); 2]);
    }

    /// What is known, or what `compute` finds.
    #[inline(always)]
    fn of(&mut self, k: usize, way: Way, compute: impl FnOnce() -> R) -> R {
        let [last, before] = &mut self.vertices[k];
        if last.0 == way {
            return last.1;
        }
        core::mem::swap(last, before);
        if last.0 != way {
            *last = (way, compute());
        }
        last.1
    }
}

/// A technique that others are compared with.
#[derive(Clone, Copy)]
struct Base<R> {
    place: Place,
    /// How much likelier it makes the path than the technique that made it.
    ratio: PathDensity<R>,
    /// The range of steps in which it may be unlike the technique that was looked at last, if both have the same
    /// length.
    unlike: Option<(u32, u32)>,
}

impl<V: Vertex, S: Strategy<V>> Arena<V, S> {
    /// The densities of `path` under two techniques without the factors that they share: they are alike but in
    /// these steps. The first one is zero as soon as it is known to be, and the second then not complete.
    #[inline]
    fn quotient(
        &self,
        [a, b]: [Place; 2],
        path: Place,
        (first, end): (u32, u32),
        last: &mut LastFactors<V::Real>,
    ) -> [PathDensity<V::Real>; 2] {
        let [mut new, mut old] = [PathDensity::ONE; 2];
        for k in first as usize..end as usize {
            let ways = self.tape.ways([a, b], k);
            if ways[0] == ways[1] {
                continue;
            }
            new = new * self.asked([a, path], k, ways[0], last);
            if new.is_zero() {
                break;
            }
            old = old * self.asked([b, path], k, ways[1], last);
        }
        [new, old]
    }

    /// The conditional density of vertex `k` under a technique that makes it in some way.
    #[inline(always)]
    fn asked(
        &self,
        [technique, path]: [Place; 2],
        k: usize,
        way: Way,
        last: &mut LastFactors<V::Real>,
    ) -> V::Real {
        let compute = || self.factor(technique, k, path);
        // To remember them pays only where they are those of joint draws.
        if S::VERTICES > 1 { last.of(k, way, compute) } else { compute() }
    }

    /// How much likelier each technique makes `path` than technique `own`, which made it: calls
    /// `visit` with each other technique and the ratio of densities. `unlike` says in which range of steps a
    /// technique is unlike the one before, if both have the same length.
    ///
    /// Neighbouring techniques share most factors, so each is compared with the one before that can make the path
    /// at all, going outwards from `own`, and directly with `own` where a pole gets in the way.
    pub(crate) fn density_ratios(
        &self,
        count: usize,
        own: usize,
        technique: impl Fn(usize) -> Place,
        unlike: impl Fn(usize) -> (u32, u32),
        mut visit: impl FnMut(usize, V::Real),
    ) {
        let path = technique(own);
        if S::VERTICES > 1 && !self.tape.is_whole(path) {
            // It is no sample of its own technique, whose density is zero.
            let others = (0..count).filter(|j| *j != own);
            return others.for_each(|j| visit(j, V::Real::INFINITY));
        }
        let mut last = core::mem::replace(&mut *self.last.borrow_mut(), LastFactors::new());
        if S::VERTICES > 1 {
            last.start(path.len as usize);
        }
        // Technique `j`; the later one of it and its neighbour on the side of `own` is `later`.
        let mut compare = |base: Base<V::Real>, j: usize, later: usize| {
            let place = technique(j);
            if place.len != path.len {
                visit(j, V::Real::ZERO);
                return Base { unlike: None, ..base };
            }
            let steps = base.unlike.map(|known| joined(known, unlike(later)));
            let next = Base { unlike: steps, ..base };
            if !self.comparable(place, path) {
                visit(j, V::Real::ZERO);
                return next;
            }
            let steps = steps.unwrap_or_else(|| self.tape.unlike(place, base.place));
            let [new, old] = self.quotient([place, base.place], path, steps, &mut last);
            if new.is_zero() {
                visit(j, V::Real::ZERO);
                next
            } else if new.is_regular() && old.is_regular() {
                let ratio = base.ratio * (new / old);
                visit(j, ratio.value());
                Base { place, ratio, unlike: Some((0, 0)) }
            } else {
                let steps = self.tape.unlike(place, path);
                let [new, old] = self.quotient([place, path], path, steps, &mut last);
                visit(j, new.ratio(old));
                next
            }
        };
        let start = Base { place: path, ratio: PathDensity::ONE, unlike: Some((0, 0)) };
        (own + 1..count).fold(start, |base, j| compare(base, j, j));
        (0..own).rev().fold(start, |base, j| compare(base, j, j + 1));
        *self.last.borrow_mut() = last;
    }
}

/// The smallest range with two ranges in it, of which the empty ones count for nothing.
fn joined(a: (u32, u32), b: (u32, u32)) -> (u32, u32) {
    match (a.0 < a.1, b.0 < b.1) {
        (false, _) => b,
        (_, false) => a,
        _ => (a.0.min(b.0), a.1.max(b.1)),
    }
}
