//! From what was derived to Rust code.

pub mod code;
pub mod compose;
mod documentation;
mod interface;
mod item;
mod legal;
mod logarithm;
mod map;
mod numeric;
mod own;
mod pieces;
mod sampler;
pub mod text;

pub use documentation::Texts;
pub use item::Emitter;
