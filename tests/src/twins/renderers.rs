//! The integrators beside those by hand: both make the same samples of the same pixels on one thread.

use std::path::{Path, PathBuf};

use integrators::algorithm::Algorithm;
use integrators::integrator::Kernel;
use integrators::kind::{DiffuseRooms, Everything, SceneKind};
use integrators::path::PathSettings;
use integrators::render::{AnyKernel, Splats, Worker};
use integrators::scene::Scene;
use integrators::work::Work;

use super::measure::{Kind, Meter, Task};
use super::path::{PathByHand, supports};

/// How many pixels along each side are looked at, and samples of each.
const SIDE: u32 = 32;
const SAMPLES: u32 = 2;
/// How many samples that is.
pub const CALLS: usize = (SIDE * SIDE * SAMPLES) as usize;

/// The scene that integrators are compared in.
pub fn cornell_box() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes/cornell-box.xml")
}

/// The settings of paths: 8 edges at most, and Russian roulette as the scene has it.
pub fn settings(scene: &Scene) -> PathSettings {
    let rr_depth = scene.integrator.rr_depth;
    PathSettings { max_depth: Some(8), rr_depth, hide_emitters: false }
}

/// A loop over pixels spread over the image.
pub struct Loop<'a> {
    worker: Worker<'a>,
    splats: Splats,
    size: (u32, u32),
    /// What all samples add up to.
    pub sum: f64,
}

impl<'a> Loop<'a> {
    /// One that has run once, so that its memory is there.
    pub fn new(kernel: &'a dyn AnyKernel, scene: &Scene) -> Self {
        let size = (scene.film.width, scene.film.height);
        let mut it = Loop { worker: kernel.worker(), splats: Splats::default(), size, sum: 0.0 };
        it.run();
        it
    }

    /// All samples.
    pub fn run(&mut self) {
        self.each(|_, _| ());
    }

    /// All samples, each shown to `visit`.
    pub fn each(&mut self, mut visit: impl FnMut((u32, u32), [f32; 3])) {
        for i in 0..SIDE * SIDE {
            let place = |k: u32, size: u32| (2 * k + 1) * size / (2 * SIDE);
            let pixel = (place(i % SIDE, self.size.0), place(i / SIDE, self.size.1));
            for sample in 0..SAMPLES {
                let value = (self.worker)(pixel, sample, &mut self.splats);
                self.sum += value.iter().map(|v| f64::from(*v)).sum::<f64>();
                visit(pixel, value);
            }
        }
    }

    /// What one run computes.
    pub fn work(&mut self) -> Work {
        let before = Work::here();
        self.run();
        Work::here() - before
    }
}

/// Measures the path tracers for the smallest kind that covers the scene and for everything.
///
/// # Errors
/// What is wrong with the scene.
pub fn visit_integrators(meter: &mut impl Meter, names: &[String]) -> Result<(), String> {
    let scene = Scene::load(&cornell_box(), &[]).map_err(|e| e.to_string())?;
    if !supports(&scene) {
        return Err("the path tracer by hand does not know all that the scene has".to_owned());
    }
    path::<DiffuseRooms>(meter, names, &scene, "path tracer, smallest kind")?;
    path::<Everything>(meter, names, &scene, "path tracer, everything")
}

fn path<K: SceneKind>(
    meter: &mut impl Meter,
    names: &[String],
    scene: &Scene,
    name: &'static str,
) -> Result<(), String> {
    if !names.is_empty() && !names.iter().any(|part| name.contains(part.as_str())) {
        return Ok(());
    }
    let settings = settings(scene);
    let derived = Algorithm::Path(settings).kernel(K::NAME, scene, 1);
    let derived = derived.ok_or("no such kind")?.map_err(|e| e.to_string())?;
    let by_hand = Kernel::<K, _>::new(scene, PathByHand(settings), 1).map_err(|e| e.to_string())?;
    let mut derived = Loop::new(&*derived, scene);
    let mut by_hand = Loop::new(&by_hand, scene);
    let works = [derived.work(), by_hand.work()];
    let task =
        Task { kind: Kind::Integrator(works), row: 0, name, operation: "sample", calls: CALLS };
    meter.measure(task, [&mut || derived.run(), &mut || by_hand.run()]);
    Ok(())
}
