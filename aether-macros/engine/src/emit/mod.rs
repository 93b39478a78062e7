//! From what was derived to Rust code.

pub mod code;
pub mod compose;
mod documentation;
mod interface;
mod item;
mod map;
mod numeric;
mod sampler;

pub use item::Emitter;
