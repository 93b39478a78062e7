//! The integrators beside those by hand: both make the same samples of the same pixels on one thread.

use std::path::{Path, PathBuf};

use integrators::algorithm::Algorithm;
use integrators::bidirectional::Bidirectional;
use integrators::integrator::{Integrator, Kernel};
use integrators::kind::{DiffuseRooms, Everything, SceneKind};
use integrators::path::PathSettings;
use integrators::render::{AnyKernel, SplatSums, Splats, Worker};
use integrators::scene::Scene;
use integrators::selection::Selection;
use integrators::work::Work;

use super::bidirectional::{BidirectionalByHand, supports};
use super::measure::{Kind, Meter, Task, is_asked};
use super::path::PathByHand;

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
    PathSettings { max_depth: Some(8), ..PathSettings::new(scene) }
}

/// A loop over pixels spread over the image.
pub struct Loop<'a> {
    worker: Worker<'a>,
    splats: Splats,
    splatted: SplatSums,
    size: (u32, u32),
    /// What all samples add up to.
    pub sum: f64,
}

impl<'a> Loop<'a> {
    /// One that has run once, so that its memory is there.
    pub fn new(kernel: &'a dyn AnyKernel, scene: &Scene) -> Self {
        let size = (scene.film.width, scene.film.height);
        let (splats, splatted) = (Splats::default(), SplatSums::new(size));
        let mut it = Loop { worker: kernel.worker(), splats, splatted, size, sum: 0.0 };
        it.run();
        it
    }

    /// All samples.
    pub fn run(&mut self) {
        self.each(|_, _| ());
    }

    /// What all samples since the beginning have added to other pixels than their own, by the number of the pixel.
    pub fn splat(&self, pixel: usize) -> [f64; 3] {
        self.splatted.estimate(pixel, 1.0)[0]
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
            self.splatted.take(&mut self.splats);
        }
    }

    /// What one run computes.
    pub fn work(&mut self) -> Work {
        let before = Work::here();
        self.run();
        Work::here() - before
    }
}

/// The settings of bidirectional paths: the same without Russian roulette, whose probabilities would depend on both
/// ends of a path.
pub fn settings_of_pieces() -> PathSettings {
    let techniques = Selection::ALL;
    PathSettings { max_depth: Some(8), rr_depth: u32::MAX, hide_emitters: false, techniques }
}

/// Measures the integrators for the smallest kind that covers the scene and for everything.
///
/// # Errors
/// What is wrong with the scene.
pub fn visit_integrators(meter: &mut impl Meter, names: &[String]) -> Result<(), String> {
    let scene = Scene::load(&cornell_box(), &[]).map_err(|e| e.to_string())?;
    if !supports(&scene) {
        return Err("the integrators by hand do not know all that the scene has".to_owned());
    }
    let path = settings(&scene);
    let derived = || Algorithm::Path(path);
    let by_hand = || PathByHand(path);
    pair::<DiffuseRooms>(meter, names, &scene, "path tracer, smallest kind", derived(), by_hand())?;
    pair::<Everything>(meter, names, &scene, "path tracer, everything", derived(), by_hand())?;
    let path = settings_of_pieces();
    let derived = || Algorithm::Bidirectional(Bidirectional::new(path));
    let by_hand = || BidirectionalByHand(path);
    pair::<DiffuseRooms>(
        meter,
        names,
        &scene,
        "bidirectional, smallest kind",
        derived(),
        by_hand(),
    )?;
    pair::<Everything>(meter, names, &scene, "bidirectional, everything", derived(), by_hand())
}

/// Bidirectional path tracing of a scene, derived and by hand.
///
/// # Errors
/// If the kind does not cover the scene.
pub fn bidirectional<K: SceneKind>(scene: &Scene) -> Result<[Box<dyn AnyKernel + '_>; 2], String> {
    let path = settings_of_pieces();
    let derived = Bidirectional::new(path);
    kernels::<K>(scene, Algorithm::Bidirectional(derived), BidirectionalByHand(path))
}

fn kernels<'s, K: SceneKind>(
    scene: &'s Scene,
    derived: Algorithm,
    by_hand: impl Integrator + 's,
) -> Result<[Box<dyn AnyKernel + 's>; 2], String> {
    let derived = derived.kernel(K::NAME, scene, scene.sampler.seeded(1)).ok_or("no such kind")?;
    let by_hand = Kernel::<K, _>::new(scene, by_hand, 1).map_err(|e| e.to_string())?;
    Ok([derived.map_err(|e| e.to_string())?, Box::new(by_hand)])
}

fn pair<K: SceneKind>(
    meter: &mut impl Meter,
    names: &[String],
    scene: &Scene,
    name: &'static str,
    derived: Algorithm,
    by_hand: impl Integrator,
) -> Result<(), String> {
    if !is_asked(name, names) {
        return Ok(());
    }
    let [derived, by_hand] = kernels::<K>(scene, derived, by_hand)?;
    let mut derived = Loop::new(&*derived, scene);
    let mut by_hand = Loop::new(&*by_hand, scene);
    let works = [derived.work(), by_hand.work()];
    let task =
        Task { kind: Kind::Integrator(works), row: 0, name, operation: "sample", calls: CALLS };
    meter.measure(task, [&mut || derived.run(), &mut || by_hand.run()]);
    Ok(())
}
