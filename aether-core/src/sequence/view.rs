//! What strategies and integrands see of a path.

use crate::sequence::tape::{Place, Step, Tape, Unfolded};
use crate::strategy::{Dirac, Drawn, Reads, Vertex};

/// The vertices before the one in question, in the direction of travel: for a path that was sampled
/// from a light and then reversed, a strategy still sees the light's vertex first.
#[derive(Clone, Copy, Debug)]
pub struct PathView<'p, V: Vertex> {
    source: Source<'p, V>,
    recent: Recent<'p, V>,
    /// How many of the source's vertices lie before the first.
    offset: usize,
    len: usize,
    /// How many of the first vertices are not shown.
    hidden: usize,
    dirac: Option<Dirac>,
}

/// How many vertices a view knows at most of steps that lie anywhere on a tape, and how many of any it has at hand.
pub(crate) const LAST: usize = 3;

/// The last vertices of a path, the last one first, as far as they are at hand: mostly all that is read.
pub(crate) type Recent<'p, V> = [Option<&'p V>; LAST];

#[derive(Clone, Copy, Debug)]
enum Source<'p, V: Vertex> {
    Slice(&'p [V]),
    Tape(&'p Tape<V>, Place),
    /// The same, with all of the tape at hand.
    Unfolded(&'p Unfolded<'p, V>, Place),
    /// The same, and then a vertex that is on no tape.
    Extended(&'p Unfolded<'p, V>, Place, &'p Drawn<V>),
    /// Steps none of which leads in a single direction: of the last ones, the last one first, is known where they are,
    /// as far as they are read.
    Last(&'p Unfolded<'p, V>, [Step; LAST]),
}

impl<'p, V: Vertex> PathView<'p, V> {
    /// A view of vertices that are in no sequence: to call a strategy by hand, in a test say.
    pub const fn from_slice(vertices: &'p [V]) -> Self {
        Self::new(Source::Slice(vertices), [None; LAST], vertices.len())
    }

    #[inline(always)]
    const fn new(source: Source<'p, V>, recent: Recent<'p, V>, len: usize) -> Self {
        PathView { source, recent, offset: 0, len, hidden: 0, dirac: None }
    }

    #[inline]
    pub(crate) fn of_tape(tape: &'p Tape<V>, place: Place) -> Self {
        Self::new(Source::Tape(tape, place), [None; LAST], place.len as usize)
    }

    /// Of what is read of a place on a tape that nothing is added to as long as the view is there.
    #[inline]
    pub(crate) fn of_unfolded(tape: &'p Unfolded<'p, V>, place: Place, reads: Reads) -> Self {
        let n = place.len as usize;
        let read = reads.vertices.min(n);
        let at_hand = |k: usize| if k < read { tape.at_hand(place.at(n - 1 - k)) } else { None };
        Self::of_recent(tape, place, core::array::from_fn(at_hand)).limited(reads)
    }

    /// Of a place whose last vertices are at hand.
    #[inline]
    pub(crate) fn of_recent(
        tape: &'p Unfolded<'p, V>,
        place: Place,
        recent: Recent<'p, V>,
    ) -> Self {
        Self::new(Source::Unfolded(tape, place), recent, place.len as usize)
    }

    /// The same, then a vertex that has been drawn after it.
    #[inline]
    pub(crate) fn of_extended(
        tape: &'p Unfolded<'p, V>,
        place: Place,
        [last, before, _]: Recent<'p, V>,
        drawn: &'p Drawn<V>,
    ) -> Self {
        let recent = [Some(&drawn.vertex), last, before];
        Self::new(Source::Extended(tape, place, drawn), recent, place.len as usize + 1)
    }

    /// Of `len` steps, the last of which, the last one first, lie anywhere on a tape on which no step leads in a single
    /// direction, and of which so many are read.
    #[inline]
    pub(crate) fn of_last(
        tape: &'p Unfolded<'p, V>,
        last: [Step; LAST],
        len: usize,
        read: usize,
    ) -> Self {
        let at_hand =
            |k: usize| if k < read && k < len { tape.at_hand(last[k].at()) } else { None };
        let hidden = len.saturating_sub(LAST);
        let view = Self::new(Source::Last(tape, last), core::array::from_fn(at_hand), len);
        PathView { hidden, ..view }
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
        let excess = self.len.saturating_sub(reads.vertices);
        if reads.length {
            return PathView { hidden: self.hidden.max(excess), ..self };
        }
        let (offset, len) = (self.offset + excess, self.len - excess);
        PathView { offset, len, hidden: self.hidden.saturating_sub(excess), ..self }
    }

    /// How many vertices there are. Meaningful to a strategy only if it declares to read the length.
    #[inline]
    pub fn len(&self) -> usize {
        self.len
    }

    /// Whether there is no vertex yet.
    #[inline]
    pub fn is_empty(&self) -> bool {
        self.len == 0
    }

    /// Vertex `i`, counted from the first; `None` if there is none or if reading it is not declared.
    #[inline(always)]
    pub fn vertex(&self, i: usize) -> Option<V> {
        self.back(self.len.checked_sub(i + 1)?)
    }

    /// The vertex `k` places before the last one: `back(0)` is the last vertex.
    #[inline(always)]
    pub fn back(&self, k: usize) -> Option<V> {
        if k >= self.len - self.hidden {
            return None;
        }
        match self.recent.get(k) {
            Some(Some(vertex)) => Some(**vertex),
            _ => self.vertex_elsewhere(k),
        }
    }

    /// The vertex `k` places before the last one, if it is not at hand.
    #[inline(never)]
    fn vertex_elsewhere(&self, k: usize) -> Option<V> {
        let i = self.offset + self.len - 1 - k;
        match self.source {
            Source::Slice(vertices) => vertices.get(i).copied(),
            Source::Tape(tape, place) => tape.vertex(place.at(i)),
            Source::Extended(_, place, drawn) if i == place.len as usize => Some(drawn.vertex),
            Source::Unfolded(tape, place) | Source::Extended(tape, place, _) => {
                tape.at_hand(place.at(i)).copied()
            }
            Source::Last(tape, last) => tape.at_hand(last.get(k)?.at()).copied(),
        }
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
        if i == 0 || i >= self.len {
            return false;
        }
        let (k, i) = (self.len - 1 - i, self.offset + i);
        match self.source {
            Source::Slice(_) => false,
            Source::Tape(tape, place) => tape.unfolded().visible(place, i),
            Source::Extended(_, place, drawn) if i == place.len as usize => drawn.visible,
            Source::Unfolded(tape, place) | Source::Extended(tape, place, _) => {
                tape.visible(place, i)
            }
            Source::Last(tape, last) => {
                let step = |k: usize| last.get(k).copied().filter(|step| *step != Step::NONE);
                step(k).zip(step(k + 1)).is_some_and(|(step, before)| tape.sees(step, before))
            }
        }
    }

    /// Whether vertex `i` carries this Dirac factor: it lies at a fixed position, or it scatters (or
    /// emits) in a single direction. In an integrand this tells the mirror of a layered material
    /// from its diffuse base.
    #[inline]
    pub fn carries(&self, i: usize, dirac: Dirac) -> bool {
        if i >= self.len {
            return false;
        }
        let on = |tape: &Unfolded<'_, V>, place: Place| {
            tape.carries(place.range(self.offset, place.len as usize), i, dirac)
        };
        match self.source {
            Source::Slice(_) => false,
            Source::Tape(tape, place) => on(&tape.unfolded(), place),
            Source::Unfolded(tape, place) => on(tape, place),
            Source::Extended(tape, place, drawn) => {
                // A position is the new vertex's own, a direction belongs to the one that it was drawn from.
                let bearer = match dirac {
                    Dirac::Position => self.len - 1,
                    Dirac::Direction => (self.len - 1).wrapping_sub(1),
                };
                (i == bearer && drawn.dirac == Some(dirac)) || (i + 1 < self.len && on(tape, place))
            }
            Source::Last(tape, last) => {
                let known = last.get(self.len - 1 - i).filter(|step| **step != Step::NONE);
                known.is_some_and(|step| tape.is_drawn_with(step.at(), dirac))
            }
        }
    }
}
