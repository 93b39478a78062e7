//! Strategies that yield several vertices with one draw.

mod algebra;
mod chain;
mod eight;
mod endings;
mod portal;
