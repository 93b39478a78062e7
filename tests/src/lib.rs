//! What the tests share: the catalogue of samplers, and its reference values.

#![warn(missing_docs)]

pub mod catalogue;
pub mod checks;
pub mod compare;
pub mod errors;
pub mod forward;
pub mod fuzz;
pub mod leaks;
pub mod mutation;
pub mod points;
pub mod precise;
pub mod programs;
pub mod reference;
pub mod registry;
pub mod stability;
pub mod textbook;
pub mod twins;

/// The front page: its examples are tests.
#[cfg(doctest)]
#[doc = include_str!("../../README.md")]
pub struct Readme;
