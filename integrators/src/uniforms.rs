//! The uniforms that integrators draw from.

use aether_core::{Pcg32, Sobol, UniformSource};

use crate::scene::SamplerKind;

/// Uniforms of any kind that a scene may ask for, as one type: integrators and strategies are compiled once for all.
#[derive(Clone, Debug)]
pub enum Uniforms {
    /// Independent of each other.
    Independent(Pcg32),
    /// Stratified over the samples of a pixel.
    Stratified(Sobol),
}

impl Uniforms {
    /// Those of one sample of a pixel, whose number is `stream`.
    #[inline]
    pub fn new(kind: SamplerKind, seed: u64, stream: u64, sample: u32) -> Self {
        match kind {
            SamplerKind::Independent => Self::independent(seed, stream, sample.into()),
            _ => Self::Stratified(Sobol::new(seed, stream, sample)),
        }
    }

    /// Independent ones.
    #[inline]
    pub fn independent(seed: u64, stream: u64, sample: u64) -> Self {
        Self::Independent(Pcg32::new(seed, stream, sample))
    }
}

impl UniformSource<f32> for Uniforms {
    #[inline]
    fn next(&mut self) -> f32 {
        match self {
            Self::Independent(source) => source.next(),
            Self::Stratified(source) => source.next(),
        }
    }

    #[inline]
    fn start(&mut self, block: u32) {
        match self {
            Self::Independent(source) => UniformSource::<f32>::start(source, block),
            Self::Stratified(source) => UniformSource::<f32>::start(source, block),
        }
    }
}
