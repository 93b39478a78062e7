//! From what was derived to Rust code.

mod atoms;
mod border;
pub mod code;
pub mod compose;
mod documentation;
mod fading;
mod interface;
mod item;
mod jumps;
mod legal;
mod logarithm;
mod map;
mod meeting;
mod numeric;
mod own;
mod paired;
mod parameters;
mod passed;
mod peeled;
mod pieces;
mod plainly;
mod powers;
mod quick;
mod quotient;
mod sampler;
mod seldom;
mod sure;
mod tame;
pub mod text;
mod ways;
mod whole;

pub use documentation::Texts;
pub use item::Emitter;
pub use ways::Ways;
pub use whole::Support;
