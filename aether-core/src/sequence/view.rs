//! What strategies and integrands see of a path.

use crate::sequence::tape::{Place, Tape, Unfolded};
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

/// How many vertices of any path a view has at hand.
pub(crate) const LAST: usize = 3;

/// What `of` says of each of the last vertices, the last one first.
#[inline(always)]
pub(crate) fn each_last<T>(of: impl Fn(usize) -> T) -> [T; LAST] {
    // The standard library's way is not always inlined.
    [of(0), of(1), of(2)]
}

/// The last vertices of a path, the last one first, as far as they are at hand and shown: mostly all that is read.
type Recent<'p, V> = [Option<&'p V>; LAST];

/// Those of the last vertices that are shown of a path.
#[inline(always)]
fn shown<V: Vertex>(recent: Recent<'_, V>, reads: Reads) -> Recent<'_, V> {
    each_last(|k| if k < reads.vertices { recent[k] } else { None })
}

/// The last vertices of a path as they were drawn, the last one first: all that is read.
pub(crate) type LastDrawn<'p, V> = [Option<&'p Drawn<V>>; LAST];

#[derive(Clone, Copy, Debug)]
enum Source<'p, V: Vertex> {
    Slice(&'p [V]),
    Tape(&'p Tape<V>, Place),
    /// The same, with all of the tape at hand.
    Unfolded(&'p Unfolded<'p, V>, Place),
    /// The last vertices as they were drawn, the last one first.
    Drawn(LastDrawn<'p, V>),
    /// The last of vertices that end, or in opposite order begin, at a place of a window; no others are read.
    Window(&'p Window<'p, V>, u8, bool),
}

/// Vertices in a row, of which none leads in a single direction, with empty places on either side.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Window<'p, V> {
    /// The vertices.
    pub vertices: [Option<&'p V>; WINDOW],
    /// A bit for each that is known to see the next one.
    pub sees_next: u16,
    /// A bit for each that can be nowhere else.
    pub fixed: u16,
}

/// How many places a window has: two times as many vertices as a view has at hand, and on either side two empty
/// places, as a view looks up two places on both sides of its last vertex, whichever way it goes.
pub(crate) const WINDOW: usize = 2 * LAST + 4;

impl<'p, V: Vertex> PathView<'p, V> {
    /// A view of vertices that are in no sequence: to call a strategy by hand, in a test say.
    pub const fn from_slice(vertices: &'p [V]) -> Self {
        Self::new(Source::Slice(vertices), [None; LAST], vertices.len())
    }

    #[inline(always)]
    const fn new(source: Source<'p, V>, recent: Recent<'p, V>, len: usize) -> Self {
        PathView { source, recent, offset: 0, len, hidden: 0, dirac: None }
    }

    #[inline(always)]
    pub(crate) fn of_tape(tape: &'p Tape<V>, place: Place) -> Self {
        Self::new(Source::Tape(tape, place), [None; LAST], place.len as usize)
    }

    /// Of what is read of a place on a tape that nothing is added to as long as the view is there.
    #[inline(always)]
    pub(crate) fn of_unfolded(tape: &'p Unfolded<'p, V>, place: Place, reads: Reads) -> Self {
        let n = place.len as usize;
        let read = reads.vertices.min(n);
        let at_hand = |k: usize| if k < read { tape.at_hand(place.at(n - 1 - k)) } else { None };
        let view = Self::new(Source::Unfolded(tape, place), each_last(at_hand), n);
        // As `limited` says, of a view of which nothing is hidden yet.
        match reads.length {
            true => PathView { hidden: n - read, ..view },
            false => PathView { offset: n - read, len: read, ..view },
        }
    }

    /// Of `len` vertices of which the last ones are at hand as they were drawn, and no others are read.
    #[inline(always)]
    pub(crate) fn of_drawn(last: LastDrawn<'p, V>, len: usize) -> Self {
        let recent = last.map(|drawn| drawn.map(|drawn| &drawn.vertex));
        Self::new(Source::Drawn(last), recent, len)
    }

    /// Of `len` vertices of which the last one is at a place of a window, two places from its ends at least, and those before it
    /// are before that place, or behind it; no more are read than a view has at hand.
    #[inline(always)]
    pub(crate) fn of_window(
        window: &'p Window<'p, V>,
        place: usize,
        backward: bool,
        len: usize,
    ) -> Self {
        let [before, here, behind] = [place - 2, place, place + 2].map(|i| window.vertices[i]);
        let (next, last) = match backward {
            true => (window.vertices[place + 1], behind),
            false => (window.vertices[place - 1], before),
        };
        let source = Source::Window(window, place as u8, backward);
        Self::new(source, [here, next, last], len)
    }

    /// The same path, asking for another kind of density; see [`PathView::dirac`].
    #[inline(always)]
    pub fn asking(self, dirac: Option<Dirac>) -> Self {
        PathView { dirac, ..self }
    }

    /// The same path with only what is declared to be read: older vertices are hidden and, if the
    /// length is not declared, cut off.
    #[inline(always)]
    pub fn limited(self, reads: Reads) -> Self {
        let (recent, len) = (shown(self.recent, reads), self.len.min(reads.vertices));
        let excess = self.len - len;
        if reads.length {
            return PathView { recent, hidden: self.hidden.max(excess), ..self };
        }
        let (offset, hidden) = (self.offset + excess, self.hidden.saturating_sub(excess));
        PathView { recent, offset, len, hidden, ..self }
    }

    /// How many vertices there are. Meaningful to a strategy only if it declares to read the length.
    #[inline(always)]
    pub fn len(&self) -> usize {
        self.len
    }

    /// Whether there is no vertex yet.
    #[inline(always)]
    pub fn is_empty(&self) -> bool {
        self.len == 0
    }

    /// Vertex `i`, counted from the first; `None` if there is none or if reading it is not declared. Where the length of the
    /// path is not declared, as for integrands, the first one is that of those which are shown, and [`PathView::back`] is meant.
    #[inline(always)]
    pub fn vertex(&self, i: usize) -> Option<V> {
        self.back(self.len.checked_sub(i + 1)?)
    }

    /// The vertex `k` places before the last one: `back(0)` is the last vertex.
    #[inline(always)]
    pub fn back(&self, k: usize) -> Option<V> {
        self.lent(k, &mut None).copied()
    }

    /// The last vertices, the last one first, as [`PathView::back`] tells them: each where it lies, so that nothing is
    /// copied, or in `copies` if it is not at hand.
    #[inline(always)]
    pub fn lend<'c, const N: usize>(&self, copies: &'c mut [Option<V>; N]) -> [Option<&'c V>; N]
    where
        'p: 'c,
    {
        let mut lent = [None; N];
        for (k, (lent, copy)) in lent.iter_mut().zip(copies).enumerate() {
            *lent = self.lent(k, copy);
        }
        lent
    }

    /// The vertex `k` places before the last one where it lies, or in `copy` if it is not at hand.
    #[inline(always)]
    fn lent<'c>(&self, k: usize, copy: &'c mut Option<V>) -> Option<&'c V>
    where
        'p: 'c,
    {
        match self.recent.get(k) {
            Some(Some(vertex)) => Some(*vertex),
            _ if self.is_at_hand() || k >= self.len - self.hidden => None,
            _ => {
                *copy = self.vertex_elsewhere(k);
                copy.as_ref()
            }
        }
    }

    /// Whether all that is read is at hand. A view of which the compiler knows it does not have to lie in memory.
    #[inline(always)]
    const fn is_at_hand(&self) -> bool {
        matches!(self.source, Source::Drawn(_) | Source::Window(..))
    }

    /// The vertex `k` places before the last one, if it is not at hand.
    #[inline(never)]
    fn vertex_elsewhere(&self, k: usize) -> Option<V> {
        let i = self.offset + self.len - 1 - k;
        match self.source {
            Source::Slice(vertices) => vertices.get(i).copied(),
            Source::Tape(tape, place) => tape.vertex(place.at(i)),
            Source::Unfolded(tape, place) => tape.at_hand(place.at(i)).copied(),
            Source::Drawn(_) | Source::Window(..) => None,
        }
    }

    /// The last vertex: the one that the path continues from.
    #[inline(always)]
    pub fn last(&self) -> Option<V> {
        self.back(0)
    }

    /// Which kind of value a density is asked for: `None` for a density, else the probability of a
    /// discrete mass of this kind. It is the record of how the path was made.
    #[inline(always)]
    pub fn dirac(&self) -> Option<Dirac> {
        self.dirac
    }

    /// Whether vertex `i` is known to see vertex `i - 1`, because one was found from the other by a
    /// ray cast.
    #[inline(always)]
    pub fn visible(&self, i: usize) -> bool {
        if i == 0 || i >= self.len {
            return false;
        }
        let (k, i) = (self.len - 1 - i, self.offset + i);
        match self.source {
            Source::Slice(_) => false,
            Source::Tape(tape, place) => tape.unfolded().visible(place, i),
            Source::Unfolded(tape, place) => tape.visible(place, i),
            Source::Drawn(last) => last.get(k).is_some_and(|last| last.is_some_and(|d| d.visible)),
            Source::Window(window, place, backward) => {
                let place = usize::from(place);
                let edge = if backward { place + k } else { place.wrapping_sub(k + 1) };
                edge < WINDOW && window.sees_next >> edge & 1 == 1
            }
        }
    }

    /// Whether vertex `i` carries this Dirac factor: it lies at a fixed position, or it scatters (or
    /// emits) in a single direction. In an integrand this tells the mirror of a layered material
    /// from its diffuse base.
    #[inline(always)]
    pub fn carries(&self, i: usize, dirac: Dirac) -> bool {
        if i >= self.len {
            return false;
        }
        let on = |tape: &Unfolded<'_, V>, place: Place| {
            tape.carries(place.range(self.offset, place.len as usize), i, dirac)
        };
        match self.source {
            Source::Slice(_) => false,
            // Mostly that is known without a look at any step.
            Source::Tape(tape, _) if dirac == Dirac::Direction && tape.is_undirected() => false,
            Source::Tape(tape, place) => on(&tape.unfolded(), place),
            Source::Unfolded(tape, place) => on(tape, place),
            Source::Drawn(last) => {
                // A position is the vertex's own, a direction belongs to the one that it was drawn from.
                let bearer = match dirac {
                    Dirac::Position => Some(self.len - 1 - i),
                    Dirac::Direction => (self.len - 1 - i).checked_sub(1),
                };
                let drawn = bearer.and_then(|k| *last.get(k)?);
                drawn.is_some_and(|drawn| drawn.dirac == Some(dirac))
            }
            Source::Window(window, place, backward) => {
                let (place, k) = (usize::from(place), self.len - 1 - i);
                let place = if backward { place + k } else { place.wrapping_sub(k) };
                dirac == Dirac::Position && place < WINDOW && window.fixed >> place & 1 == 1
            }
        }
    }
}

#[cfg(test)]
mod tests;
