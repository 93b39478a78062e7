//! How much likelier each of several techniques makes a path than the one that made it.

use crate::combine::weighted_ratio;
use crate::path_density::PathDensity;
use crate::real::Real;
use crate::sequence::evaluate::Densities;
use crate::sequence::tape::Way;
use crate::sequence::{Arena, Listed, Place};
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

/// How much likelier one technique makes a path than another.
enum Quotient<R> {
    /// It does not make it.
    Zero,
    /// The quotient of densities that are neither zero nor infinite.
    Regular(PathDensity<R>),
    /// One of the densities is infinite, or the other zero: the ratio as weights need it.
    Pole(R),
}

/// Techniques in a list, by which the same path may have been made.
struct Comparison<'r, V: Vertex, S> {
    densities: Densities<'r, V, S>,
    list: &'r mut [Listed<V::Real>],
    path: Place,
    last: LastFactors<V::Real>,
}

impl<V: Vertex, S: Strategy<V>> Comparison<'_, V, S> {
    /// The range of steps in which technique `j` is unlike the one before, which has the same length.
    #[inline]
    fn unlike(&mut self, j: usize) -> (u32, u32) {
        if let Some(known) = self.list[j].unlike {
            return known;
        }
        let [before, place] = [j - 1, j].map(|j| self.list[j].handle.place);
        let unlike = self.densities.tape.unlike(before, place);
        self.list[j].unlike = Some(unlike);
        unlike
    }

    /// How the densities of the path under two techniques compare, which are alike but in these steps.
    #[inline]
    fn quotient(&mut self, techniques: [Place; 2], steps: (u32, u32)) -> Quotient<V::Real> {
        let [mut new, mut old] = [V::Real::ONE; 2];
        // Mostly two factors, of ordinary size.
        let is_plain = |x: V::Real| x > V::Real::of(1e-12) && x < V::Real::of(1e12);
        for k in steps.0 as usize..steps.1 as usize {
            let ways = techniques.map(|place| self.densities.tape.way(place, k));
            if ways[0] == ways[1] {
                continue;
            }
            let factor = self.factor(techniques[0], k, ways[0]);
            if factor == V::Real::ZERO {
                return Quotient::Zero;
            }
            new *= factor;
            old *= self.factor(techniques[1], k, ways[1]);
            if !(is_plain(new) && is_plain(old)) {
                return self.wide_quotient(techniques, steps);
            }
        }
        Quotient::Regular(PathDensity::new(new / old))
    }

    /// The same of factors of any size.
    #[cold]
    fn wide_quotient(&mut self, techniques: [Place; 2], steps: (u32, u32)) -> Quotient<V::Real> {
        let [mut new, mut old] = [PathDensity::ONE; 2];
        for k in steps.0 as usize..steps.1 as usize {
            let ways = techniques.map(|place| self.densities.tape.way(place, k));
            if ways[0] != ways[1] {
                new = new * self.factor(techniques[0], k, ways[0]);
                if new.is_zero() {
                    return Quotient::Zero;
                }
                old = old * self.factor(techniques[1], k, ways[1]);
            }
        }
        if new.is_regular() && old.is_regular() {
            Quotient::Regular(new / old)
        } else {
            Quotient::Pole(new.ratio(old))
        }
    }

    /// The conditional density of vertex `k` under a technique that makes it in some way.
    #[inline(always)]
    fn factor(&mut self, technique: Place, k: usize, way: Way) -> V::Real {
        let Comparison { densities, path, last, .. } = self;
        let mut compute = || densities.factor_by(way, technique, k, *path);
        // To remember them pays only where they are those of joint draws.
        if S::VERTICES > 1 { last.of(k, way, compute) } else { compute() }
    }

    /// How much likelier technique `j` makes the path than the one that made it, and what is known of it for the
    /// next comparison; the later one of it and its neighbour on the side of that one is `later`.
    #[inline]
    fn compare(&mut self, base: Base<V::Real>, j: usize, later: usize) -> (V::Real, Base<V::Real>) {
        let (place, path) = (self.list[j].handle.place, self.path);
        if place.len != path.len {
            return (V::Real::ZERO, Base { unlike: None, ..base });
        }
        let steps = base.unlike.map(|known| joined(known, self.unlike(later)));
        let next = Base { unlike: steps, ..base };
        if !self.densities.comparable(place, path) {
            return (V::Real::ZERO, next);
        }
        let steps = steps.unwrap_or_else(|| self.densities.tape.unlike(place, base.place));
        match self.quotient([place, base.place], steps) {
            Quotient::Zero => (V::Real::ZERO, next),
            Quotient::Regular(quotient) => {
                let ratio = base.ratio * quotient;
                (ratio.value(), Base { place, ratio, unlike: Some((0, 0)) })
            }
            Quotient::Pole(_) => {
                let steps = self.densities.tape.unlike(place, path);
                let ratio = match self.quotient([place, path], steps) {
                    Quotient::Zero => V::Real::ZERO,
                    Quotient::Regular(quotient) => quotient.value(),
                    Quotient::Pole(ratio) => ratio,
                };
                (ratio, next)
            }
        }
    }
}

impl<V: Vertex, S: Strategy<V>> Arena<V, S> {
    /// How much likelier each technique of a list makes the path of technique `own` than that one, which made it,
    /// with their numbers of samples: the ratios are put into `ratios`.
    ///
    /// Neighbouring techniques share most factors, so each is compared with the one before that can make the path
    /// at all, going outwards from `own`, and directly with `own` where a pole gets in the way.
    pub(crate) fn density_ratios(
        &self,
        list: &mut [Listed<V::Real>],
        own: usize,
        ratios: &mut Vec<V::Real>,
    ) {
        let (count, path, samples) = (list.len(), list[own].handle.place, list[own].samples);
        ratios.clear();
        ratios.extend(list.iter().map(|_| V::Real::ONE));
        if S::VERTICES > 1 && !self.tape.is_whole(path) {
            // It is no sample of its own technique, whose density is zero.
            for j in (0..count).filter(|j| *j != own) {
                ratios[j] = weighted_ratio(V::Real::INFINITY, list[j].samples, samples);
            }
            return;
        }
        let mut last = core::mem::replace(&mut *self.last.borrow_mut(), LastFactors::new());
        if S::VERTICES > 1 {
            last.start(path.len as usize);
        }
        let mut comparison = Comparison { densities: self.densities(), list, path, last };
        let start = Base { place: path, ratio: PathDensity::ONE, unlike: Some((0, 0)) };
        let mut compare = |base, j: usize, later| {
            let (ratio, base) = comparison.compare(base, j, later);
            ratios[j] = weighted_ratio(ratio, comparison.list[j].samples, samples);
            base
        };
        (own + 1..count).fold(start, |base, j| compare(base, j, j));
        (0..own).rev().fold(start, |base, j| compare(base, j, j + 1));
        *self.last.borrow_mut() = comparison.last;
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
