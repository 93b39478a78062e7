//! What the tests share: the catalogue of samplers, and its reference values.

pub mod catalogue;
