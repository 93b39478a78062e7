//! From a plan to something that can be rendered.

use aether_core::uniform::MOST_PIECES;

use super::Failure;
use super::plan::Plan;
use crate::algorithm::Algorithm;
use crate::bidirectional::Bidirectional;
use crate::gradient_domain::GradientDomain;
use crate::instant_radiosity::InstantRadiosity;
use crate::light_tracer::LightTracer;
use crate::metropolis::Metropolis;
use crate::path::PathSettings;
use crate::photon_mapping::PhotonMapping;
use crate::portals::Portals;
use crate::primary_sample::PrimarySample;
use crate::render::AnyKernel;
use crate::scene::{Sampler, Scene};
use crate::tridirectional::Tridirectional;
use crate::vertex_merging::VertexMerging;

/// The integrator called `plan.integrator` with the settings of `plan`.
pub(super) fn kernel_for<'a>(
    scene: &'a Scene,
    plan: &Plan,
) -> Result<Box<dyn AnyKernel + 'a>, Failure> {
    let sampler = Sampler { kind: plan.sampler, seed: plan.seed, ..scene.sampler };
    match algorithm_for(scene, plan)?.kernel(&plan.kind, scene, sampler) {
        Some(kernel) => kernel.map_err(|error| Failure::new(error.to_string())),
        None => Err(Failure::new(format!("there is no kind `{}`", plan.kind))),
    }
}

/// The algorithm called `plan.integrator` with the settings of `plan`, not yet prepared for a scene.
pub(super) fn algorithm_for(scene: &Scene, plan: &Plan) -> Result<Algorithm, Failure> {
    let techniques = plan.techniques;
    let path = PathSettings { max_depth: plan.max_depth, techniques, ..PathSettings::new(scene) };
    let bidirectional = Bidirectional::new(path);
    let pixels = u64::from(plan.size.0) * u64::from(plan.size.1);
    let fewer_paths = |fitting| format!("ask for fewer, `--light-paths {fitting}`");
    let algorithm = match plan.integrator.as_str() {
        "path" => Algorithm::Path(path),
        "ptracer" => Algorithm::LightTracer(LightTracer { path }),
        "bdpt" => {
            let light_paths = plan.light_paths.unwrap_or(1);
            if light_paths > MOST_PIECES {
                let message = "--light-paths of integrator `bdpt`: a sample takes at most";
                return Err(Failure::new(format!("{message} {MOST_PIECES}")));
            }
            Algorithm::Bidirectional(Bidirectional { light_paths, ..bidirectional })
        }
        "vpl" => {
            let light_paths = plan.light_paths.unwrap_or(256);
            let radiosity = InstantRadiosity { path, light_paths, clamp: plan.clamp };
            check_bytes("vpl", u64::from(light_paths), radiosity.bytes(), fewer_paths)?;
            Algorithm::InstantRadiosity(radiosity)
        }
        "ppm" => {
            let settings = PhotonMapping::new(path);
            // As many as pixels, of which there are fewer than 2^32.
            let light_paths = plan.light_paths.unwrap_or(pixels as u32);
            let bytes = settings.bytes(light_paths);
            check_bytes("ppm", u64::from(light_paths), bytes, fewer_paths)?;
            Algorithm::PhotonMapping(PhotonMapping { light_paths: plan.light_paths, ..settings })
        }
        "vcm" => {
            let settings = VertexMerging::new(path);
            check_bytes("vcm", pixels, settings.bytes(pixels), |fitting| {
                let smaller = (fitting as f64 / pixels as f64).sqrt();
                let [width, height] = [plan.size.0, plan.size.1]
                    .map(|side| (f64::from(side) * smaller).max(1.0) as u32);
                format!("one for each pixel: ask for a smaller image, `--size {width}x{height}`")
            })?;
            Algorithm::VertexMerging(settings)
        }
        "mlt" => {
            let (mutations, direct) = (plan.mutations, plan.separate_direct);
            Algorithm::Metropolis(Metropolis { mutations, direct, ..Metropolis::new(path) })
        }
        "pssmlt" => {
            let direct = plan.separate_direct;
            Algorithm::PrimarySample(PrimarySample { direct, ..PrimarySample::new(bidirectional) })
        }
        "gdpt" => Algorithm::GradientDomain(GradientDomain::new(path)),
        "tridir" => {
            let portals = Portals::new(scene).map_err(Failure::new)?;
            Algorithm::Tridirectional(Tridirectional { path, portals })
        }
        unknown => {
            let supported = INTEGRATORS.join(", ");
            let message =
                format!("integrator `{unknown}` is not supported; supported: {supported}");
            return Err(match &scene.integrator.place {
                Some(place) if scene.integrator.name == unknown => {
                    Failure::new(place.error(message).to_string())
                }
                _ => Failure::new(message),
            });
        }
    };
    let vertices = 2 + usize::from(path.hide_emitters)..=path.most_vertices();
    techniques.check(algorithm.techniques(), vertices).map_err(|why| {
        Failure::new(format!("--techniques of integrator `{}`: {why}", plan.integrator))
    })?;
    Ok(algorithm)
}

/// The most bytes that the light paths of a sample, or images of techniques, may take.
pub(super) const MOST_BYTES: u64 = 8_000_000_000;

/// That so many light paths of an integrator, which take so many bytes, fit into memory; how to ask for as many as fit is said
/// otherwise.
fn check_bytes(
    integrator: &str,
    paths: u64,
    bytes: u64,
    remedy: impl Fn(u64) -> String,
) -> Result<(), Failure> {
    if bytes <= MOST_BYTES {
        return Ok(());
    }
    Err(Failure::new(format!(
        "{paths} light paths of integrator `{integrator}` may take {:.1} GB; {}, or for shorter ones, `--max-depth`",
        bytes as f64 / 1e9,
        remedy(MOST_BYTES / (bytes / paths))
    )))
}

/// The integrators, by their names in scene files and on the command line.
pub(super) const INTEGRATORS: [&str; 10] =
    ["path", "bdpt", "tridir", "gdpt", "mlt", "pssmlt", "vpl", "ppm", "vcm", "ptracer"];
