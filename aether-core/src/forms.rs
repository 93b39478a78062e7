//! The special forms of the body of a `#[strategy]`.
//!
//! The attribute replaces each by sampling code and by density code, so none of these functions is
//! ever called; they exist so that the body type-checks, completes and is documented as the ordinary
//! Rust that it is. Each stands alone on the right of a `let` (`stop` and `delegate`
//! at the end of a block). Their names are reserved in such a body, which needs no import for them.

pub mod emitted;

use crate::discrete::Discrete;
use crate::point::Point;
use crate::real::{Real, Scalar};
use crate::sampler::Sampler;
use crate::strategy::{Strategy, Vertex};

/// `let item = choose(distribution);` is a discrete choice: the density sums over its outcomes.
///
/// Outcomes of probability zero are skipped: nothing that follows them is evaluated.
///
/// `choose(distribution).identified_by(|v: &Vertex| index)` tells from a vertex which outcome it
/// must have come from (`None`: from none), so that the density looks at that one only. If several
/// outcomes are possible the rule yields them all, each once, as any `IntoIterator` of indices. In a
/// strategy of several vertices it is given all of them, `|run: &[Vertex; 2]|`.
/// Outcomes that yield atoms need a rule, because atoms are never told apart by comparing
/// coordinates.
///
/// The probabilities may depend on what was drawn before (a Fresnel coefficient at a sampled half
/// vector), but not the outcomes: `distribution` is then a [`coin`](crate::discrete::coin) or the
/// [`shares`](crate::discrete::shares) of some weights. The density inverts under each outcome first,
/// and evaluates its probability at the recovered point:
///
/// ```
/// use aether_core::prelude::*;
/// use aether_core::strategy::{Strategy, Vertex};
/// use aether_core::{PathView, coin};
///
/// #[derive(Clone, Copy, Debug)]
/// struct Spot(f64);
/// impl Vertex for Spot {
///     type Real = f64;
///     type Point = f64;
///     fn point(&self) -> f64 {
///         self.0
///     }
/// }
///
/// /// Uniform on [a, a + 1).
/// #[sampler]
/// fn unit_interval(u: [Uniform; 1], a: f64) -> f64 {
///     a + u[0]
/// }
///
/// /// Shifts to the right by two.
/// #[map]
/// fn to_the_right(x: f64) -> f64 {
///     x + 2.0
/// }
///
/// #[strategy]
/// fn scatter(path: &PathView<Spot>) -> Spot {
///     let x = draw(unit_interval(0.0));
///     let goes_on = choose(coin(x * x));
///     if goes_on { Spot(to_the_right().apply(&x)) } else { Spot(x) }
/// }
///
/// let p = |x| scatter().pdf(PathView::from_slice(&[]), &Spot(x)).value;
/// assert!((p(0.5) - 0.75).abs() < 1e-15 && (p(2.5) - 0.25).abs() < 1e-15);
/// ```
///
/// # Panics
/// Outside the body of a `#[strategy]`.
pub fn choose<'a, R: Scalar, D: Discrete<R> + 'a>(distribution: D) -> D::Item<'a> {
    let _ = distribution;
    outside("choose")
}

/// What [`choose`] with `.identified_by(..)` stands for.
///
/// # Panics
/// Outside the body of a `#[strategy]`.
pub fn choose_identified<'a, V, R: Scalar, D: Discrete<R> + 'a, I: IntoIterator<Item = usize>>(
    distribution: D,
    index: impl Fn(&V) -> I,
) -> D::Item<'a> {
    let _ = (distribution, index);
    outside("choose")
}

/// `let w = atom(direction, measure);` is a direction that nothing is drawn for, of a mirror say. The
/// vertex is made from `w` or from maps of it, as with [`draw`], and is an atom
/// ([`Dirac::Direction`](crate::strategy::Dirac::Direction)).
///
/// Techniques that come to the mirror from opposite sides state its atom in directions on opposite
/// sides of it, and their densities compare only if both mean the same measure. `measure` is that
/// measure per solid angle in this direction: for light the cosine times the square of the index of
/// refraction there, which a refraction keeps (Veach 1997, section 5.2). The maps that follow divide by
/// their changes of measure, so the value of an atom is its probability, stated per area of the surface
/// where the direction leads; the integrand states its coefficient likewise.
///
/// # Panics
/// Outside the body of a `#[strategy]`.
pub fn atom<R: Real, P: Point<R>>(direction: P, measure: R) -> P {
    let _ = (direction, measure);
    outside("atom")
}

/// `let w = draw(sampler);` draws a continuous random variable: `w` is its value. The vertex is made
/// from `w` itself or from maps of it, `map.apply(&w)`.
///
/// # Panics
/// Outside the body of a `#[strategy]`.
pub fn draw<R: Real, S: Sampler<R>>(sampler: S) -> S::Point {
    let _ = sampler;
    outside("draw")
}

/// `let hit = constant(call);` is a locally constant call, such as a ray cast: `None` means that
/// there is no next vertex. A density does not repeat the call but reads the value back from the
/// vertex, through [`Recall`](crate::strategy::Recall); in a strategy of several vertices, from the one
/// that is made from it. Only for an atom that no ray is cast for it does both, and if the type knows equality
/// (`PartialEq`), the vertex is that atom only if the values are equal.
///
/// # Panics
/// Outside the body of a `#[strategy]`.
pub fn constant<T>(call: Option<T>) -> T {
    let _ = call;
    outside("constant")
}

/// `let here = given(path.last());` is a deterministic value that may be missing: `None` means that
/// there is no next vertex. It must not depend on what was drawn.
///
/// # Panics
/// Outside the body of a `#[strategy]`.
pub fn given<T>(value: Option<T>) -> T {
    let _ = value;
    outside("given")
}

/// `delegate(strategy)` at the end of the body, or of a branch of it, is the vertex that another
/// strategy yields for the same path, so that strategies are made of others. The density adds up
/// theirs, weighted with the probabilities of the choices that lead to each.
///
/// If two of the strategies of a choice may yield atoms of the same kind, it needs
/// `.identified_by(..)` like any other choice between atoms:
///
/// ```compile_fail
/// # use aether_core::prelude::*;
/// # use aether_core::strategy::{Recall, Strategy, Vertex};
/// # use aether_core::{PathView, coin};
/// # #[derive(Clone, Copy, Debug)]
/// # struct Spot(f64);
/// # impl Vertex for Spot {
/// #     type Real = f64;
/// #     type Point = f64;
/// #     fn point(&self) -> f64 {
/// #         self.0
/// #     }
/// # }
/// # impl Recall<i32> for Spot {
/// #     fn recall(&self) -> Option<i32> {
/// #         Some(self.0 as i32)
/// #     }
/// # }
/// #[strategy]
/// fn lamp(path: &PathView<Spot>, place: i32) -> Spot {
///     let found = constant(Some(place));
///     Spot(f64::from(found))
/// }
///
/// #[strategy]
/// fn one_of_two(path: &PathView<Spot>) -> Spot {
///     if choose(coin(0.5)) {
///         delegate(lamp(1))
///     } else {
///         delegate(lamp(2))
///     }
/// }
///
/// one_of_two().pdf(PathView::from_slice(&[]), &Spot(1.0)); // does not compile
/// ```
///
/// The strategy is made from the parameters alone, because what it reads of the path is read here
/// too. Nothing may have been drawn before.
///
/// ```
/// use aether_core::prelude::*;
/// use aether_core::strategy::{Strategy, Vertex};
/// use aether_core::{PathView, coin};
/// # #[derive(Clone, Copy, Debug)]
/// # struct Spot(f64);
/// # impl Vertex for Spot {
/// #     type Real = f64;
/// #     type Point = f64;
/// #     fn point(&self) -> f64 {
/// #         self.0
/// #     }
/// # }
/// # #[sampler]
/// # fn unit_interval(u: [Uniform; 1], a: f64) -> f64 {
/// #     a + u[0]
/// # }
///
/// #[strategy]
/// fn anywhere_in(path: &PathView<Spot>, start: f64) -> Spot {
///     let x = draw(unit_interval(start));
///     Spot(x)
/// }
///
/// /// One-sample multiple importance sampling is just a choice.
/// #[strategy]
/// fn mixed(path: &PathView<Spot>, left: f64) -> Spot {
///     if choose(coin(left)) {
///         delegate(anywhere_in(0.0))
///     } else {
///         delegate(anywhere_in(0.5))
///     }
/// }
///
/// let p = |x| mixed(0.25).pdf(PathView::from_slice(&[]), &Spot(x)).value;
/// assert_eq!((p(0.25), p(0.75), p(1.25)), (0.25, 1.0, 0.75));
/// ```
///
/// # Panics
/// Outside the body of a `#[strategy]`.
pub fn delegate<V: Vertex, S: Strategy<V>>(strategy: S) -> V {
    let _ = strategy;
    outside("delegate")
}

/// `return stop();` ends the path here: there is no next vertex.
///
/// # Panics
/// Outside the body of a `#[strategy]`.
pub fn stop() -> ! {
    outside("stop")
}

fn outside(form: &str) -> ! {
    panic!("`{form}` has a meaning only in the body of a #[strategy] function")
}

/// `let k = precomputed(code);` in the body of a sampler or a map is a number computed once by plain
/// Rust code from the parameters, in `f64`, when the item is constructed: constant near every sample.
pub fn precomputed(value: f64) -> f64 {
    value
}

/// `require(t > 0.0);` in the body of a sampler or a map: where it does not hold, the map has no
/// result, and its density is not reached from there.
pub fn require(holds: bool) {
    let _ = holds;
}
