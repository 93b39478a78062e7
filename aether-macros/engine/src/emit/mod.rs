//! From what was derived to Rust code.

pub mod code;
pub mod compose;
mod documentation;
mod item;
mod map;
mod sampler;

pub use item::Emitter;
