//! Light transport algorithms composed from Aether strategies, and what the `aether` renderer
//! needs around them.

pub mod cli;
pub mod image;
pub mod render;
pub mod scene;
