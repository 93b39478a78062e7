//! The compiler behind `aether-core`, as an ordinary library on `proc_macro2` types.
//!
//! [`sampler`] and [`map`] turn the tokens of a function into the tokens of a random variable or a
//! map between spaces; [`strategy()`] does it for a function that samples the next vertex of a path.
//! Data flows in one direction:
//!
//! 1. [`parse`]: the body as expressions of an [`expr::Graph`], a [`derive::Problem`];
//! 2. [`solve`](mod@solve): every preimage of a point;
//! 3. [`jacobian`]: the change of measure √det(JᵀJ), made short by [`poly`];
//! 4. [`derive`](mod@derive): the density, and all of it checked on [`points`] against the forward map
//!    in double-double ([`number`]);
//! 5. [`stabilise`](mod@stabilise): among equal forms, the one with the smaller measured error;
//! 6. [`emit`]: flat Rust code, and the derivation as documentation.
//!
//! Output is a function of the input alone: no clock, no host mathematics, work bounded by counts.

pub mod derivative;
pub mod derive;
pub mod diagnostics;
mod differences;
pub mod display;
pub mod emit;
mod enclosure;
pub mod eval;
mod expand;
pub mod expr;
mod functions;
mod hash;
pub mod interpret;
pub mod interval;
pub mod jacobian;
pub mod matrix;
pub mod measure;
pub mod monotone;
mod multiples;
pub mod number;
mod overflow;
pub mod parse;
pub mod points;
pub mod poly;
pub mod rational;
mod root;
pub mod solve;
mod sorted;
pub mod stabilise;
pub mod strategy;
pub mod turns;
mod walk;

pub use expand::{map, sampler};
pub use strategy::strategy;
