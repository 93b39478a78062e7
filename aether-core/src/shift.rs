//! Shifts: invertible maps of paths to similar ones, one vertex after the other (Kettunen et al. 2015; Aether
//! 2017, section 7.5).
//!
//! A shift says of each vertex whether the shifted path keeps it, or which strategy makes another one in its place,
//! about what is copied of the *base* path: the middle of that strategy's uniforms is the new vertex. The shift back
//! is asked in the same words, and must find such a strategy too. So the change of measure |∂path/∂base| is the
//! ratio of two conditional densities (Aether 2017, Eq. 7), which are derived, and what no way leads back from has no
//! shifted path.

use crate::combine::Shifted;
use crate::real::Real;
use crate::sequence::{PathView, RandomSequence};
use crate::strategy::{Dirac, Reads, Strategy, Vertex};
use crate::uniform::Middle;

/// How many vertices before the one in question a shift reads at most for no paths to be made of what it shifts.
pub const AT_HAND: usize = 2;

/// A vertex of a base path that is to be shifted, with what is before it on both paths.
#[derive(Clone, Copy, Debug)]
pub struct Turn<'p, V: Vertex> {
    /// The base path up to the vertex.
    pub base: PathView<'p, V>,
    /// The shifted path up to the vertex before.
    pub shifted: PathView<'p, V>,
    /// Whether the base path ends here.
    pub ends: bool,
    /// Whether the base path goes on from here in a single direction, as at a mirror.
    pub directed: bool,
}

impl<'p, V: Vertex> Turn<'p, V> {
    /// With as much of both paths as the shift reads.
    #[inline(always)]
    pub(crate) fn new<S, M: Shift<V, S>>(
        shift: &M,
        (base, shifted): (PathView<'p, V>, PathView<'p, V>),
        (ends, directed): (bool, bool),
    ) -> Self {
        let shown = |vertices: usize| Reads { vertices, length: true };
        let vertices = shift.reads();
        let (base, shifted) = (base.limited(shown(vertices + 1)), shifted.limited(shown(vertices)));
        Turn { base, shifted, ends, directed }
    }

    /// Whether the base path goes on to or from here in a single direction: then the vertex is not one to keep where
    /// the vertices before differ.
    #[inline(always)]
    pub(crate) fn is_bound(&self) -> bool {
        self.directed || self.base.carries(self.shifted.len().wrapping_sub(1), Dirac::Direction)
    }
}

/// What a shift makes of a vertex.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Moved<S> {
    /// It is a vertex of the shifted path too.
    Kept,
    /// Another one takes its place: what this strategy draws in the middle of its uniforms, after the shifted path.
    Copied(S),
    /// There is no shifted path.
    Lost,
}

/// An invertible map of paths.
///
/// Once a vertex is kept after others were not, all that follow are kept, and the shift is not asked of them. A vertex
/// that is kept must be one that the shift back keeps, which sees it with the paths in each other's place. Where the base
/// path comes to or leaves a vertex in a single direction, and the shifted path would come from elsewhere, no vertex
/// is kept: there is no shifted path.
///
/// A shift is a function of what it is told, and may be asked several times of one vertex.
pub trait Shift<V: Vertex, S>: Sized {
    /// The shift back.
    fn inverse(&self) -> Self;

    /// What becomes of the last vertex of the base path.
    fn vertex(&self, turn: &Turn<'_, V>) -> Moved<S>;

    /// The strategy by which shifted paths are sampled at vertex `i`, where it is another one than that of the base
    /// path: aimed at another pixel, say. Only where base paths have a strategy of a single vertex.
    fn technique(&self, i: usize) -> Option<S> {
        let _ = i;
        None
    }

    /// How many vertices before the one in question the shift and its strategies read; it is shown no more.
    fn reads(&self) -> usize {
        AT_HAND
    }
}

impl<'a, V: Vertex, S: Strategy<V>> RandomSequence<'a, V, S> {
    /// What a shift makes of this path; `None` if it has no image, or one that the shift back does not reach.
    ///
    /// `sees` tells whether nothing lies between two vertices: where a path goes on, it is found by rays, so that both
    /// paths must be visible there. Vertices of joint draws have no shifted ones.
    pub fn shifted<M: Shift<V, S>>(
        &self,
        shift: &M,
        sees: impl Fn(&V, &V) -> bool,
    ) -> Option<Shifted<'a, V, S>> {
        let n = self.len();
        if !self.is_complete() {
            return None;
        }
        let mut shifted = Shifted { path: self.slice(0..0), jacobian: V::Real::ONE };
        let mut copied = false;
        for i in 0..n {
            let (base, ends) = (self.slice(0..=i), i + 1 == n);
            let directed = self.view().carries(i, Dirac::Direction);
            let turn = Turn::new(shift, (base.view(), shifted.path.view()), (ends, directed));
            match shift.vertex(&turn) {
                Moved::Kept if copied => {
                    let (last, here) = (shifted.path.last()?, self.vertex(i)?);
                    let seen = || self.sees_next(i - 1, &sees) && sees(&last, &here);
                    if turn.is_bound() || !(ends || seen()) {
                        return None;
                    }
                    shifted.path = shifted.path.concat(&self.slice(i..));
                    break;
                }
                Moved::Kept => shifted.path = base,
                Moved::Copied(there) => {
                    shifted = self.copied(shift, there, (turn, &sees), shifted)?;
                    copied = true;
                }
                Moved::Lost => return None,
            }
        }
        Some(shifted)
    }

    /// A shifted path with one vertex more, which a strategy makes of that of this path.
    fn copied<M: Shift<V, S>>(
        &self,
        shift: &M,
        there: S,
        (turn, sees): (Turn<'_, V>, &impl Fn(&V, &V) -> bool),
        Shifted { mut path, jacobian }: Shifted<'a, V, S>,
    ) -> Option<Shifted<'a, V, S>> {
        let (i, mut way_back) = (path.len(), self.slice(0..path.len()));
        path.append(there).sample(&mut Middle);
        if !path.is_complete() || path.dirac(i) != self.dirac(i) {
            return None;
        }
        let is_seen = |path: &Self| i == 0 || path.sees_next(i - 1, sees);
        // On the way back, a ray would have to find it, and another one where the path goes on.
        let found = !turn.ends || path.view().visible(i);
        if found && !(is_seen(self) && is_seen(&path)) {
            return None;
        }
        let back = Turn::new(shift, (path.view(), way_back.view()), (turn.ends, turn.directed));
        let Moved::Copied(back) = shift.inverse().vertex(&back) else { return None };
        way_back.append(back);
        let back = self.arena.factor(way_back.handle.place, i, self.handle.place);
        let jacobian = jacobian * stretch(back, path.conditional(i)?)?;
        Some(Shifted { path, jacobian })
    }

    /// Whether vertex `i` is known to see the next one, or does.
    pub(crate) fn sees_next(&self, i: usize, sees: &impl Fn(&V, &V) -> bool) -> bool {
        let ends = || self.vertex(i).zip(self.vertex(i + 1));
        self.view().visible(i + 1) || ends().is_some_and(|(here, next)| sees(&here, &next))
    }

    /// The Dirac factor that vertex `i` was drawn with.
    fn dirac(&self, i: usize) -> Option<Dirac> {
        self.arena.tape.step(self.handle.place, i).dirac
    }

    /// How a shift samples the first steps of this path.
    pub(crate) fn as_shifted<M: Shift<V, S>>(&self, shift: &M) -> Self {
        (0..self.size()).fold(*self, |path, i| match shift.technique(i) {
            Some(strategy) => path.replaced(i, strategy),
            None => path,
        })
    }
}

/// By how much a shift stretches, of the densities of what is copied back and there; `None` if one of them is
/// no density.
#[inline(always)]
pub(crate) fn stretch<R: Real + PartialOrd>(back: R, there: R) -> Option<R> {
    let stretch = back / there;
    (stretch > R::ZERO && stretch < R::of(f64::INFINITY)).then_some(stretch)
}
