//! The compiler behind `aether-core`, as an ordinary library on `proc_macro2` types.

pub mod derivative;
pub mod derive;
pub mod diagnostics;
mod differences;
pub mod display;
pub mod emit;
pub mod eval;
mod expand;
pub mod expr;
mod functions;
pub mod interval;
pub mod jacobian;
pub mod number;
pub mod parse;
pub mod points;
pub mod poly;
pub mod rational;
pub mod solve;
pub mod stabilise;
pub mod strategy;

pub use expand::{map, sampler};
pub use strategy::strategy;
