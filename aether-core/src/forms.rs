//! The special forms of the body of a `#[strategy]`.
//!
//! The attribute replaces each by sampling code and by density code, so none of these functions is
//! ever called; they exist so that the body type-checks, completes and is documented as the ordinary
//! Rust that it is. Each stands alone on the right of a `let` (`stop` also as the end of a block).
//! Their names are reserved in such a body, which needs no import for them.

pub mod emitted;

use crate::discrete::Discrete;
use crate::real::{Real, Scalar};
use crate::sampler::Sampler;

/// `let item = choose(distribution);` is a discrete choice: the density sums over its outcomes.
///
/// `choose(distribution).identified_by(|v: &Vertex| index)` tells from a vertex which outcome it
/// must have come from (`None`: from none), so that the density looks at that one only. Outcomes
/// that yield atoms need it, because atoms are never told apart by comparing coordinates.
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
pub fn choose_identified<'a, V, R: Scalar, D: Discrete<R> + 'a>(
    distribution: D,
    index: impl Fn(&V) -> Option<usize>,
) -> D::Item<'a> {
    let _ = (distribution, index);
    outside("choose")
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
/// vertex, through [`Recall`](crate::strategy::Recall).
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
