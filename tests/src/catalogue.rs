//! The catalogue of samplers, written as a textbook or a paper prints them.
//!
//! The number behind each name is the row in the reference data `reference/catalogue-e.json` and
//! `reference/catalogue-mh.json`.

mod algebra;
mod direction;
pub mod easy;
mod line;
mod numeric;
mod plane;
mod polygons;
mod space;
pub mod tables;

pub use algebra::*;
pub use direction::*;
pub use easy::*;
pub use line::*;
pub use numeric::*;
pub use plane::*;
pub use polygons::*;
pub use space::*;
