//! Sampling functions with derived inverses, Jacobians and densities.
//!
//! Write how to sample, as a function of uniforms; the attribute [`macro@sampler`] derives a random
//! variable from it:
//!
//! ```
//! use aether_core::prelude::*;
//!
//! /// Free flight through a homogeneous medium.
//! #[sampler(extinction in 1e-3..=1e3)]
//! fn free_flight(u: [Uniform; 1], extinction: f64) -> f64 {
//!     -(-u[0]).ln_1p() / extinction
//! }
//!
//! let flight = free_flight(2.0).expect("2 lies in the declared domain");
//! let t = flight.sample([0.5]);
//! assert!((flight.pdf(&t).value() - 2.0 * (-2.0 * t.value()).exp()).abs() < 1e-15);
//! ```
//!
//! Emitted code names this crate `::aether_core`. A crate that knows it by another name,
//! `ae = { package = "aether-core", … }`, says at its root `extern crate ae as aether_core;`.
//!
//! The [`guide`] explains the language in chapters. Where things are:
//!
//! - random variables: [`sampler`](mod@sampler), [`map`](mod@map), [`pairs`], [`mixture`](mod@mixture),
//!   [`mixed`] (distributions with atoms), [`discrete`](mod@discrete), [`tables`];
//! - steps without a closed form: [`root`];
//! - the spaces that they live in: [`point`], [`density`], [`vec`](mod@vec), [`real`];
//! - eight samples at once: `lanes`, with the feature `wide`;
//! - paths: [`strategy`](mod@strategy) with its special [`forms`], [`sequence`];
//! - functions beyond the elementary ones, such as [`special::erf`]: [`special`];
//! - estimates: [`combine`](mod@combine) (multiple importance sampling), [`estimator`],
//!   [`path_density`];
//! - Markov chains of paths: [`mutation`](mod@mutation);
//! - similar paths next to others, and their differences: [`shift`];
//! - uniform random numbers: [`uniform`];
//! - how much was computed: [`work`];
//! - checks for any sampler, in one line: [`battery`];
//! - which parameters are legal, for generators of tests: [`legal`].
//!
//! This crate knows nothing of rendering.

#![forbid(unsafe_code)]

// Emitted code names this crate by its path, also inside it.
extern crate self as aether_core;

pub mod battery;
pub mod bounded;
pub mod combine;
pub mod density;
pub mod discrete;
pub mod estimator;
pub mod forms;
pub mod guide;
pub mod joint;
// Without lanes only fractions of a turn are computed by them.
#[cfg_attr(
    not(any(feature = "wide", feature = "portable")),
    allow(dead_code, unused_imports, unused_macros)
)]
mod kernels;
#[cfg(feature = "wide")]
pub mod lanes;
pub mod legal;
pub mod map;
pub mod mixed;
pub mod mixture;
pub mod mutation;
pub mod pairs;
pub mod path_density;
pub mod point;
pub mod preimages;
#[cfg(feature = "proptest")]
pub mod proptest;
pub mod real;
pub mod root;
pub mod sampler;
pub mod sequence;
pub mod shift;
pub mod special;
pub mod strategy;
#[doc(hidden)]
pub mod support;
pub mod tables;
pub mod uniform;
pub mod vec;
pub mod work;

pub use aether_macros::{map, sampler, strategy};
pub use combine::{
    BalanceHeuristic, Combine, Heuristic, MaximumHeuristic, PowerHeuristic, combine, combine_with,
};
pub use density::{
    Area, Counting, Density, Hausdorff, Length, Measure, Product, SameMeasure, SolidAngle, Volume,
};
pub use discrete::{
    Bernoulli, Cdf, Choice, Choices, Discrete, Shares, WeightError, coin, discrete,
    discrete_weighted, shares,
};
pub use estimator::{Estimator, PathIntegrand, Value};
#[cfg(feature = "wide")]
pub use lanes::{LaneMask, Lanes};
pub use legal::Legal;
pub use map::{Map, Then};
pub use mixed::{Mixed, WithAtoms};
pub use mixture::{Mixture, mixture};
pub use mutation::{MarkovChainState, Mutation, accept_probability, conditional_pdf, mutation};
pub use path_density::PathDensity;
pub use point::{Curve, Direction, Embedded, Includes, Point, Surface, SurfaceId, SurfacePoint};
pub use preimages::Preimages;
pub use real::{Mask, Real, Scalar, Single};
pub use root::solve;
pub use sampler::{Derivation, DomainError, PdfOf, Sample, Sampler, Uniform, Uniforms};
pub use sequence::{Arena, PathView, RandomSequence, Snapshot};
pub use strategy::{Atoms, Conditional, Dirac, Drawn, DrawnRun, Reads, Recall, Strategy, Vertex};
pub use uniform::{Pcg32, Sobol, UniformSource, draw_uniforms};
pub use vec::{Frame, Mat3, Vec2, Vec3};

/// Everything that a module with samplers in it needs: `use aether_core::prelude::*;`.
pub mod prelude {
    pub use crate::forms::{atom, choose, constant, delegate, draw, given, stop};
    pub use crate::special::{
        beta_inc, beta_inc_inv, erf, erf_inv, erfc, erfc_inv, lambert_w, ln_beta, ln_gamma,
        normal_cdf, normal_quantile,
    };
    pub use crate::{
        Area, Curve, Density, Derivation, Direction, Embedded, Frame, Length, Map, Mat3, Mixed,
        Point, Real, Sample, Sampler, Scalar, SolidAngle, Surface, SurfaceId, SurfacePoint,
        Uniform, Vec2, Vec3, Volume, solve,
    };
    pub use aether_macros::{map, sampler, strategy};
    pub use core::f64::consts::{FRAC_1_PI, FRAC_PI_2, FRAC_PI_4, PI, SQRT_2, TAU};
}
