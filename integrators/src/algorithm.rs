//! The integrators of the program, compiled for the precompiled kinds of scenes.

use crate::bidirectional::Bidirectional;
use crate::chains::{ChainIntegrator, ChainKernel};
use crate::gradient_domain::GradientDomain;
use crate::instant_radiosity::{InstantRadiosity, RadiosityKernel};
use crate::integrator::{Integrator, Kernel};
use crate::kind::{self, NotCovered, SceneKind};
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
    /// image, whatever the kind.
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
        match self {
            Algorithm::Path(it) => made(Sampled(it), kind, scene, sampler),
            Algorithm::LightTracer(it) => made(Sampled(it), kind, scene, sampler),
            Algorithm::Bidirectional(it) => made(Sampled(it), kind, scene, sampler),
            Algorithm::Tridirectional(it) => made(Sampled(it), kind, scene, sampler),
            Algorithm::GradientDomain(it) => made(Sampled(it), kind, scene, sampler),
            Algorithm::InstantRadiosity(it) => made(it, kind, scene, sampler),
            Algorithm::PhotonMapping(it) => made(it, kind, scene, sampler),
            Algorithm::VertexMerging(it) => made(it, kind, scene, sampler),
            Algorithm::Metropolis(it) => made(Chained(it), kind, scene, sampler),
            Algorithm::PrimarySample(it) => made(Chained(it), kind, scene, sampler),
        }
    }
}

/// What has a kernel for each kind of scenes.
trait Compiled<'s> {
    fn kernel<K: SceneKind>(self, scene: &'s Scene, sampler: Sampler) -> Made<'s>;
}

type Made<'s> = Result<Box<dyn AnyKernel + 's>, NotCovered>;

/// An algorithm whose samples are independent.
struct Sampled<I>(I);

impl<'s, I: Integrator + 's> Compiled<'s> for Sampled<I> {
    fn kernel<K: SceneKind>(self, scene: &'s Scene, sampler: Sampler) -> Made<'s> {
        let kernel = Kernel::<K, _>::new(scene, self.0, sampler.seed)?;
        Ok(Box::new(kernel.sampled_by(sampler.kind)))
    }
}

/// An algorithm whose samples are those of Markov chains.
struct Chained<I>(I);

impl<'s, I: ChainIntegrator + 's> Compiled<'s> for Chained<I> {
    fn kernel<K: SceneKind>(self, scene: &'s Scene, sampler: Sampler) -> Made<'s> {
        Ok(Box::new(ChainKernel::<K, _>::new(scene, self.0, sampler.seed)?))
    }
}

impl<'s> Compiled<'s> for InstantRadiosity {
    fn kernel<K: SceneKind>(self, scene: &'s Scene, sampler: Sampler) -> Made<'s> {
        Ok(Box::new(RadiosityKernel::<K>::new(scene, self, sampler)?))
    }
}

impl<'s> Compiled<'s> for PhotonMapping {
    fn kernel<K: SceneKind>(self, scene: &'s Scene, sampler: Sampler) -> Made<'s> {
        Ok(Box::new(PhotonKernel::<K>::new(scene, self, sampler.seed)?))
    }
}

impl<'s> Compiled<'s> for VertexMerging {
    fn kernel<K: SceneKind>(self, scene: &'s Scene, sampler: Sampler) -> Made<'s> {
        Ok(Box::new(MergingKernel::<K>::new(scene, self, sampler.seed)?))
    }
}

/// The kernel for the kind with some name, if there is one.
fn made<'s, C: Compiled<'s> + 's>(
    of: C,
    kind: &str,
    scene: &'s Scene,
    sampler: Sampler,
) -> Option<Made<'s>> {
    kind::named(kind, Make { of, scene, sampler })
}

struct Make<'s, C> {
    of: C,
    scene: &'s Scene,
    sampler: Sampler,
}

impl<'s, C: Compiled<'s> + 's> kind::WithKind for Make<'s, C> {
    type Output = Box<dyn AnyKernel + 's>;
    fn with<K: SceneKind>(self) -> Result<Self::Output, NotCovered> {
        self.of.kernel::<K>(self.scene, self.sampler)
    }
}
