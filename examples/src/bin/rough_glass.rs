//! What you learn here: how to compile a path tracer for one kind of scenes.
//!
//! This one is for matte rooms with lamps and things of rough glass. Metal, masks or a sky are not compiled
//! into it, and a scene that has any is an error. `aether inspect SCENE.xml` lists what a scene needs.
//!
//! Renders the scene that the command line names, or else a sphere of rough glass, and prints its mean.

use std::path::Path;

use integrators::path::{PathSettings, PathTracer};
use integrators::render::{Budget, RenderSettings, render};
use integrators::scene::Scene;
use integrators::scene_kind;

scene_kind! {
    /// Matte walls, lamps, rough glass.
    pub struct Glass: Diffuse, RoughDielectric, Area;
}

const SCENE: &str = r#"<scene version="3.0.0">
    <integrator type="path"><integer name="max_depth" value="12"/></integrator>
    <sensor type="perspective"><float name="fov" value="35"/>
        <transform name="to_world"><lookat origin="0, 2, 6" target="0, 0.9, 0" up="0, 1, 0"/></transform>
        <film type="hdrfilm"><integer name="width" value="64"/><integer name="height" value="64"/></film>
    </sensor>
    <shape type="rectangle">
        <transform name="to_world"><rotate x="1" angle="-90"/><scale value="5"/></transform>
    </shape>
    <shape type="rectangle">
        <transform name="to_world"><rotate x="1" angle="90"/><translate y="4"/></transform>
        <emitter type="area"><rgb name="radiance" value="5"/></emitter>
    </shape>
    <shape type="sphere"><point name="center" x="0" y="1.1" z="0"/>
        <bsdf type="roughdielectric"><string name="distribution" value="ggx"/></bsdf>
    </shape>
</scene>"#;

/// The mean of all pixels and channels.
fn mean(scene: &Scene, samples: u32) -> Result<f64, Box<dyn std::error::Error>> {
    let settings = PathSettings::new(scene);
    let tracer = PathTracer::<Glass>::new(scene, settings, 1)?;
    let size = (scene.film.width, scene.film.height);
    let effort = RenderSettings::new(size, Budget::Samples(samples));
    let film = render(&tracer, &effort, &()).film;
    let sum: f64 = film.pixels().iter().flat_map(|pixel| pixel.mean()).sum();
    Ok(sum / (3 * film.pixels().len()) as f64)
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let scene = match std::env::args_os().nth(1) {
        Some(path) => Scene::load(Path::new(&path), &[])?,
        None => Scene::from_str(SCENE, Path::new("."), &[])?,
    };
    println!("mean {:.4}", mean(&scene, 32)?);
    Ok(())
}
