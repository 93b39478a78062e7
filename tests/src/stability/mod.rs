//! How far samples, inverses and densities are from the exact ones, in stiff and extreme cases.
//!
//! The exact values come from the forward map alone: it runs on numbers of 31 digits with derivatives
//! ([`crate::precise`]), and the density is the sum of 1 / √det(JᵀJ) over the preimages. Which other
//! preimages there are is asked of the sampler, in 31 digits too.
//!
//! Errors are in units of the spacing of numbers next to one: 2⁻⁵² of the value, or 2⁻²³ for `f32`. The
//! error of a sample is that of the vector. Below the smallest normal number errors are absolute. A
//! condition number is what moving each input by half a unit may cost, in units; the density of a sample has that
//! of its coordinates or that of its uniforms, whichever is larger.

mod beside;
mod conditions;
mod few;
mod judge;
mod lazy;
mod measure;
mod oracle;
mod peers;
mod places;
mod probe;
mod random;
mod reasons;
pub mod report;
mod run;
pub mod stored;
mod tally;

pub use beside::beside;
pub use conditions::{Conditions, Differences, Source, Spot};
pub use few::Few;
pub use measure::{Row, Settings};
pub use oracle::{Exact, Format, exact};
pub use peers::{PeerPoint, peer_points};
pub use places::{next_to_ends, over, swept};
pub use probe::{Answer, Question, ask};
pub use reasons::{REASONS, reason};
pub use run::{on_all_threads, run};
pub use tally::Tally;
