//! What is remembered of two walks, and of how their vertices could have been made.

use super::{BEHIND, End, Walk};
use crate::path_density::PathDensity;
use crate::real::Scalar;
use crate::sequence::{LAST, NONE};

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
    /// Its vertices.
    pub stops: Vec<Stop<R>>,
    /// What is next to a joint, by the number of vertices of the piece.
    pub tails: Vec<Tail>,
    /// How each of its steps makes a vertex, or would, and the first one of those up to it that do so alike.
    pub steps: Vec<(Question, u32)>,
    /// The densities with which the other walk would have made each vertex, over that of its own walk, and how it would,
    /// for the two ways that were asked for last: as far as they depend on vertices of this walk alone.
    pub ratios: Vec<[Answer<R>; 2]>,
    /// Of the second walk: how its first vertex would be drawn for itself after the next ones, and with which density.
    pub ending: Answer<R>,
    /// Sums over the techniques that join a path before a vertex, by its number; the first one is zero.
    pub sums: Vec<PathDensity<R>>,
    /// The length of the paths whose sums they are.
    pub summed: usize,
}

impl<R: Scalar> Side<R> {
    /// Becomes that of a walk without any vertex yet.
    pub fn begin(&mut self, walk: Walk) {
        self.walk = Some(walk);
        self.stops.clear();
        self.steps.clear();
        self.tails.clear();
        self.tails.push(Tail::EMPTY);
    }

    /// Adds a vertex, and what is next to a joint behind it.
    #[inline(always)]
    pub fn add(&mut self, stop: Stop<R>, end: End) {
        let before = self.tails.last().copied().unwrap_or(Tail::EMPTY);
        self.tails.push(before.then(&stop, end));
        self.stops.push(stop);
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
pub(crate) struct Joints<R> {
    /// The two walks that were asked for last.
    pub(super) sides: [Side<R>; 2],
    /// Where the last vertices are that were drawn for themselves, by the length of the path.
    pub(crate) lasts: Vec<Option<u32>>,
}

impl<R: Scalar> Joints<R> {
    pub fn new() -> Self {
        let side = || Side {
            walk: None,
            stops: Vec::new(),
            tails: Vec::new(),
            steps: Vec::new(),
            ratios: Vec::new(),
            ending: None,
            sums: Vec::new(),
            summed: 0,
        };
        Joints { sides: [side(), side()], lasts: Vec::new() }
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
            let [mut side, _] = Joints::new().sides;
            side.begin(Walk { place: Place::new(0, 7), len: 7 });
            (0..7).for_each(|k| side.add(stop(k), end));
            assert_eq!(side.tails.len(), 8);
            for (len, tail) in side.tails.iter().enumerate() {
                let mut expected = Tail::EMPTY;
                for (j, stop) in side.stops[..len].iter().rev().take(LAST).enumerate() {
                    let (place, edge) = match end {
                        End::First => (BEHIND - 1 - j, BEHIND - 2 - j),
                        End::Second => (BEHIND + j, BEHIND + j),
                    };
                    expected.ids[j] = stop.id;
                    expected.sees_next |= u16::from(stop.visible) << edge;
                    expected.fixed |= u16::from(stop.fixed) << place;
                }
                assert_eq!(*tail, expected, "{len}");
            }
        }
    }
}
