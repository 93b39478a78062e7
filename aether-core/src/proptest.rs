//! Strategies of the crate `proptest` that draw the parameters of samplers and maps from
//! their declared domains. Needs the feature `proptest`.
//!
//! ```
//! use aether_core::prelude::*;
//! use aether_core::proptest::samplers;
//! use proptest::prelude::*;
//!
//! #[sampler(s in 1e-3..=1e3, d in 1e-3..=1e3, where d < 10.0 * s)]
//! fn flight_below(u: [Uniform; 1], s: f64, d: f64) -> f64 {
//!     -((-s * d).exp_m1() * u[0]).ln_1p() / s
//! }
//!
//! proptest!(|(flight in samplers::<FlightBelow>(), u in 0.0..1.0f64)| {
//!     prop_assert!(flight.sample([u]).pdf().value() > 0.0);
//! });
//! ```
//!
//! What is drawn:
//!
//! - a number with a domain, one time in four, is an end of it, the number next to an end, or zero
//!   or one if they lie inside. Else it is uniform, or has a uniform logarithm if the domain spans more
//!   than two powers of ten; a domain without an end is drawn from up to a million;
//! - a number without a domain has either sign and a size between 1/8 and 8, as coordinates of vectors
//!   and matrices have;
//! - a direction is uniform on the sphere or one of the axes, a frame any rotation of such a direction,
//!   a surface one of sixteen.
//!
//! Where relations are declared, parameters that violate one are drawn again. A failing case is
//! simplified parameter by parameter: towards one, zero or the end of the domain, then towards numbers
//! of few digits.

mod draw;
mod shrink;

use core::fmt;
use core::marker::PhantomData;

use ::proptest::strategy::{NewTree, Strategy, ValueTree};
use ::proptest::test_runner::TestRunner;

use crate::legal::Legal;
pub use shrink::Case;

/// How often parameters are drawn anew if they violate a relation.
const TRIES: usize = 1000;

/// Legal parameters of `S`, as the numbers that [`Legal::from_parameters`] takes.
pub fn parameters<S: Legal>() -> Parameters<S> {
    Parameters(PhantomData)
}

/// Samplers or maps of type `S` with legal parameters.
pub fn samplers<S: Legal + fmt::Debug>() -> Samplers<S> {
    Samplers(PhantomData)
}

/// The strategy that [`parameters`] makes.
pub struct Parameters<S>(PhantomData<fn() -> S>);

/// The strategy that [`samplers`] makes.
pub struct Samplers<S>(PhantomData<fn() -> S>);

macro_rules! plain {
    ($($name:ident)*) => {$(
        impl<S> Clone for $name<S> {
            fn clone(&self) -> Self {
                *self
            }
        }
        impl<S> Copy for $name<S> {}
        impl<S: Legal> fmt::Debug for $name<S> {
            fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                write!(f, "{}({})", stringify!($name), S::ITEM)
            }
        }
    )*};
}
plain!(Parameters Samplers);

impl<S: Legal> Strategy for Parameters<S> {
    type Tree = Case<S>;
    type Value = Vec<S::Real>;

    /// # Errors
    /// If hardly any parameters satisfy the declared relations.
    fn new_tree(&self, runner: &mut TestRunner) -> NewTree<Self> {
        let mut refused = String::new();
        for _ in 0..TRIES {
            let groups: Vec<Vec<S::Real>> =
                S::PARAMETERS.iter().map(|p| draw::parameter(p, runner.rng())).collect();
            match S::from_parameters(&groups.concat()) {
                Ok(_) => return Ok(Case::new(groups)),
                Err(error) => refused = error.to_string(),
            }
        }
        Err(format!(
            "{TRIES} times in a row, parameters drawn from the domains of `{}` violate a relation; the \
             last time: {refused}. Declare domains in which the relations `{}` mostly hold",
            S::ITEM,
            S::RELATIONS.join("`, `"),
        )
        .into())
    }
}

impl<S: Legal + fmt::Debug> Strategy for Samplers<S> {
    type Tree = Made<S>;
    type Value = S;

    /// # Errors
    /// If hardly any parameters satisfy the declared relations.
    fn new_tree(&self, runner: &mut TestRunner) -> NewTree<Self> {
        Ok(Made(parameters::<S>().new_tree(runner)?))
    }
}

/// A sampler or map, with simpler ones to try if a test fails.
#[derive(Debug)]
pub struct Made<S: Legal>(Case<S>);

impl<S: Legal + fmt::Debug> ValueTree for Made<S> {
    type Value = S;

    fn current(&self) -> S {
        match S::from_parameters(&self.0.current()) {
            Ok(item) => item,
            Err(error) => unreachable!("a case has legal parameters: {error}"),
        }
    }
    fn simplify(&mut self) -> bool {
        self.0.simplify()
    }
    fn complicate(&mut self) -> bool {
        self.0.complicate()
    }
}
