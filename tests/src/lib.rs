//! What the tests share: the catalogue of samplers, and its reference values.

#![warn(missing_docs)]

pub mod catalogue;
pub mod errors;
pub mod mutation;
pub mod reference;
pub mod rows;
