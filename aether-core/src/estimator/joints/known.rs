//! What is remembered of how the vertices of walks could have been made.

use crate::path_density::PathDensity;
use crate::real::Scalar;

/// A strategy and the side that it comes from, and the class of lengths of what lies before.
pub(super) type Question = (u32, u32);

/// What is known of a vertex.
#[derive(Clone, Debug)]
pub(super) struct Known<R> {
    /// Its density under the strategy that drew it.
    pub own: Option<PathDensity<R>>,
    /// Densities that depend on vertices of its own piece alone, under the strategies that were asked last.
    pub others: [(Question, PathDensity<R>); 2],
}

/// What an arena remembers of how the vertices of walks could have been made.
#[derive(Clone, Debug)]
pub(crate) struct Joints<R> {
    /// By the id of a vertex.
    known: Vec<Known<R>>,
    /// The terms of the numbers of samples of all techniques, by the number of vertices of the first walk.
    pub(super) masses: Vec<PathDensity<R>>,
    /// The sums of either piece, up to each vertex.
    pub(super) sums: [Vec<PathDensity<R>>; 2],
    /// By the vertices of either piece.
    pub(super) ratios: [Vec<Ratio<R>>; 2],
}

/// The density with which the other walk would have made a vertex, over that of its own walk, and what that depends on:
/// mostly it is the same for paths of several lengths.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Ratio<R> {
    /// The name of the run up to the last vertex that matters.
    pub run: u32,
    /// How the other walk would have made the vertex.
    pub question: Question,
    /// The ratio.
    pub value: PathDensity<R>,
}

impl<R: Scalar> Joints<R> {
    pub fn new() -> Self {
        let (sums, ratios) = Default::default();
        Joints { known: Vec::new(), masses: Vec::new(), sums, ratios }
    }

    pub fn clear(&mut self) {
        self.known.clear();
        self.ratios.iter_mut().for_each(Vec::clear);
    }

    /// Makes room for so many vertices.
    #[inline]
    pub(super) fn reserve(&mut self, vertices: usize) {
        if vertices > self.known.len() {
            let nothing = Known { own: None, others: [((u32::MAX, 0), PathDensity::ZERO); 2] };
            self.known.resize(vertices, nothing);
        }
    }

    /// What is known of a vertex that there is room for.
    #[inline]
    pub(super) fn of(&mut self, vertex: u32) -> &mut Known<R> {
        &mut self.known[vertex as usize]
    }
}
