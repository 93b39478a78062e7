//! What is remembered of two walks, and of how their vertices could have been made.

use super::{BEHIND, End, Walk};
use crate::path_density::PathDensity;
use crate::real::Scalar;
use crate::sequence::{LAST, NONE};
use crate::strategy::{Drawn, Vertex};

/// A strategy and the side that it comes from, and the class of lengths of what lies before.
pub(super) type Question = (u32, u32);

/// A density, or a quotient of densities, and how the vertex would be made.
pub(super) type Answer<R> = Option<(Question, PathDensity<R>)>;

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

/// A piece of a walk, of the vertices up to one.
#[derive(Clone, Copy, Debug)]
pub(super) struct Piece<R> {
    /// What is next to a joint behind it.
    pub tail: Tail,
    /// The density of its last vertex under the strategy that drew it.
    pub own: PathDensity<R>,
    /// The densities with which the other walk would have made that vertex, over its own, and how it would, for the two ways
    /// that were asked for last: as far as they depend on vertices of this walk alone.
    pub ratios: [Answer<R>; 2],
}

/// What a window shows of a piece of a walk: its last vertices, next to the joint.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Tail {
    /// Their ids, beginning at the joint; [`NONE`] where the piece has no more.
    pub ids: [u32; LAST],
    /// A bit for each place of the window from which the next one is known to be seen.
    pub sees_next: u16,
    /// A bit for each place of the window whose vertex can be nowhere else.
    pub fixed: u16,
}

impl Tail {
    /// That of no vertices.
    pub const EMPTY: Tail = Tail { ids: [NONE; LAST], sees_next: 0, fixed: 0 };

    /// That of a piece with one more vertex.
    fn then<R>(&self, stop: &Stop<R>, end: End) -> Tail {
        let [first, second, _] = self.ids;
        let (visible, fixed) = (u16::from(stop.visible), u16::from(stop.fixed));
        // What was next to the joint moves away from it. The edge to the vertex before, which is further away, has the number
        // of its first place.
        let moved = |bits: u16, next: u16, at: usize| match end {
            End::First => (bits >> 1 | next << at) & PLACES << (at + 1 - LAST),
            End::Second => (bits << 1 | next << at) & PLACES << at,
        };
        let (place, edge) = match end {
            End::First => (BEHIND - 1, BEHIND - 2),
            End::Second => (BEHIND, BEHIND),
        };
        Tail {
            ids: [stop.id, first, second],
            sees_next: moved(self.sees_next, visible, edge),
            fixed: moved(self.fixed, fixed, place),
        }
    }
}

/// A bit for each vertex of a tail.
const PLACES: u16 = (1 << LAST) - 1;

/// What is known of one of two walks.
#[derive(Clone, Debug)]
pub(super) struct Side<R> {
    /// Which walk it is.
    pub walk: Option<Walk>,
    /// Its pieces, by the number of their vertices: the first one has none.
    pub pieces: Vec<Piece<R>>,
    /// How each of its steps makes a vertex, or would, and the first one of those up to it that do so alike.
    pub steps: Vec<(Question, u32)>,
    /// Of the second walk: how its first vertex would be drawn for itself after the next ones, and with which density.
    pub ending: Answer<R>,
    /// Sums over the techniques that join a path before a vertex, by its number; the first one is zero.
    pub sums: Vec<PathDensity<R>>,
    /// The length of the paths whose sums they are.
    pub summed: usize,
}

impl<R: Scalar> Side<R> {
    fn new() -> Self {
        Side {
            walk: None,
            pieces: Vec::new(),
            steps: Vec::new(),
            ending: None,
            sums: Vec::new(),
            summed: 0,
        }
    }

    /// Becomes that of a walk without any vertex yet.
    pub fn begin(&mut self, walk: Walk) {
        (self.walk, self.ending) = (Some(walk), None);
        self.steps.clear();
        self.pieces.clear();
        self.pieces.push(Piece { tail: Tail::EMPTY, own: PathDensity::ONE, ratios: [None; 2] });
    }

    /// Adds the piece with one more vertex than `before` to those that are there; returns what is next to a joint behind it.
    #[inline(always)]
    pub fn add(&mut self, before: Tail, stop: Stop<R>, end: End) -> Tail {
        let tail = before.then(&stop, end);
        self.pieces.push(Piece { tail, own: stop.own, ratios: [None; 2] });
        tail
    }

    /// Leaves no sum but the first one.
    pub fn forget_sums(&mut self) {
        self.sums.clear();
        self.sums.push(PathDensity::ZERO);
    }

    /// Whether the `count` steps up to one make their vertices as each of them does for a vertex before.
    #[inline]
    pub fn is_steady(&self, step: usize, count: usize) -> bool {
        self.steps.get(step).is_some_and(|(_, first)| *first as usize + count <= step)
    }
}

/// What an arena remembers of how the vertices of walks could have been made.
#[derive(Clone, Debug)]
pub(crate) struct Joints<V: Vertex> {
    /// The two walks that were asked for last.
    pub(super) sides: [Side<V::Real>; 2],
    /// The last vertices that were drawn for themselves, by the length of the path.
    pub(crate) lasts: Vec<Option<Drawn<V>>>,
}

impl<V: Vertex> Joints<V> {
    pub fn new() -> Self {
        Joints { sides: [Side::new(), Side::new()], lasts: Vec::new() }
    }

    pub fn clear(&mut self) {
        self.sides.iter_mut().for_each(|side| side.walk = None);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sequence::Place;

    #[test]
    fn tails_are_the_last_vertices_of_pieces() {
        let stop = |k: u32| Stop {
            id: k,
            visible: k % 2 == 1,
            fixed: k % 3 == 1,
            own: PathDensity::<f32>::ONE,
        };
        for end in [End::First, End::Second] {
            let mut side = Side::new();
            side.begin(Walk { place: Place::new(0, 7), len: 7 });
            let _ = (0..7).fold(Tail::EMPTY, |tail, k| side.add(tail, stop(k), end));
            assert_eq!(side.pieces.len(), 8);
            for (len, piece) in side.pieces.iter().enumerate() {
                let mut expected = Tail::EMPTY;
                for (j, stop) in (0..len as u32).rev().map(stop).take(LAST).enumerate() {
                    let (place, edge) = match end {
                        End::First => (BEHIND - 1 - j, BEHIND - 2 - j),
                        End::Second => (BEHIND + j, BEHIND + j),
                    };
                    expected.ids[j] = stop.id;
                    expected.sees_next |= u16::from(stop.visible) << edge;
                    expected.fixed |= u16::from(stop.fixed) << place;
                }
                assert_eq!(piece.tail, expected, "{len}");
            }
        }
    }
}
