//! What is to be rendered: a scene file with what the command line asks of it.

use super::Failure;
use super::arguments::{RenderArguments, check_size};
use super::warnings::warn_of;
use crate::kind;
use crate::metropolis::MutationSet;
use crate::poisson::Reconstruction;
use crate::scene::{Bsdf, Overrides, SamplerKind, Scene};
use crate::selection::Selection;

/// The integrators that make chains or passes of their uniforms.
pub(super) const OWN_UNIFORMS: [&str; 4] = ["mlt", "pssmlt", "ppm", "vcm"];

/// What an integrator is asked for: the scene's settings, overridden by the command line.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Plan {
    /// The name of the integrator.
    pub integrator: String,
    /// Columns and rows of the image.
    pub size: (u32, u32),
    /// The first column and row of the image on the film that the scene describes.
    pub crop: (u32, u32),
    /// Samples per pixel, unless a time is given.
    pub samples: u32,
    /// Seed of the random numbers.
    pub seed: u64,
    /// Where the uniforms come from, for integrators that do not make chains or passes of them.
    pub sampler: SamplerKind,
    /// The longest path in edges as Mitsuba counts them, or `None` for any length.
    pub max_depth: Option<u32>,
    /// The path length from which Russian roulette may end a path.
    pub rr_depth: u32,
    /// The kind of scenes that the renderer is compiled for.
    pub kind: String,
    /// Which techniques are used.
    pub techniques: Selection,
    /// How many light paths the pixels share, for integrators where they do.
    pub light_paths: Option<u32>,
    /// What the geometry term of a connection is at most, for instant radiosity.
    pub clamp: Option<f32>,
    /// Which mutations are used, for Metropolis light transport.
    pub mutations: MutationSet,
    /// Whether Markov chains leave direct light to path tracing.
    pub separate_direct: bool,
    /// How an image is made of its gradients, for integrators that have them.
    pub reconstruction: Reconstruction,
    /// Whether the camera does not see lights.
    pub hide_emitters: bool,
    /// The parameters that say nothing but how many samples there are.
    pub sample_parameters: Vec<String>,
}

impl Plan {
    /// The name of where uniforms come from, for the record.
    pub fn sampler_name(&self) -> &'static str {
        let is_own = OWN_UNIFORMS.contains(&self.integrator.as_str());
        if is_own { "of the integrator" } else { self.sampler.name() }
    }

    /// The settings of a scene with those of the command line in their place.
    pub fn new(scene: &Scene, arguments: &RenderArguments) -> Self {
        let requested = &scene.integrator;
        Self {
            integrator: arguments.integrator.clone().unwrap_or_else(|| requested.name.clone()),
            size: (scene.film.width, scene.film.height),
            // Whole numbers of pixels.
            crop: (scene.camera.crop.x as u32, scene.camera.crop.y as u32),
            samples: arguments.spp.unwrap_or(scene.sampler.sample_count),
            seed: arguments.seed.unwrap_or(scene.sampler.seed),
            sampler: arguments.sampler.unwrap_or(scene.sampler.kind),
            // -1 has no counterpart in u32: no limit.
            max_depth: arguments.max_depth.map_or(requested.max_depth, |d| u32::try_from(d).ok()),
            rr_depth: requested.rr_depth,
            kind: arguments.kind.clone().unwrap_or_else(|| kind::smallest(scene).to_owned()),
            techniques: arguments.techniques.unwrap_or_default(),
            light_paths: arguments.light_paths,
            clamp: arguments.clamp,
            mutations: arguments.mutations.unwrap_or_default(),
            separate_direct: !arguments.chained_direct,
            reconstruction: arguments.reconstruction.unwrap_or_default(),
            hide_emitters: requested.hide_emitters,
            sample_parameters: scene.sample_parameters.clone(),
        }
    }
}

/// Reads the scene file that the command line names, with the size that it asks for.
pub(super) fn load(arguments: &RenderArguments) -> Result<Scene, Failure> {
    let overrides = Overrides { size: arguments.size, portals: arguments.portals.clone() };
    let mut scene = Scene::load_with(&arguments.scene, &arguments.defines, &overrides)?;
    warn_of(&scene);
    check_size((scene.film.width, scene.film.height))
        .map_err(|error| Failure::new(format!("image size {error}")))?;
    if arguments.mitsuba3_roughplastic {
        scene.bsdfs.iter_mut().for_each(Bsdf::lose_energy);
    }
    Ok(scene)
}
