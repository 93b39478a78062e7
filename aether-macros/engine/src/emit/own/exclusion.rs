//! Pieces of which a point has at most one.

use crate::emit::item::Emitter;
use crate::emit::meeting;
use crate::emit::pieces::Place;
use crate::expr::{Id, Node};
use crate::rational::Q;

/// Whether the images of two pieces have no more than a border in common, by the ranges of a coordinate.
fn apart(e: &Emitter, j: usize, k: usize) -> bool {
    let range = |piece: usize, i: usize| {
        let problem = &e.parsed.pieces[piece].problem;
        problem.graph.range(problem.outputs[i])
    };
    let (_, m, _) = e.sizes();
    (0..m).any(|i| {
        let (a, b) = (range(j, i), range(k, i));
        a.hi <= b.lo || b.hi <= a.lo
    })
}

/// Whether no point has both preimages, but on a border, where they are one: those of pieces that are apart or meet, and of
/// one piece if one asks a number to be negative that the other asks to be positive, as two signs of an amplitude do.
pub(in crate::emit) fn exclusive(e: &Emitter, one: &Place, other: &Place) -> bool {
    if one.piece != other.piece {
        return apart(e, one.piece, other.piece) || meeting::known(&e.meeting, one, other);
    }
    let g = &one.problem.graph;
    let negated = |a: Id, b: Id| match g.node(a) {
        Node::Sum(c, terms) => c.is_zero() && terms[..] == [(Q::int(-1), b)],
        _ => false,
    };
    let theirs = &other.preimage.conditions;
    one.preimage.conditions.iter().any(|&a| theirs.iter().any(|&b| negated(a, b) || negated(b, a)))
}

/// Whether no point of a piece has a preimage in another one.
pub(super) fn excludes(e: &Emitter, places: &[Place], piece: usize, place: &Place) -> bool {
    let mut of_piece = places.iter().filter(|other| other.piece == piece);
    of_piece.all(|other| exclusive(e, other, place))
}

/// Whether the images of two pieces lie on the same side of a border that they have in common, as the map turns its
/// orientation round there: a point next to it has a preimage in both, and one on it has, in the limit, two.
pub(in crate::emit) fn folded(one: &Place, other: &Place) -> bool {
    let sides = [one, other].map(|place| place.derived.orientation);
    one.piece != other.piece && matches!(sides, [Some(a), Some(b)] if a != b)
}

/// Those of some preimages that exclude one.
pub(in crate::emit) fn excluding<'p, 'a: 'p>(
    e: &Emitter,
    place: Place<'a>,
    others: &'p [Place<'a>],
) -> impl Iterator<Item = &'p Place<'a>> {
    let others = others.iter().filter(move |other| other.number != place.number);
    others.filter(move |other| exclusive(e, other, &place))
}
