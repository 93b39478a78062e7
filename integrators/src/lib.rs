//! Light transport algorithms composed from Aether strategies, and what the `aether` renderer
//! needs around them.

pub mod cli;
pub mod image;
pub mod integrand;
pub mod path;
pub mod render;
pub mod samplers;
pub mod scene;
pub mod strategies;
pub mod vertex;
pub mod world;
