//! What it is worth to trace paths breadth first, with matte surfaces on lanes: time by stage, beside the path tracer.
//!
//! ```sh
//! cargo run --release -p tests --bin wavefront -- [SCENE] [--spp N] [--wave N]
//! ```

use std::hint::black_box;
use std::path::PathBuf;
use std::process::ExitCode;
use std::time::Instant;

use aether_core::Lanes;
use integrators::algorithm::Algorithm;
use integrators::integrator::Kernel;
use integrators::kind::{DiffuseRooms, Everything, NotCovered, SceneKind, covers};
use integrators::path::PathSettings;
use integrators::render::{AnyKernel, Splats};
use integrators::scene::Scene;
use integrators::strategies::Pixel;
use integrators::world::World;
use tests::twins::path::PathByHand;
use tests::twins::renderers::cornell_box;
use tests::wavefront::{Stage, Tally, Wavefront, Wide, supports};

const USAGE: &str = "\
wavefront [SCENE] [--spp N] [--wave N]
  SCENE     a scene of triangles with area lights, a pinhole and a box filter (Cornell's box)
  --spp N   samples of a pixel (16)
  --wave N  paths that are under way at once (512)";

/// How often each is timed, in turns; the least counts.
const ROUNDS: usize = 7;

struct Arguments {
    scene: PathBuf,
    spp: u32,
    wave: usize,
}

fn arguments() -> Option<Arguments> {
    let mut found = Arguments { scene: cornell_box(), spp: 16, wave: 512 };
    let mut rest = std::env::args().skip(1);
    while let Some(argument) = rest.next() {
        match argument.as_str() {
            "--spp" => found.spp = rest.next()?.parse().ok().filter(|n| *n > 0)?,
            "--wave" => found.wave = rest.next()?.parse().ok().filter(|n| *n > 0)?,
            flag if flag.starts_with('-') => return None,
            scene => found.scene = scene.into(),
        }
    }
    Some(found)
}

fn main() -> ExitCode {
    let Some(arguments) = arguments() else {
        eprintln!("{USAGE}");
        return ExitCode::from(2);
    };
    let scene = match Scene::load(&arguments.scene, &[]) {
        Ok(scene) if supports(&scene) => scene,
        Ok(_) => {
            return fail("the scene has what waves do not know: another light, filter or camera");
        }
        Err(error) => return fail(&error.to_string()),
    };
    let compared = match covers::<DiffuseRooms>(&scene) {
        Ok(()) => compare::<DiffuseRooms>(&scene, &arguments),
        Err(_) => compare::<Everything>(&scene, &arguments),
    };
    match compared {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => fail(&error.to_string()),
    }
}

fn fail(message: &str) -> ExitCode {
    eprintln!("wavefront: {message}");
    ExitCode::FAILURE
}

/// What is timed: seconds, and the sum of all that was found.
type Timed = (f64, f64);

fn compare<K: SceneKind>(scene: &Scene, arguments: &Arguments) -> Result<(), NotCovered> {
    let path = PathSettings::new(scene);
    let sampler = scene.sampler.seeded(1);
    let samples = samples(scene, arguments.spp);
    let world = World::<K>::new(scene)?;
    let Some(derived) = Algorithm::Path(path).kernel(K::NAME, scene, sampler) else {
        return Ok(());
    };
    let derived = derived?;
    let by_hand = Kernel::<K, _>::new(scene, PathByHand(path), 1)?.sampled_by(scene.sampler.kind);
    let [mut one, mut eight] = [(); 2].map(|()| Wavefront::new(&world, path));
    let numbers = (scene.sampler.kind, 1);
    let mut best = [(f64::INFINITY, 0.0); 4];
    for _ in 0..ROUNDS {
        let found = [
            depth_first(&*derived, &samples),
            depth_first(&by_hand, &samples),
            breadth_first::<K, f32>(&mut one, numbers, &samples, arguments.wave),
            breadth_first::<K, Lanes>(&mut eight, numbers, &samples, arguments.wave),
        ];
        for (best, found) in best.iter_mut().zip(found) {
            *best = (found.0.min(best.0), found.1);
        }
    }
    let count = samples.len() as f64;
    println!("{} {} samples, waves of {}", K::NAME, samples.len(), arguments.wave);
    println!("{:<28} {:>9} {:>7} {:>12}", "", "ns/sample", "ratio", "mean");
    let names = ["path tracer", "by hand", "waves, one by one", "waves, eight at once"];
    for (name, (seconds, sum)) in names.iter().zip(best) {
        let ratio = seconds / best[0].0;
        println!("{name:<28} {:>9.1} {ratio:>7.3} {:>12.6}", seconds * 1e9 / count, sum / count);
    }
    print(&one.tallies, &eight.tallies, count * ROUNDS as f64);
    Ok(())
}

fn print(one: &[Tally], eight: &[Tally], count: f64) {
    println!(
        "\n{:<14} {:>10} {:>10} {:>7} {:>9} {:>7}",
        "stage, ns", "one by one", "eight", "ratio", "items", "full"
    );
    for (stage, (one, eight)) in Stage::ALL.iter().zip(one.iter().zip(eight)) {
        let [a, b] = [one, eight].map(|tally| tally.seconds * 1e9 / count);
        let full = match eight.slots {
            0 => "-".to_owned(),
            slots => format!("{:.1} %", 100.0 * eight.items as f64 / slots as f64),
        };
        let items = eight.items as f64 / count;
        println!(
            "{:<14} {a:>10.1} {b:>10.1} {:>7.2} {items:>9.3} {full:>7}",
            format!("{stage:?}"),
            a / b
        );
    }
}

/// All samples of all pixels, those of a pixel one after the other, as the renderer takes them.
fn samples(scene: &Scene, spp: u32) -> Vec<(Pixel, u32)> {
    let (width, height) = (scene.film.width, scene.film.height);
    let pixels = (0..height).flat_map(|y| (0..width).map(move |x| (x, y)));
    pixels.flat_map(|pixel| (0..spp).map(move |sample| (pixel, sample))).collect()
}

fn depth_first(kernel: &dyn AnyKernel, samples: &[(Pixel, u32)]) -> Timed {
    let (mut worker, mut splats) = (kernel.worker(), Splats::default());
    let start = Instant::now();
    let value = |&(pixel, sample)| {
        worker(pixel, sample, &mut splats).iter().map(|v| f64::from(*v)).sum::<f64>()
    };
    let sum = samples.iter().map(value).sum();
    (start.elapsed().as_secs_f64(), black_box(sum))
}

fn breadth_first<K: SceneKind, R: Wide>(
    waves: &mut Wavefront<'_, '_, K>,
    numbers: (integrators::scene::SamplerKind, u64),
    samples: &[(Pixel, u32)],
    wave: usize,
) -> Timed {
    let (start, mut sum) = (Instant::now(), 0.0);
    for wave in samples.chunks(wave) {
        waves.run::<R>(numbers, wave, |_, value| sum += f64::from(value.element_sum()));
    }
    (start.elapsed().as_secs_f64(), black_box(sum))
}
