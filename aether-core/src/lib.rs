//! Sampling functions with derived inverses, Jacobians and densities.

#![forbid(unsafe_code)]

// Emitted code names this crate by its path, also inside it.
extern crate self as aether_core;

pub mod bounded;
pub mod combine;
pub mod density;
pub mod estimator;
pub mod forms;
pub mod path_density;
pub mod sequence;
pub mod strategy;
pub mod battery;
pub mod discrete;
pub mod uniform;
pub mod map;
pub mod point;
pub mod preimages;
pub mod real;
pub mod sampler;
pub mod vec;
#[doc(hidden)]
pub mod support;

pub use aether_macros::{map, sampler, strategy};
pub use combine::{
    BalanceHeuristic, Combine, Heuristic, MaximumHeuristic, PowerHeuristic, combine, combine_with,
};
pub use density::{
    Area, Counting, Density, Hausdorff, Length, Measure, Product, SolidAngle, Volume,
};
pub use estimator::{Estimator, PathIntegrand, Value};
pub use map::{Map, Then};
pub use path_density::PathDensity;
pub use point::{Curve, Direction, Embedded, Point, Surface, SurfaceId, SurfacePoint};
pub use preimages::Preimages;
pub use real::{Mask, Real, Scalar};
pub use sampler::{Derivation, DomainError, PdfOf, Sample, Sampler, Uniform, Uniforms};
pub use discrete::{Bernoulli, Choice, Choices, Discrete, WeightError, coin, discrete, discrete_weighted};
pub use sequence::{Arena, PathView, RandomSequence};
pub use strategy::{Conditional, Dirac, Drawn, Reads, Recall, Strategy, Vertex};
pub use uniform::{Pcg32, Sobol, UniformSource, draw_uniforms};
pub use vec::{Frame, Mat3, Vec2, Vec3};

/// Everything that a module with samplers in it needs: `use aether_core::prelude::*;`.
pub mod prelude {
    pub use crate::forms::{choose, constant, draw, given, stop};
    pub use aether_macros::{map, sampler, strategy};
    pub use crate::{
        Area, Curve, Density, Derivation, Direction, Embedded, Frame, Length, Map, Mat3, Point, Real,
        Sample, Sampler, Scalar, SolidAngle, Surface, SurfaceId, SurfacePoint, Uniform, Vec2, Vec3,
        Volume,
    };
    pub use core::f64::consts::{FRAC_1_PI, FRAC_PI_2, FRAC_PI_4, PI, SQRT_2, TAU};
}
