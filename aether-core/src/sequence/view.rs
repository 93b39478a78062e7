//! What strategies and integrands see of a path.

use crate::sequence::tape::{Place, Step, Tape, Unfolded};
use crate::strategy::{Dirac, Drawn, Reads, Vertex};

/// The vertices before the one in question, in the direction of travel: for a path that was sampled
/// from a light and then reversed, a strategy still sees the light's vertex first.
#[derive(Clone, Copy, Debug)]
pub struct PathView<'p, V: Vertex> {
    source: Source<'p, V>,
    /// How many of the first vertices are not shown.
    hidden: usize,
    dirac: Option<Dirac>,
}

/// How many vertices a view knows at most of steps that lie anywhere on a tape.
pub(crate) const LAST: usize = 3;

#[derive(Clone, Copy, Debug)]
enum Source<'p, V: Vertex> {
    Slice(&'p [V]),
    Tape(&'p Tape<V>, Place),
    /// The same, with all of the tape at hand.
    Unfolded(&'p Unfolded<'p, V>, Place),
    /// The same, and then a vertex that is on no tape.
    Extended(&'p Unfolded<'p, V>, Place, &'p Drawn<V>),
    /// So many steps, none of which leads in a single direction: of the last ones, the last one first, is known where
    /// they are.
    Last(&'p Unfolded<'p, V>, [Step; LAST], usize),
}

impl<'p, V: Vertex> PathView<'p, V> {
    /// A view of vertices that are in no sequence: to call a strategy by hand, in a test say.
    pub const fn from_slice(vertices: &'p [V]) -> Self {
        PathView { source: Source::Slice(vertices), hidden: 0, dirac: None }
    }

    #[inline]
    pub(crate) fn of_tape(tape: &'p Tape<V>, place: Place) -> Self {
        PathView { source: Source::Tape(tape, place), hidden: 0, dirac: None }
    }

    /// Of a tape that nothing is added to as long as the view is there.
    #[inline]
    pub(crate) fn of_unfolded(tape: &'p Unfolded<'p, V>, place: Place) -> Self {
        PathView { source: Source::Unfolded(tape, place), hidden: 0, dirac: None }
    }

    /// The same, then a vertex that has been drawn after it.
    #[inline]
    pub(crate) fn of_extended(
        tape: &'p Unfolded<'p, V>,
        place: Place,
        drawn: &'p Drawn<V>,
    ) -> Self {
        PathView { source: Source::Extended(tape, place, drawn), hidden: 0, dirac: None }
    }

    /// Of `len` steps, the last of which, the last one first, lie anywhere on a tape on which no step leads in a single
    /// direction.
    #[inline]
    pub(crate) fn of_last(tape: &'p Unfolded<'p, V>, last: [Step; LAST], len: usize) -> Self {
        let hidden = len.saturating_sub(LAST);
        PathView { source: Source::Last(tape, last, len), hidden, dirac: None }
    }

    /// The same path, asking for another kind of density; see [`PathView::dirac`].
    #[inline]
    pub fn asking(self, dirac: Option<Dirac>) -> Self {
        PathView { dirac, ..self }
    }

    /// The same path with only what is declared to be read: older vertices are hidden and, if the
    /// length is not declared, cut off.
    #[inline]
    pub fn limited(self, reads: Reads) -> Self {
        let excess = self.len().saturating_sub(reads.vertices);
        if reads.length {
            PathView { hidden: self.hidden.max(excess), ..self }
        } else {
            let source = match self.source {
                Source::Slice(vertices) => Source::Slice(&vertices[excess..]),
                Source::Tape(tape, place) => {
                    Source::Tape(tape, place.range(excess, place.len as usize))
                }
                Source::Unfolded(tape, place) => {
                    Source::Unfolded(tape, place.range(excess, place.len as usize))
                }
                Source::Extended(tape, place, drawn) => {
                    Source::Extended(tape, place.range(excess, place.len as usize), drawn)
                }
                Source::Last(tape, last, len) => Source::Last(tape, last, len - excess),
            };
            PathView { source, hidden: self.hidden.saturating_sub(excess), ..self }
        }
    }

    /// How many vertices there are. Meaningful to a strategy only if it declares to read the length.
    #[inline]
    pub fn len(&self) -> usize {
        match self.source {
            Source::Slice(vertices) => vertices.len(),
            Source::Tape(_, place) | Source::Unfolded(_, place) => place.len as usize,
            Source::Extended(_, place, _) => place.len as usize + 1,
            Source::Last(.., len) => len,
        }
    }

    /// Whether there is no vertex yet.
    #[inline]
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Vertex `i`, counted from the first; `None` if there is none or if reading it is not declared.
    #[inline(always)]
    pub fn vertex(&self, i: usize) -> Option<V> {
        if i < self.hidden || i >= self.len() {
            return None;
        }
        match self.source {
            Source::Unfolded(tape, place) => tape.vertex(place.at(i)),
            Source::Extended(_, place, drawn) if i == place.len as usize => Some(drawn.vertex),
            Source::Extended(tape, place, _) => tape.vertex(place.at(i)),
            Source::Last(tape, last, len) => tape.vertex(last[len - 1 - i].at()),
            _ => self.vertex_elsewhere(i),
        }
    }

    #[cold]
    fn vertex_elsewhere(&self, i: usize) -> Option<V> {
        match self.source {
            Source::Slice(vertices) => vertices.get(i).copied(),
            Source::Tape(tape, place) => tape.vertex(place.at(i)),
            Source::Unfolded(tape, place) | Source::Extended(tape, place, _) => {
                tape.vertex(place.at(i))
            }
            Source::Last(tape, last, len) => tape.vertex(last[len - 1 - i].at()),
        }
    }

    /// The vertex `k` places before the last one: `back(0)` is the last vertex.
    #[inline(always)]
    pub fn back(&self, k: usize) -> Option<V> {
        self.vertex(self.len().checked_sub(k + 1)?)
    }

    /// The last vertex: the one that the path continues from.
    #[inline(always)]
    pub fn last(&self) -> Option<V> {
        self.back(0)
    }

    /// Which kind of value a density is asked for: `None` for a density, else the probability of a
    /// discrete mass of this kind. It is the record of how the path was made.
    #[inline]
    pub fn dirac(&self) -> Option<Dirac> {
        self.dirac
    }

    /// Whether vertex `i` is known to see vertex `i - 1`, because one was found from the other by a
    /// ray cast.
    #[inline]
    pub fn visible(&self, i: usize) -> bool {
        match self.source {
            Source::Tape(tape, place) if i > 0 && i < self.len() => {
                tape.unfolded().visible(place, i)
            }
            Source::Unfolded(tape, place) if i > 0 && i < self.len() => tape.visible(place, i),
            Source::Extended(_, place, drawn) if i == place.len as usize => i > 0 && drawn.visible,
            Source::Extended(tape, place, _) if i > 0 && i < self.len() => tape.visible(place, i),
            Source::Last(tape, last, len) if i > 0 && i < len && len < i + LAST => {
                tape.sees(last[len - 1 - i], last[len - i])
            }
            _ => false,
        }
    }

    /// Whether vertex `i` carries this Dirac factor: it lies at a fixed position, or it scatters (or
    /// emits) in a single direction. In an integrand this tells the mirror of a layered material
    /// from its diffuse base.
    #[inline]
    pub fn carries(&self, i: usize, dirac: Dirac) -> bool {
        match self.source {
            Source::Tape(tape, place) if i < self.len() => tape.unfolded().carries(place, i, dirac),
            Source::Unfolded(tape, place) if i < self.len() => tape.carries(place, i, dirac),
            Source::Extended(tape, place, drawn) if i < self.len() => {
                // A position is the new vertex's own, a direction belongs to the one that it was drawn from.
                let bearer = match dirac {
                    Dirac::Position => place.len as usize,
                    Dirac::Direction => (place.len as usize).wrapping_sub(1),
                };
                if i == bearer && drawn.dirac == Some(dirac) {
                    return true;
                }
                i < place.len as usize && tape.carries(place, i, dirac)
            }
            Source::Last(tape, last, len) if i < len && len <= i + LAST => {
                tape.is_drawn_with(last[len - 1 - i].at(), dirac)
            }
            _ => false,
        }
    }
}
