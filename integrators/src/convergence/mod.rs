//! Error against time and samples: which integrator gets to which error in which time, and whether it
//! converges to the right image.
//!
//! - [`measure`]: renders with growing numbers of samples and several seeds, against a [`reference`](mod@reference);
//! - [`record`]: the tables in which that is kept, `errors.csv` and `estimates.csv`;
//! - [`bias`]: variance and bias from the images of several seeds;
//! - [`summary`]: curves, slopes, efficiencies; [`findings`]: what is strange about them, in words;
//! - [`chart`], [`page`], [`table`]: the same as SVG, HTML and Markdown; [`report`] joins several directories;
//! - [`picture`]: error images and crops for figures;
//! - [`adapter`]: images of other renderers.
//!
//! A report is a function of the tables and pictures in the directories, and of nothing else. The error is that of
//! [`compare`](mod@crate::image::compare) everywhere.

pub mod adapter;
pub mod bias;
pub mod chart;
pub mod findings;
pub mod measure;
pub mod page;
pub mod picture;
pub mod record;
pub mod reference;
pub mod report;
pub mod statistics;
pub mod summary;
pub mod table;

#[cfg(test)]
mod tests;
