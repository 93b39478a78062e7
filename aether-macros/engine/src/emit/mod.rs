//! From what was derived to Rust code.

pub mod code;
pub mod compose;
mod documentation;
mod interface;
mod item;
mod numeric;
mod map;
mod sampler;

pub use item::Emitter;
