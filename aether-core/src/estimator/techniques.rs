//! The techniques that make paths of a piece of each of two walks: how many samples each takes, and what it counts.

use crate::combine::Separable;
use crate::path_density::PathDensity;
use crate::real::Scalar;

/// The techniques that make paths of a piece of each of two walks, by the numbers of vertices of the path and of its first
/// piece: how many samples each takes, and the heuristic by which they are combined. Made once for many walks.
#[derive(Clone, Debug)]
pub struct Techniques<R, H> {
    heuristic: H,
    /// One row after the other: that of paths of n vertices has n + 1 techniques.
    all: Vec<Technique<R>>,
    /// How far each row is like the one before.
    likeness: Vec<Likeness>,
}

/// A technique.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Technique<R> {
    /// How many samples it takes.
    pub samples: usize,
    /// The heuristic's term of that number.
    pub mass: PathDensity<R>,
}

/// How many techniques count as those of paths with one vertex less.
#[derive(Clone, Copy, Debug)]
pub(super) struct Likeness {
    /// Of those with as many vertices of the first walk, beginning with none.
    pub ahead: usize,
    /// Of those with as many vertices of the second walk, beginning with none.
    pub behind: usize,
}

impl<R: Scalar, H: Separable<R>> Techniques<R, H> {
    /// Those of no paths yet.
    pub fn new(heuristic: H) -> Self {
        Techniques { heuristic, all: Vec::new(), likeness: Vec::new() }
    }

    /// Has them make paths of up to `longest` vertices. `samples` says of those that are not known yet how many samples the
    /// technique takes that makes paths with so many vertices, the first number, of which so many are of the first walk,
    /// the second one; none if it is not used.
    pub fn reach(&mut self, longest: usize, samples: impl Fn(usize, usize) -> usize) {
        for length in self.likeness.len()..=longest {
            let (start, heuristic) = (self.all.len(), &self.heuristic);
            self.all.extend((0..=length).map(|first| {
                let samples = samples(length, first);
                let number = PathDensity::new(R::of(samples as f64));
                Technique { samples, mass: heuristic.term(number) }
            }));
            let (shorter, row) = (&self.all[start - length..start], &self.all[start..]);
            let is_like = |(a, b): &(&Technique<R>, &Technique<R>)| a.mass == b.mass;
            self.likeness.push(Likeness {
                ahead: shorter.iter().zip(row).take_while(is_like).count(),
                behind: shorter.iter().rev().zip(row.iter().rev()).take_while(is_like).count(),
            });
        }
    }

    /// The heuristic.
    pub fn heuristic(&self) -> &H {
        &self.heuristic
    }

    /// How many vertices the paths have at most; none if they are not known yet.
    pub(super) fn longest(&self) -> Option<usize> {
        self.likeness.len().checked_sub(1)
    }

    /// The techniques of paths of one length, which are known.
    #[inline]
    pub(super) fn row(&self, length: usize) -> &[Technique<R>] {
        let start = length * (length + 1) / 2;
        &self.all[start..start + length + 1]
    }

    /// How far those of one length are like those of paths with one vertex less.
    #[inline]
    pub(super) fn likeness(&self, length: usize) -> Likeness {
        self.likeness[length]
    }

    /// How many samples a technique takes, by the numbers of vertices of the path and of its first piece; none of what is
    /// not known.
    #[inline]
    pub fn samples(&self, length: usize, first: usize) -> usize {
        let is_known = first <= length && length < self.likeness.len();
        if is_known { self.row(length)[first].samples } else { 0 }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::combine::PowerHeuristic;

    #[test]
    fn rows_are_compared_from_both_ends() {
        let samples = |length: usize, first: usize| match first {
            0 => 0,
            1 => 9,
            _ if (length, first) == (4, 2) => 2,
            _ if first == length => 1,
            _ => 3,
        };
        let mut techniques = Techniques::<f64, _>::new(PowerHeuristic);
        assert_eq!((techniques.longest(), techniques.samples(2, 1)), (None, 0));
        techniques.reach(3, samples);
        techniques.reach(6, samples);
        techniques.reach(5, |_, _| unreachable!());
        assert_eq!((techniques.longest(), techniques.samples(7, 1)), (Some(6), 0));
        for length in 0..=6 {
            let known = |first: usize| techniques.samples(length, first);
            assert!((0..=length).all(|first| known(first) == samples(length, first)));
            let masses = techniques.row(length).iter().map(|known| known.mass.value());
            assert!(masses.eq((0..=length).map(|first| samples(length, first).pow(2) as f64)));
        }
        // Rows: 0; 0 9; 0 9 1; 0 9 3 1; 0 9 2 3 1; 0 9 3 3 3 1; 0 9 3 3 3 3 1.
        let likeness = |length| {
            let Likeness { ahead, behind } = techniques.likeness(length);
            (ahead, behind)
        };
        let all = [(0, 0), (1, 0), (2, 0), (2, 1), (2, 2), (2, 2), (5, 4)];
        assert!((0..=6).map(likeness).eq(all), "{:?}", (0..=6).map(likeness).collect::<Vec<_>>());
    }
}
