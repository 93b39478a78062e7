//! Strategies that yield several vertices with one draw.

#[path = "../oracle/mod.rs"]
mod oracle;
#[path = "../world/mod.rs"]
mod world;

mod algebra;
mod chain;
mod eight;
mod portal;
