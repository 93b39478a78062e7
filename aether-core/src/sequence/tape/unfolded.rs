//! A tape that is being read: what is known of steps and of runs of them, and how steps of two places compare.

use core::cell::Ref;

use super::{Entry, Kept, NONE, Place, Question, Step, Tape, Way};
use crate::sequence::Key;
use crate::strategy::{Dirac, Drawn, Vertex};

/// A tape with its steps and vertices at hand: [`Tape::unfolded`].
#[derive(Debug)]
pub(crate) struct Unfolded<'t, V: Vertex> {
    pub tape: &'t Tape<V>,
    pub(super) entries: Ref<'t, [Entry]>,
    pub(super) vertices: Ref<'t, [Kept<V>]>,
}

impl<V: Vertex> Unfolded<'_, V> {
    /// The vertex of a step, if it has one.
    #[inline(always)]
    pub fn vertex(&self, at: usize) -> Option<V> {
        let id = self.entries.get(at)?.vertex;
        self.vertices.get(id as usize).map(|kept| kept.vertex)
    }

    /// The same where it lies.
    #[inline(always)]
    pub fn at_hand(&self, at: usize) -> Option<&V> {
        let id = self.entries.get(at)?.vertex;
        self.vertices.get(id as usize).map(|kept| &kept.vertex)
    }

    /// The vertex of a step where it lies, whether it is known to see the one that it was made from, and the Dirac factor
    /// that it was drawn with.
    #[inline(always)]
    pub fn kept(&self, at: usize) -> (Option<&V>, bool, Option<Dirac>) {
        let Entry { vertex, visible, dirac, .. } = &self.entries[at];
        (self.vertices.get(*vertex as usize).map(|kept| &kept.vertex), *visible, *dirac)
    }

    /// Vertex `i` of a place as it was drawn, with its density if drawing it told ([`Unfolded::own`]).
    pub fn drawn(&self, place: Place, i: usize) -> Option<Drawn<V>> {
        let (vertex, visible, dirac) = self.kept(place.at(i));
        Some(Drawn { vertex: *vertex?, dirac, visible, value: self.own(place, i) })
    }

    /// The vertex with this id.
    #[inline(always)]
    pub fn vertex_of(&self, id: u32) -> Option<&V> {
        self.vertices.get(id as usize).map(|kept| &kept.vertex)
    }

    /// The steps of a place that is read in the order of the tape.
    #[inline(always)]
    pub fn steps_of_run(&self, place: Place) -> &[Entry] {
        let start = place.at(0);
        &self.entries[start..start + place.len as usize]
    }

    /// What drawing the vertex with this id told of its density.
    #[inline(always)]
    pub fn value_of(&self, id: u32) -> Option<V::Real> {
        self.vertices.get(id as usize)?.value
    }

    /// The id of vertex `i` of a place.
    #[inline(always)]
    pub fn id(&self, place: Place, i: usize) -> u32 {
        self.entries[place.at(i)].vertex
    }

    /// The way of step `i` of a place, as seen from there.
    #[inline(always)]
    pub fn way(&self, place: Place, i: usize) -> Way {
        self.entries[place.at(i)].way.turned(place.reversed)
    }

    /// The block of sampling dimensions of step `i` of a place.
    #[inline]
    pub fn block(&self, place: Place, i: usize) -> u32 {
        self.entries[place.at(i)].block
    }

    /// Whether step `i` of a place is known to see step `i - 1`.
    #[inline]
    pub fn visible(&self, place: Place, i: usize) -> bool {
        let step = |i: usize| Step::new(place.at(i), place.reversed);
        self.sees(step(i), step(i - 1))
    }

    /// Whether the vertex of a step is known to see that of the step before.
    #[inline]
    pub fn sees(&self, step: Step, before: Step) -> bool {
        // A vertex that has been merged was reached from the other side too.
        let reached = |step: Step, backward: bool| {
            let entry = &self.entries[step.at()];
            let way = entry.way.turned(step.is_turned());
            if way.is_backward() == backward { entry.visible } else { way.merger().is_some() }
        };
        reached(step, false) || reached(before, true)
    }

    /// Whether vertex `i` of a place carries a Dirac factor.
    #[inline]
    pub fn carries(&self, place: Place, i: usize, dirac: Dirac) -> bool {
        match dirac {
            Dirac::Position => self.is_drawn_with(place.at(i), dirac),
            Dirac::Direction => !self.tape.is_undirected() && self.leads_on(place, i),
        }
    }

    /// Whether a vertex was drawn with a Dirac factor, which is its own if that is a position.
    #[inline(always)]
    pub fn is_drawn_with(&self, at: usize, dirac: Dirac) -> bool {
        self.entries[at].dirac == Some(dirac)
    }

    /// Whether a neighbour of vertex `i` was made from it in a single direction.
    fn leads_on(&self, place: Place, i: usize) -> bool {
        let made = |i: usize, backward: bool| {
            let step = &self.entries[place.at(i)];
            let way = step.way.turned(place.reversed);
            let dirac = if way.is_backward() == backward {
                step.dirac
            } else {
                way.merger().and_then(|merger| self.tape.merger(merger).dirac)
            };
            dirac == Some(Dirac::Direction)
        };
        (i + 1 < place.len as usize && made(i + 1, false)) || (i > 0 && made(i - 1, true))
    }

    /// Which kind of factor vertex `i` of a place has for a step in the given direction.
    #[inline(always)]
    pub fn kind(&self, place: Place, i: usize, backward: bool) -> Option<Dirac> {
        if self.carries(place, i, Dirac::Position) {
            return Some(Dirac::Position);
        }
        if self.tape.is_undirected() {
            return None;
        }
        let before = if backward { i + 1 } else { i.wrapping_sub(1) };
        let fixed = before < place.len as usize && self.carries(place, before, Dirac::Direction);
        fixed.then_some(Dirac::Direction)
    }

    /// What the density of vertex `k` of a path depends on, under a strategy that comes from one side and reads
    /// so many vertices, three at most; and which kind of density it is.
    #[inline(always)]
    pub fn key(
        &self,
        (path, k): (Place, usize),
        (strategy, backward): (u32, bool),
        reads: usize,
        class: u32,
    ) -> (Option<Dirac>, Key) {
        let dirac = self.kind(path, k, backward);
        let Question { tag, class } = Question::new(strategy, dirac, class);
        let mut key = [tag, self.id(path, k), NONE, NONE, NONE, class];
        let before = if backward { path.len as usize - 1 - k } else { k };
        for (j, part) in key[2..5].iter_mut().enumerate().take(reads.min(before)) {
            *part = self.id(path, if backward { k + 1 + j } else { k - 1 - j });
        }
        (dirac, key)
    }

    /// What drawing a vertex told of its density, if that depends on `key`, in which there is room for so many
    /// vertices that are read.
    #[inline]
    pub fn told(&self, key: &Key, reads: usize) -> Option<V::Real> {
        let kept = self.vertices.get(key[1] as usize)?;
        if kept.question != (Question { tag: key[0], class: key[5] }) {
            return None;
        }
        let before = |j: usize| kept.before(j).map_or(NONE, |at| self.entries[at].vertex);
        if (0..reads).all(|j| key[2 + j] == before(j)) { kept.value } else { None }
    }

    /// The density with which vertex `k` of a place was drawn, if drawing it told: of a step of a run that
    /// the place sees from its origin, before which there are the same vertices as then.
    #[inline(always)]
    pub fn own(&self, place: Place, k: usize) -> Option<V::Real> {
        let entry = &self.entries[place.at(k)];
        let n = place.len as usize;
        let seen = if entry.way.is_backward() == place.reversed { k + 1 } else { n - k };
        if entry.run as usize != seen || entry.way.merger().is_some() {
            return None;
        }
        self.vertices.get(entry.vertex as usize)?.value
    }

    /// The name of the run that ends at step `k`, if it begins where the path does and a draw ends there.
    #[inline]
    pub fn run_name(&self, place: Place, k: usize) -> Option<u32> {
        let entry = &self.entries[place.at(k)];
        let named = entry.way.is_backward() == place.reversed
            && entry.run as usize == k + 1
            && entry.way.part().is_last();
        named.then_some(entry.vertex)
    }

    /// Of a path that is one run, the names of the run without its last draw and of all of it, and the density
    /// of the last vertex, if drawing it told.
    #[inline(always)]
    pub fn last_of_run(&self, place: Place) -> Option<(u32, u32, V::Real)> {
        let before = (place.len as usize).checked_sub(2)?;
        let last = &self.entries[place.at(before + 1)];
        if last.run != place.len
            || last.way.is_backward() != place.reversed
            || last.way.part().is_joint()
        {
            return None;
        }
        let value = self.vertices.get(last.vertex as usize)?.value?;
        Some((self.id(place, before), last.vertex, value))
    }

    /// Whether the first `len` steps are known to be an unbroken run.
    #[inline]
    pub fn is_run(&self, place: Place, len: usize) -> bool {
        len == 0 || {
            let last = &self.entries[place.at(len - 1)];
            last.way.is_backward() == place.reversed && last.run as usize == len
        }
    }

    /// How many steps at the beginning of a path are taken forwards.
    pub fn steps_ahead(&self, place: Place) -> usize {
        let n = place.len as usize;
        if self.is_run(place, n) {
            return n;
        }
        (0..n).position(|k| self.way(place, k).is_backward()).unwrap_or(n)
    }

    /// The range from the first to the last step that two places of one length do not make alike,
    /// whatever the vertices.
    pub fn unlike(&self, a: Place, b: Place) -> (u32, u32) {
        if a == b {
            return (0, 0);
        }
        let turned = a.reversed != b.reversed;
        let steps = |k: usize| (&self.entries[a.at(k)], &self.entries[b.at(k)]);
        let unlike = |k: &usize| {
            let (a, b) = steps(*k);
            a.way != b.way.turned(turned)
        };
        let Some(last) = (0..a.len as usize).rfind(unlike) else { return (0, 0) };
        let mut first = last;
        for k in (0..last).rev() {
            let (step, other) = steps(k);
            if step.way != other.way.turned(turned) {
                first = k;
            } else if step.vertex == other.vertex
                && step.run as usize == k + 1
                && other.run as usize == k + 1
                && step.way.is_backward() == a.reversed
            {
                // Both have all steps up to here from the same run.
                break;
            }
        }
        (first as u32, last as u32 + 1)
    }
}
