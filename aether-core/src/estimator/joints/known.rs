//! What is remembered of two walks, and of how their vertices could have been made.

use super::Walk;
use crate::path_density::PathDensity;
use crate::real::Scalar;

/// A strategy and the side that it comes from, and the class of lengths of what lies before.
pub(super) type Question = (u32, u32);

/// A vertex of a walk.
#[derive(Clone, Copy, Debug)]
pub(super) struct Stop<R> {
    /// Its id.
    pub id: u32,
    /// Whether it is known to see the one before.
    pub visible: bool,
    /// Whether it can be nowhere else.
    pub fixed: bool,
    /// Its density under the strategy that drew it.
    pub own: PathDensity<R>,
}

/// What is known of one of two walks.
#[derive(Clone, Debug)]
pub(super) struct Side<R> {
    /// Which walk it is.
    pub walk: Option<Walk>,
    /// Its vertices.
    pub stops: Vec<Stop<R>>,
    /// How each of its steps makes a vertex, or would.
    pub questions: Vec<Question>,
    /// The density with which the other walk would have made a vertex, over that of its own walk, and how it would: as
    /// far as that depends on vertices of this walk alone.
    pub ratios: Vec<Option<(Question, PathDensity<R>)>>,
    /// Sums over the techniques that join a path before a vertex, by its number; the first one is zero.
    pub sums: Vec<Sum<R>>,
}

/// A sum over techniques, and what it follows from beside the sum before: the term of the last one, and how the other
/// walk would make the vertex before. Paths of several lengths mostly share it.
#[derive(Clone, Copy, Debug)]
pub(super) struct Sum<R> {
    /// The sum.
    pub sum: PathDensity<R>,
    /// What it follows from.
    pub of: (PathDensity<R>, Option<Question>),
}

/// What an arena remembers of how the vertices of walks could have been made.
#[derive(Clone, Debug)]
pub(crate) struct Joints<R> {
    /// By the id of a vertex: densities that depend on vertices of its own walk alone, under the strategies that were
    /// asked last.
    known: Vec<[(Question, PathDensity<R>); 2]>,
    /// The terms of the numbers of samples of all techniques, by the number of vertices of the first walk.
    pub(super) masses: Vec<PathDensity<R>>,
    /// The two walks that were asked for last.
    pub(super) sides: [Side<R>; 2],
    /// Where the last vertices are that were drawn for themselves, by the length of the path.
    pub(super) lasts: Vec<Option<u32>>,
    /// The term of two, for the heuristic that was asked for last.
    pub(super) two: PathDensity<R>,
    /// The density of the first vertex of the second walk as one that is drawn for itself after the next ones.
    pub(super) ending: PathDensity<R>,
}

impl<R: Scalar> Joints<R> {
    pub fn new() -> Self {
        let side = || Side {
            walk: None,
            stops: Vec::new(),
            questions: Vec::new(),
            ratios: Vec::new(),
            sums: Vec::new(),
        };
        Joints {
            known: Vec::new(),
            masses: Vec::new(),
            sides: [side(), side()],
            lasts: Vec::new(),
            two: PathDensity::ZERO,
            ending: PathDensity::ZERO,
        }
    }

    pub fn clear(&mut self) {
        self.known.clear();
        self.sides.iter_mut().for_each(|side| side.walk = None);
    }

    /// Makes room for so many vertices.
    #[inline]
    pub(super) fn reserve(&mut self, vertices: usize) {
        if vertices > self.known.len() {
            self.known.resize(vertices, [((u32::MAX, 0), PathDensity::ZERO); 2]);
        }
    }

    /// The densities that are known of a vertex that there is room for.
    #[inline]
    pub(super) fn of(&mut self, vertex: u32) -> &mut [(Question, PathDensity<R>); 2] {
        &mut self.known[vertex as usize]
    }
}
