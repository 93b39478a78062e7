//! The integrators of the program, compiled for the precompiled kinds of scenes.

use crate::bidirectional::Bidirectional;
use crate::chains::{ChainIntegrator, ChainKernel};
use crate::gradient_domain::GradientDomain;
use crate::instant_radiosity::{InstantRadiosity, RadiosityKernel};
use crate::integrator::{Integrator, Kernel};
use crate::kind::{self, DiffuseRooms, Everything, NotCovered, SceneKind};
use crate::light_tracer::LightTracer;
use crate::metropolis::Metropolis;
use crate::path::PathSettings;
use crate::photon_mapping::{PhotonKernel, PhotonMapping};
use crate::primary_sample::PrimarySample;
use crate::render::AnyKernel;
use crate::scene::{Sampler, Scene};
use crate::tridirectional::Tridirectional;
use crate::vertex_merging::{MergingKernel, VertexMerging};

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
    /// Vertex connection and merging.
    VertexMerging(VertexMerging),
    /// Metropolis light transport in path space.
    Metropolis(Metropolis),
    /// Metropolis light transport on primary samples.
    PrimarySample(PrimarySample),
    /// Gradient-domain path tracing: the image is still to be made of what is rendered
    /// ([`crate::poisson`]).
    GradientDomain(GradientDomain),
}

impl Algorithm {
    /// The names of its techniques, as a [`Selection`](crate::selection::Selection) is read: scattering and
    /// next-event estimation, or pieces from both ends, and how they are joined.
    pub fn techniques(&self) -> &'static str {
        match self {
            Algorithm::Path(_) | Algorithm::GradientDomain(_) => "0:2..,1:2..",
            Algorithm::LightTracer(_) => "1..:1",
            Algorithm::Bidirectional(_)
            | Algorithm::Metropolis(_)
            | Algorithm::PrimarySample(_) => "*:1..",
            Algorithm::Tridirectional(_) => "*:1..,portal-*:1..",
            Algorithm::InstantRadiosity(_) => "*:2..",
            Algorithm::PhotonMapping(_) => "0:2..,merge-2..:2..",
            Algorithm::VertexMerging(_) => "*:1..,merge-2..:2..",
        }
    }

    /// The algorithm for a scene by the name of a precompiled kind; `None` if there is no such kind. Uniforms are of the
    /// kind and seed of `sampler`; Markov chains and photons take the seed alone. The same seed gives the same
    /// image, whatever the kind. Path tracing, also with gradients, and bidirectional path tracing are
    /// compiled for all kinds, Markov chains for [`DiffuseRooms`] and [`Everything`], the others for the latter alone, which
    /// is used for all names that an algorithm is not compiled for.
    ///
    /// # Errors
    /// If the scene needs what the kind leaves out.
    pub fn kernel<'s>(
        self,
        kind: &str,
        scene: &'s Scene,
        sampler: Sampler,
    ) -> Option<Result<Box<dyn AnyKernel + 's>, NotCovered>> {
        // The tests of this crate's modules make no kernels, and are compiled much faster without them.
        if cfg!(test) {
            return None;
        }
        let seed = sampler.seed;
        match self {
            Algorithm::Path(it) => kind::named(kind, Make { integrator: it, scene, sampler }),
            Algorithm::Bidirectional(it) => {
                kind::named(kind, Make { integrator: it, scene, sampler })
            }
            Algorithm::GradientDomain(it) => {
                kind::named(kind, Make { integrator: it, scene, sampler })
            }
            _ if !kind::KINDS.contains(&kind) => None,
            Algorithm::LightTracer(it) => Some(general(scene, it, sampler)),
            Algorithm::Tridirectional(it) => Some(general(scene, it, sampler)),
            Algorithm::InstantRadiosity(it) => {
                let kernel = RadiosityKernel::<Everything>::new(scene, it, sampler);
                Some(kernel.map(|kernel| Box::new(kernel) as _))
            }
            Algorithm::PhotonMapping(it) => {
                let kernel = PhotonKernel::<Everything>::new(scene, it, seed);
                Some(kernel.map(|kernel| Box::new(kernel) as _))
            }
            Algorithm::VertexMerging(it) => {
                let kernel = MergingKernel::<Everything>::new(scene, it, seed);
                Some(kernel.map(|kernel| Box::new(kernel) as _))
            }
            Algorithm::Metropolis(it) => Some(chained(kind, scene, it, seed)),
            Algorithm::PrimarySample(it) => Some(chained(kind, scene, it, seed)),
        }
    }
}

fn general<'s, I: Integrator + 's>(
    scene: &'s Scene,
    integrator: I,
    sampler: Sampler,
) -> Result<Box<dyn AnyKernel + 's>, NotCovered> {
    kind::WithKind::with::<Everything>(Make { integrator, scene, sampler })
}

/// Markov chains, whose steps in matte rooms take a seventh less time in path space and a third less on primary samples than
/// those for [`Everything`].
fn chained<'s, I: ChainIntegrator + 's>(
    kind: &str,
    scene: &'s Scene,
    integrator: I,
    seed: u64,
) -> Result<Box<dyn AnyKernel + 's>, NotCovered> {
    Ok(match kind {
        DiffuseRooms::NAME => {
            Box::new(ChainKernel::<DiffuseRooms, _>::new(scene, integrator, seed)?)
        }
        _ => Box::new(ChainKernel::<Everything, _>::new(scene, integrator, seed)?),
    })
}

struct Make<'s, I> {
    integrator: I,
    scene: &'s Scene,
    sampler: Sampler,
}

impl<'s, I: Integrator + 's> kind::WithKind for Make<'s, I> {
    type Output = Box<dyn AnyKernel + 's>;
    fn with<K: SceneKind>(self) -> Result<Self::Output, NotCovered> {
        let Make { integrator, scene, sampler } = self;
        let kernel = Kernel::<K, _>::new(scene, integrator, sampler.seed)?;
        Ok(Box::new(kernel.sampled_by(sampler.kind)))
    }
}
