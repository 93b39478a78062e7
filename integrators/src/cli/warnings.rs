//! What a render warns of.

use super::arguments::RenderArguments;
use super::kernel::INTEGRATORS;
use super::plan::{OWN_UNIFORMS, Plan};
use super::warn;
use crate::render::Rendered;
use crate::scene::{Scene, Shape};

/// So many vertices without Russian roulette are as good as no end.
const ENDLESS: u32 = 10_000;

/// Prints what is strange about a scene file.
pub(super) fn warn_of(scene: &Scene) {
    for warning in &scene.warnings {
        warn(&format!("warning: {warning}"));
    }
}

/// Warns if the command line takes the place of an integrator that does not exist here.
pub(super) fn warn_of_integrator(scene: &Scene, plan: &Plan) {
    let wanted = &scene.integrator;
    if wanted.name != plan.integrator && !INTEGRATORS.contains(&wanted.name.as_str()) {
        let message = format!("not supported; \"{}\" takes its place", plan.integrator);
        match &wanted.place {
            Some(place) => warn(&format!("warning: {}", place.error(message))),
            None => warn(&format!("warning: integrator `{}`: {message}", wanted.name)),
        }
    }
}

/// Warns of light that light tracing by itself does not find.
pub(super) fn warn_of_lost_light(scene: &Scene, plan: &Plan) {
    if loses_light(scene, plan) {
        warn(
            "warning: light tracing alone loses light at a `bumpmap` or `normalmap` around what transmits, whose normals \
             are flipped for the viewer and not for the light; use another integrator, or give the material \
             <boolean name=\"flip_invalid_normals\" value=\"false\"/>",
        );
    }
}

/// Whether light tracing alone, by this plan, does not find some light.
pub(super) fn loses_light(scene: &Scene, plan: &Plan) -> bool {
    let from_lights = plan.integrator == "ptracer" || plan.techniques.is_light_tracing();
    let flips = |shape: &Shape| scene.bsdfs[shape.bsdf as usize].flips_transmitting();
    from_lights && scene.shapes.iter().any(flips)
}

/// Warns of options of other integrators than the one that renders.
pub(super) fn warn_of_idle_options(plan: &Plan, arguments: &RenderArguments) {
    let given: [(&str, bool, &[&str]); 5] = [
        ("--light-paths", arguments.light_paths.is_some(), &["bdpt", "vpl", "ppm"]),
        ("--clamp", arguments.clamp.is_some(), &["vpl"]),
        ("--mutations", arguments.mutations.is_some(), &["mlt"]),
        ("--chained-direct", arguments.chained_direct, &["mlt", "pssmlt"]),
        ("--reconstruction", arguments.reconstruction.is_some(), &["gdpt"]),
    ];
    let name = plan.integrator.as_str();
    for (option, is_given, integrators) in given {
        if is_given && !integrators.contains(&name) {
            let those = integrators.join(", ");
            warn(&format!("warning: {option} does nothing for `{name}`; it is of {those}"));
        }
    }
    if arguments.sampler.is_some() && OWN_UNIFORMS.contains(&name) {
        warn(&format!(
            "warning: --sampler does nothing for `{name}`, which has uniforms of its own"
        ));
    }
}

/// Warns of paths that may have no end.
pub(super) fn warn_of_endless_paths(plan: &Plan) {
    if plan.max_depth.is_none() && plan.rr_depth > ENDLESS {
        warn(&format!(
            "warning: paths of any length without Russian roulette before {} vertices may never end between walls that \
             reflect; give --max-depth",
            plan.rr_depth
        ));
    }
}

/// Warns of what went wrong in a render that is over.
pub(super) fn warn_about(rendered: &Rendered) {
    if rendered.invalid_samples > 0 {
        warn(&format!(
            "warning: {} samples were NaN or infinite and count as black; \
             the image is too dark there",
            rendered.invalid_samples
        ));
    }
    if rendered.film.samples().0 < 2 {
        warn("warning: a pixel has fewer than two samples, so no variance is written");
    }
    if rendered.cancelled {
        warn("interrupted; the image so far is kept");
    }
}
