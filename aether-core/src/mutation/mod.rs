//! Markov chains of paths: mutations and their conditional densities (Aether 2017, section 5.7).
//!
//! A mutation says how a new path, the proposal, is made from the current one, in the terms in which
//! paths are made anyway: it makes discrete choices, cuts the current path into pieces that it
//! keeps, appends strategies to them and joins them. Its conditional density is derived:
//! [`conditional_pdf`] runs the mutation for every combination of outcomes of its choices, and sums
//! up the probability of the outcomes times the densities of the new vertices. With it
//! [`accept_probability`] makes a Metropolis-Hastings chain of any mutation, and
//! [`MarkovChainState::step`] runs it.
//!
//! # What is kept is an atom
//!
//! A kept vertex arises with a probability, not with a density. Kept vertices are known by their
//! identity in the arena, never by their coordinates: two paths of an arena have a vertex in common
//! only if one was made from the other. Given paths with vertices in common, only those choices
//! count that keep all of them: any other would have to hit one of them by chance, which is
//! infinitely less likely. No vertex is kept twice. A proposal that draws a vertex anew where the old
//! one was is another proposal than the one that keeps it, also where both look alike, and each is
//! balanced against its own way back. So the chain is right for atoms (a pinhole, a mirror, paths on a
//! grid) too.
//!
//! Dirac factors cancel like against like. A vertex keeps its factor while it keeps both neighbours;
//! where a neighbour is new, the factor must have been drawn together with it. If `to` carries a
//! factor that the mutation can neither keep nor draw, the density is zero.
//!
//! # What a mutation may look at
//!
//! A mutation is a pure function of the vertices and Dirac factors of the current path and of its
//! choices. It must not ask which strategies made the current path, nor draw random numbers other
//! than through [`Decisions`], since the density of the way back would not know of it.
//!
//! # Example
//!
//! Points of the line, distributed as a tent: paths of two vertices, the second of which is moved a
//! bit or, now and then, drawn anew.
//!
//! ```
//! use aether_core::prelude::*;
//! use aether_core::mutation::mutation;
//! use aether_core::strategy::Vertex;
//! use aether_core::{Arena, MarkovChainState, PathView, Pcg32, RandomSequence, strategies};
//!
//! #[derive(Clone, Copy, Debug)]
//! struct Spot(f64);
//! impl Vertex for Spot {
//!     type Real = f64;
//!     type Point = f64;
//!     fn point(&self) -> f64 {
//!         self.0
//!     }
//! }
//!
//! #[sampler(radius in 1e-3..=1.0)]
//! fn around(u: [Uniform; 1], centre: f64, radius: f64) -> f64 {
//!     centre + radius * (2.0 * u[0] - 1.0)
//! }
//!
//! /// Anywhere in [-1, 1].
//! #[strategy]
//! fn anywhere(_path: PathView<'_, Spot>) -> Spot {
//!     let interval = given(around(0.0, 1.0).ok());
//!     let x = draw(interval);
//!     Spot(x)
//! }
//!
//! /// Not far from where the vertex has been.
//! #[strategy]
//! fn nearby(_path: PathView<'_, Spot>, old: Spot) -> Spot {
//!     let interval = given(around(old.0, 0.2).ok());
//!     let x = draw(interval);
//!     Spot(x)
//! }
//!
//! strategies! {
//!     #[derive(Clone)]
//!     enum Ways for Spot { Anywhere(Anywhere), Nearby(Nearby) }
//! }
//!
//! let moved = mutation(|path: &RandomSequence<'_, Spot, Ways>, decide| {
//!     let mut proposal = path.slice(0..1).keep();
//!     if decide.weighted(2, |i| [4.0, 1.0][i])? == 0 {
//!         proposal.append(nearby(path.vertex(1)?));
//!     } else {
//!         proposal.append(anywhere());
//!     }
//!     Some(proposal)
//! });
//! let tent = |path: &RandomSequence<'_, Spot, Ways>| {
//!     let x = path.last().map_or(1.0, |spot| spot.0);
//!     (1.0 - x.abs(), x)
//! };
//!
//! let mut arena = Arena::new();
//! let mut path = arena.sequence();
//! path.append(anywhere()).append(anywhere()).sample(&mut Pcg32::new(1, 0, 0));
//! let mut chain = MarkovChainState::new(&path, &tent);
//! let mut near = 0.0;
//! for _ in 0..20_000 {
//!     let step = chain.step(&mut arena, &moved, &tent, |step| Pcg32::new(1, 1, step));
//!     // Both the current path and the proposal count, as much as they are likely to be next.
//!     near += step.weighted().map(|(x, weight)| if x.abs() < 0.5 { weight } else { 0.0 }).sum::<f64>();
//! }
//! assert!((near / 20_000.0 - 0.75).abs() < 0.03);
//! ```

mod accept;
mod decisions;
mod draft;
mod origin;
mod set;
mod state;

pub use accept::{Rated, accept_probability};
pub use decisions::{Decisions, Purpose};
pub use draft::Draft;
pub use set::{Mutations, Selected};
pub use state::{MarkovChainState, Transition};

use crate::path_density::PathDensity;
use crate::sequence::{Borrowed, RandomSequence};
use crate::strategy::{Strategy, Vertex};
use crate::uniform::UniformSource;
use decisions::{Decided, advance};
use draft::DECISIONS;
use origin::Origin;

/// How a path is changed: a pure function of the current path and of discrete choices. Closures and
/// functions with the arguments of [`Mutation::propose`] are mutations; see [`mutation`].
pub trait Mutation<V: Vertex, S: Strategy<V>> {
    /// The proposal, with its new vertices still to be drawn. `None` if this mutation has none for
    /// the current path and the choices made: the chain then stays where it is.
    fn propose<'a>(
        &self,
        current: &RandomSequence<'a, V, S>,
        decide: &mut Decisions<'_, V::Real>,
    ) -> Option<Draft<'a, V, S>>;

    /// How often [`Mutations`] selects this mutation at a path, relative to the others: zero where
    /// it is of no use.
    fn weight(&self, current: &RandomSequence<'_, V, S>) -> V::Real {
        let _ = current;
        crate::real::Real::ONE
    }
}

impl<V, S, F> Mutation<V, S> for F
where
    V: Vertex,
    S: Strategy<V>,
    F: for<'a> Fn(
        &RandomSequence<'a, V, S>,
        &mut Decisions<'_, V::Real>,
    ) -> Option<Draft<'a, V, S>>,
{
    fn propose<'a>(
        &self,
        current: &RandomSequence<'a, V, S>,
        decide: &mut Decisions<'_, V::Real>,
    ) -> Option<Draft<'a, V, S>> {
        self(current, decide)
    }
}

/// The closure that it is given, which the compiler would otherwise not know to be a mutation.
pub fn mutation<V, S, F>(propose: F) -> F
where
    V: Vertex,
    S: Strategy<V>,
    F: for<'a> Fn(
        &RandomSequence<'a, V, S>,
        &mut Decisions<'_, V::Real>,
    ) -> Option<Draft<'a, V, S>>,
{
    propose
}

/// Draws a proposal. `None` if there is none: the current path is not complete, the mutation does
/// not apply, or a strategy yielded no vertex.
///
/// Its vertices draw from blocks of sampling dimensions of their own, by their position in the
/// proposal: a source must not be used for a second proposal unless it ignores
/// [`UniformSource::start`].
pub fn propose<'a, V, S, M, U>(
    mutation: &M,
    current: &RandomSequence<'a, V, S>,
    uniforms: &mut U,
) -> Option<RandomSequence<'a, V, S>>
where
    V: Vertex,
    S: Strategy<V>,
    M: Mutation<V, S> + ?Sized,
    U: UniformSource<V::Real> + ?Sized,
{
    let origin = Origin::new(current)?;
    uniforms.start(DECISIONS);
    let draft = mutation.propose(current, &mut Decisions::draw(&mut Borrowed(uniforms)))?;
    draft.draw(&origin, uniforms)
}

/// The density with which a mutation makes `to` of `from`: with respect to the product of the
/// measures of the new vertices, for the Dirac factors of `to`, and for the vertices kept that the
/// two have in common (see the [module](self)). Marginalised over the choices of the mutation, and
/// including the probability of making no proposal at all.
///
/// The probabilities of all choices are those at `from`. Zero if the mutation cannot make `to`, and
/// for paths that are not complete or of different arenas.
///
/// It takes one run of the mutation for each combination of outcomes; a mutation that asks for its
/// [`Purpose`] cuts that down.
pub fn conditional_pdf<'a, V, S, M>(
    mutation: &M,
    from: &RandomSequence<'a, V, S>,
    to: &RandomSequence<'a, V, S>,
) -> PathDensity<V::Real>
where
    V: Vertex,
    S: Strategy<V>,
    M: Mutation<V, S> + ?Sized,
{
    let (Some(origin), true) = (Origin::new(from), to.is_complete()) else {
        return PathDensity::ZERO;
    };
    if !core::ptr::eq(from.arena, to.arena) {
        return PathDensity::ZERO;
    }
    // A mutation may itself ask for densities: what is at work is not in the arena meanwhile.
    let mut replay = core::mem::take(&mut *from.arena.replay.borrow_mut());
    let Replay { decided, in_common } = &mut replay;
    decided.clear();
    let mut sum = PathDensity::ZERO;
    let to = to.handle.place;
    let wanted = origin.wanted(to, in_common);
    let mut has_turn = !wanted.repeats(in_common);
    while has_turn {
        let mut decide = Decisions::replay(decided, wanted);
        let draft = mutation.propose(from, &mut decide).and_then(|draft| draft.place());
        let probability = decide.finish();
        if let Some(draft) = draft.filter(|_| !probability.is_zero()) {
            sum = sum + probability * origin.density(draft, to, in_common);
        }
        // The draft is nowhere else: what a mutation is given outlives nothing that it could be kept in.
        from.arena.tape.truncate(origin.steps);
        has_turn = advance(decided);
    }
    *from.arena.replay.borrow_mut() = replay;
    sum
}

/// Memory of an evaluation.
#[derive(Debug)]
pub(crate) struct Replay<R> {
    /// Which outcomes of the choices have their turn.
    decided: Vec<Decided<R>>,
    /// Which vertices of the path in question the current path has, too; or, while a proposal is drawn, which of the current path
    /// it keeps.
    in_common: Vec<bool>,
}

impl<R> Default for Replay<R> {
    fn default() -> Self {
        Replay { decided: Vec::new(), in_common: Vec::new() }
    }
}

/// By how much a mutation that shifts `from` to `to` stretches the space of paths there: |∂to/∂from|
/// as the ratio of its conditional densities (Aether 2017, Eq. 7). That is right for mutations which
/// draw what the shift depends on (by how many pixels it goes) with equal density on the way there
/// and on the way back.
///
/// Zero if the shift is not invertible: if it cannot lead there or cannot lead back.
pub fn shift_jacobian<'a, V, S, M>(
    shift: &M,
    from: &RandomSequence<'a, V, S>,
    to: &RandomSequence<'a, V, S>,
) -> V::Real
where
    V: Vertex,
    S: Strategy<V>,
    M: Mutation<V, S> + ?Sized,
{
    let there = conditional_pdf(shift, from, to);
    let back = conditional_pdf(shift, to, from);
    if there.is_regular() && back.is_regular() {
        back.ratio(there)
    } else {
        crate::real::Real::ZERO
    }
}
