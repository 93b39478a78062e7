//! Sampling functions with derived inverses, Jacobians and densities.

#![forbid(unsafe_code)]

// Emitted code names this crate by its path, also inside it.
extern crate self as aether_core;

pub mod bounded;
pub mod density;
pub mod map;
pub mod point;
pub mod preimages;
pub mod real;
pub mod sampler;
pub mod vec;

pub use density::{
    Area, Counting, Density, Hausdorff, Length, Measure, Product, SolidAngle, Volume,
};
pub use map::{Map, Then};
pub use point::{Curve, Direction, Embedded, Point, Surface, SurfaceId, SurfacePoint};
pub use preimages::Preimages;
pub use real::{Mask, Real, Scalar};
pub use sampler::{Derivation, DomainError, PdfOf, Sample, Sampler, Uniform, Uniforms};
pub use vec::{Mat3, Vec2, Vec3};

/// Everything that a module with samplers in it needs: `use aether_core::prelude::*;`.
pub mod prelude {
    pub use crate::{
        Area, Curve, Density, Derivation, Direction, Embedded, Length, Map, Mat3, Point, Real,
        Sample, Sampler, Scalar, SolidAngle, Surface, SurfaceId, SurfacePoint, Uniform, Vec2, Vec3,
        Volume,
    };
    pub use core::f64::consts::{FRAC_1_PI, FRAC_PI_2, FRAC_PI_4, PI, SQRT_2, TAU};
}
