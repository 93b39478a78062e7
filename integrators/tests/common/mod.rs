//! Renders of scenes as the program makes them.

use integrators::algorithm::Algorithm;
use integrators::kind;
use integrators::path::PathSettings;
use integrators::render::{AnyKernel, Budget, Film, RenderSettings, render};
use integrators::scene::Scene;

/// The settings that a scene asks for.
pub fn settings(scene: &Scene) -> PathSettings {
    PathSettings::new(scene)
}

/// The path tracer as the program makes it.
///
/// # Panics
/// If the scene needs what no kind has.
pub fn path_tracer(scene: &Scene, seed: u64) -> Box<dyn AnyKernel + '_> {
    let tracer = Algorithm::Path(settings(scene)).kernel(
        kind::smallest(scene),
        scene,
        scene.sampler.seeded(seed),
    );
    tracer.expect("a precompiled kind").expect("a kind that covers the scene")
}

/// Renders with a kernel: so many samples for each pixel, on so many threads (`None`: all cores).
///
/// # Panics
/// If a sample is not finite.
pub fn film(kernel: &dyn AnyKernel, scene: &Scene, samples: u32, threads: Option<usize>) -> Film {
    let size = (scene.film.width, scene.film.height);
    let budget = Budget::Samples(samples);
    let rendered =
        render(kernel, &RenderSettings { threads, ..RenderSettings::new(size, budget) }, &());
    assert_eq!(rendered.invalid_samples, 0, "samples that are NaN or infinite");
    rendered.film
}
