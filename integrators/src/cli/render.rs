//! `aether render`: from a scene file to an EXR and a PNG.

use std::process::ExitCode;

use super::arguments::RenderArguments;
use super::checkpoint::checkpoint;
use super::kernel::{MOST_BYTES, kernel_for};
use super::live::Live;
use super::output::{More, keep_files_of, output_path, write_files, written};
use super::plan::{Plan, load};
use super::summary::{statistics, summary};
use super::terminal::Terminal;
use super::warnings::{
    warn_about, warn_of_endless_paths, warn_of_idle_options, warn_of_integrator, warn_of_lost_light,
};
use super::{Failure, INTERRUPTED, print, warn};
use crate::aovs::aovs;
use crate::image::check_writable;
use crate::render::splats::BYTES_OF_A_SUM;
use crate::render::{
    AnyKernel, Budget, ErrorBudget, Layer, Observer, Progress, RenderSettings, Rendered, render,
};
use crate::scene::Scene;

/// The most samples of each pixel for albedo, normal and depth, which have little noise.
const AOV_SAMPLES: u32 = 64;

/// Loads the scene, renders it and writes both files. After Ctrl-C, what has been rendered.
pub(super) fn run(arguments: &RenderArguments) -> Result<ExitCode, Failure> {
    let output = output_path(arguments)?;
    check_writable(&output)?;
    let scene = load(arguments)?;
    let plan = Plan::new(&scene, arguments);
    let kernel = kernel_for(&scene, &plan)?;
    warn_of_integrator(&scene, &plan);
    warn_of_idle_options(&plan, arguments);
    warn_of_lost_light(&scene, &plan);
    warn_of_endless_paths(&plan);
    let written = written(&output, &plan, arguments);
    keep_files_of(&scene, &written)?;

    let terminal = Terminal::new();
    let settings = RenderSettings {
        size: plan.size,
        budget: budget(arguments, &plan, kernel.as_ref())?,
        threads: arguments.threads,
        layered: layered(arguments, plan.size)?,
    };
    let checkpoint = match &arguments.checkpoint {
        Some(file) => Some(checkpoint(file, &scene, &plan, (arguments, &written))?),
        None => None,
    };
    let live = Live::new(&terminal, arguments, &output, checkpoint.as_ref());
    let rendered = match &checkpoint {
        Some(checkpoint) => checkpoint.render(kernel.as_ref(), &settings, &live),
        None => Ok(render(kernel.as_ref(), &settings, &live)),
    };
    terminal.finish();
    let rendered = rendered?;
    if rendered.film.samples().1 == 0 {
        warn("interrupted before the first sample; no file is written");
        return Ok(ExitCode::from(INTERRUPTED));
    }
    warn_about(&rendered);
    let shown = |layer: &Layer| matches!(layer, Layer::Technique { .. });
    if arguments.technique_images.is_some() && !rendered.layers.keys().any(shown) {
        let name = &plan.integrator;
        warn(&format!(
            "warning: `{name}` contributes no images of techniques: no path with so few vertices carries light"
        ));
    }
    let more = || seen(&scene, settings, (arguments, &plan), &rendered, &terminal);
    let pictures = write_files(&output, &plan, arguments, &rendered, &more)?;
    print(&summary(&output, &pictures, &rendered))?;
    if arguments.stats {
        print(&statistics(&rendered))?;
        if let Some(counted) = kernel.statistics() {
            print(&counted)?;
        }
    }
    let cancelled = rendered.cancelled || terminal.cancelled();
    Ok(if cancelled { ExitCode::from(INTERRUPTED) } else { ExitCode::SUCCESS })
}

/// Albedo, normal and depth, if they are asked for, of a render that is over; none if it is interrupted now.
fn seen(
    scene: &Scene,
    settings: RenderSettings,
    (arguments, plan): (&RenderArguments, &Plan),
    rendered: &Rendered,
    terminal: &Terminal,
) -> Result<More, Failure> {
    if !arguments.aovs {
        return Ok(More::new());
    }
    let samples = rendered.film.samples().1.min(AOV_SAMPLES);
    // A Ctrl-C that has ended the render does not end these.
    let observer: &dyn Observer = if rendered.cancelled { &() } else { &Quiet(terminal) };
    let images = aovs(scene, settings, samples, plan.seed, observer)
        .map_err(|error| Failure::new(error.to_string()))?;
    if observer.cancelled() {
        warn("interrupted; the image is kept without albedo, normal and depth");
        return Ok(More::new());
    }
    Ok(images)
}

/// Listens to Ctrl-C and shows nothing.
struct Quiet<'t>(&'t Terminal);

impl Observer for Quiet<'_> {
    fn progress(&self, _: &Progress) {}

    fn cancelled(&self) -> bool {
        self.0.cancelled()
    }
}

/// The most vertices of paths whose techniques get images, if these fit into memory; 0 without such images.
fn layered(arguments: &RenderArguments, (width, height): (u32, u32)) -> Result<usize, Failure> {
    let Some(vertices) = arguments.technique_images else { return Ok(0) };
    // Of paths of n vertices, up to 2n - 2 techniques, weighted and alone.
    let layers = 2 * u64::from(vertices) * u64::from(vertices - 1);
    let bytes = layers * u64::from(width) * u64::from(height) * BYTES_OF_A_SUM;
    if bytes > MOST_BYTES {
        return Err(Failure::new(format!(
            "images of the techniques of paths of up to {vertices} vertices may take {:.1} GB; ask for fewer \
             vertices, `--technique-images {}`, or for a smaller image, `--size`",
            bytes as f64 / 1e9,
            vertices - 1
        )));
    }
    Ok(vertices as usize)
}

/// When to stop.
fn budget(
    arguments: &RenderArguments,
    plan: &Plan,
    kernel: &dyn AnyKernel,
) -> Result<Budget, Failure> {
    let Some(target) = arguments.target_error else {
        return Ok(arguments.time.map_or(Budget::Samples(plan.samples), Budget::Seconds));
    };
    if arguments.adaptive && kernel.splats() {
        return Err(Failure::new(format!(
            "--adaptive gives pixels different numbers of samples, but those of integrator `{}` contribute to \
             other pixels than their own; leave --adaptive out",
            plan.integrator
        )));
    }
    if arguments.adaptive && arguments.technique_images.is_some() {
        return Err(Failure::new(
            "--adaptive gives pixels different numbers of samples, which --technique-images needs equal; leave \
             one of the two out",
        ));
    }
    Ok(Budget::Error(ErrorBudget {
        target,
        samples: arguments.spp.unwrap_or(i32::MAX as u32),
        seconds: arguments.time.unwrap_or(f64::INFINITY),
        adaptive: arguments.adaptive,
    }))
}
