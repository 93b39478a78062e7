//! Renders the scene that the command line names and prints its mean.

use std::path::PathBuf;

use integrators::kind::SceneKind;
use integrators::path::{PathSettings, PathTracer};
use integrators::render::{Budget, RenderSettings, render};
use integrators::scene::Scene;

/// Renders with a path tracer that is compiled for the kind `K`.
pub fn mean<K: SceneKind>() -> Result<(), Box<dyn std::error::Error>> {
    let path = std::env::args_os()
        .nth(1)
        .map(PathBuf::from)
        .ok_or("the name of a scene file is missing")?;
    let scene = Scene::load(&path, &[])?;
    let settings = PathSettings {
        max_depth: scene.integrator.max_depth,
        rr_depth: scene.integrator.rr_depth,
        hide_emitters: scene.integrator.hide_emitters,
    };
    let tracer = PathTracer::<K>::new(&scene, settings, 1)?;
    let size = (scene.film.width, scene.film.height);
    let effort = RenderSettings { size, budget: Budget::Samples(4), threads: None };
    let film = render(&tracer, &effort, &()).film;
    let sum: f64 = film.pixels().iter().flat_map(|pixel| pixel.mean()).sum();
    println!("{}: mean {:.4}", K::NAME, sum / (3 * film.pixels().len()) as f64);
    Ok(())
}
