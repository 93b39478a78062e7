//! From what was derived to Rust code.

pub mod code;
pub mod compose;
mod documentation;
mod interface;
mod item;
mod map;
mod numeric;
mod own;
mod pieces;
mod sampler;

pub use documentation::Texts;
pub use item::Emitter;
