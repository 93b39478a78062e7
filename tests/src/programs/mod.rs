//! Random samplers, as Rust source: programs that somebody could have written, made by proptest.
//!
//! A [`Plan`] is what proptest composes: a list of steps (affine, polar, power, exponential,
//! normalise, rotate, reflect, branch, fold) from the uniforms to a point of some space. [`write()`]
//! turns it into a function; it knows the range of every coordinate, so that what it writes is defined almost
//! everywhere, depends on every uniform, and has full rank. [`suite`] has the programs of the
//! test, and [`file()`] their source.

mod choose;
mod plan;
mod range;
mod scalar;
mod scribe;
mod spread;

pub use choose::{CORE, WIDE, file, plans, refusal, suite};
pub use plan::{Finish, Plan, Step, plan};
pub use range::Range;
pub use scribe::{Program, write};
