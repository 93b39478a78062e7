//! The integrators of the program, each compiled for the precompiled kinds of scenes.

use crate::bidirectional::Bidirectional;
use crate::chains::ChainKernel;
use crate::instant_radiosity::InstantRadiosity;
use crate::integrator::Kernel;
use crate::kind::{self, NotCovered, SceneKind};
use crate::light_tracer::LightTracer;
use crate::metropolis::Metropolis;
use crate::path::PathSettings;
use crate::photon_mapping::{PhotonKernel, PhotonMapping};
use crate::primary_sample::PrimarySample;
use crate::render::AnyKernel;
use crate::scene::Scene;
use crate::tridirectional::Tridirectional;

/// A light transport algorithm with its settings.
#[derive(Clone, Debug)]
pub enum Algorithm {
    /// Path tracing with next-event estimation.
    Path(PathSettings),
    /// Light tracing.
    LightTracer(LightTracer),
    /// Bidirectional path tracing.
    Bidirectional(Bidirectional),
    /// Tridirectional path tracing.
    Tridirectional(Tridirectional),
    /// Instant radiosity.
    InstantRadiosity(InstantRadiosity),
    /// Progressive photon mapping.
    PhotonMapping(PhotonMapping),
    /// Metropolis light transport in path space.
    Metropolis(Metropolis),
    /// Metropolis light transport on primary samples.
    PrimarySample(PrimarySample),
}

impl Algorithm {
    /// The algorithm for a scene by the name of a precompiled kind; `None` if there is no such kind. The
    /// same seed gives the same image, whatever the kind.
    ///
    /// # Errors
    /// If the scene needs what the kind leaves out.
    pub fn kernel<'s>(
        self,
        kind: &str,
        scene: &'s Scene,
        seed: u64,
    ) -> Option<Result<Box<dyn AnyKernel + 's>, NotCovered>> {
        kind::named(kind, Make { algorithm: self, scene, seed })
    }
}

struct Make<'s> {
    algorithm: Algorithm,
    scene: &'s Scene,
    seed: u64,
}

impl<'s> kind::WithKind for Make<'s> {
    type Output = Box<dyn AnyKernel + 's>;
    fn with<K: SceneKind>(self) -> Result<Self::Output, NotCovered> {
        let Make { algorithm, scene, seed } = self;
        Ok(match algorithm {
            Algorithm::Path(it) => Box::new(Kernel::<K, _>::new(scene, it, seed)?),
            Algorithm::LightTracer(it) => Box::new(Kernel::<K, _>::new(scene, it, seed)?),
            Algorithm::Bidirectional(it) => Box::new(Kernel::<K, _>::new(scene, it, seed)?),
            Algorithm::Tridirectional(it) => Box::new(Kernel::<K, _>::new(scene, it, seed)?),
            Algorithm::InstantRadiosity(it) => Box::new(Kernel::<K, _>::new(scene, it, seed)?),
            Algorithm::PhotonMapping(it) => Box::new(PhotonKernel::<K>::new(scene, it, seed)?),
            Algorithm::Metropolis(it) => Box::new(ChainKernel::<K, _>::new(scene, it, seed)?),
            Algorithm::PrimarySample(it) => Box::new(ChainKernel::<K, _>::new(scene, it, seed)?),
        })
    }
}
