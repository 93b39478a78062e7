//! Rays a second in a scene, on one thread: `cargo run --release -p integrators --example rays -- SCENE.xml`.
//!
//! Rays from the camera, in the order of the pixels; rays from what these hit in random directions, in random
//! order; and segments between pairs of points that were hit.
//! With `--write FILE` the first two sets are written too: of each ray its origin, its direction and how far away the
//! nearest hit is (infinite if there is none), as little-endian `f32`.
//! Under `valgrind --tool=callgrind --toggle-collect='*rays::cast*'` with `--rays 20000 --rounds 1` the
//! instructions that it counts are those of the rays alone.

use std::io::{self, Write};
use std::path::Path;
use std::process::ExitCode;
use std::time::Instant;

use aether_core::uniform::{Pcg32, UniformSource};
use glam::{Vec2, Vec3};
use integrators::scene::{Hit, PrimitiveId, Scene};

const USAGE: &str =
    "rays SCENE.xml [--rays N] [--rounds N] [--write FILE]   (a million rays, three times)";

/// A ray, or a segment to another point.
struct Ray {
    from: Vec3,
    on: Option<PrimitiveId>,
    direction: Vec3,
    to: Option<Hit>,
}

fn main() -> ExitCode {
    let words: Vec<String> = std::env::args().skip(1).collect();
    let option = |name: &str, default: usize| {
        let place = words.iter().position(|word| word == name);
        place.map_or(Some(default), |i| words.get(i + 1)?.parse().ok().filter(|n| *n > 0))
    };
    let (Some(file), Some(count), Some(rounds)) =
        (words.first(), option("--rays", 1_000_000), option("--rounds", 3))
    else {
        eprintln!("{USAGE}");
        return ExitCode::FAILURE;
    };
    let file_of_rays = words.iter().position(|word| word == "--write").map(|i| words.get(i + 1));
    if file_of_rays == Some(None) {
        eprintln!("{USAGE}");
        return ExitCode::FAILURE;
    }
    let start = Instant::now();
    let scene = match Scene::load(Path::new(file), &[]) {
        Ok(scene) => scene,
        Err(error) => {
            eprintln!("{error}");
            return ExitCode::FAILURE;
        }
    };
    println!("{} primitives in {:.2} s", scene.primitives.len(), start.elapsed().as_secs_f64());

    let mut random = Pcg32::new(1, 0, 0);
    let coherent = camera_rays(&scene, count);
    let hits: Vec<Hit> = coherent.iter().filter_map(|ray| seen_side(&scene, ray)).collect();
    if hits.is_empty() {
        eprintln!("{file}: the camera sees no surface");
        return ExitCode::FAILURE;
    }
    let mut pick = || hits[(uniform(&mut random) * hits.len() as f64) as usize];
    let (starts, ends): (Vec<Hit>, Vec<Hit>) = (0..count).map(|_| (pick(), pick())).unzip();
    let scattered: Vec<Ray> = starts.iter().map(|hit| scatter(hit, &mut random)).collect();
    let segments: Vec<Ray> = starts.iter().zip(&ends).map(|(a, b)| segment(a, b)).collect();

    if let Some(file) = file_of_rays.flatten()
        && let Err(error) = write(&scene, Path::new(file), coherent.iter().chain(&scattered))
    {
        eprintln!("{file}: {error}");
        return ExitCode::FAILURE;
    }
    let hit = |ray: &Ray| nearest(&scene, ray).is_some();
    report("nearest hit from the camera", rounds, &coherent, hit);
    report("nearest hit after scattering", rounds, &scattered, hit);
    let start = Instant::now();
    let sorted = sorted(scattered);
    let each = start.elapsed().as_secs_f64() * 1e9 / count as f64;
    report("the same, sorted before", rounds, &sorted, hit);
    println!("{:30} {each:7.0} ns a ray", "sorting");
    report("anything between two points", rounds, &segments, |ray| {
        ray.to.is_some_and(|to| !scene.visible(ray.from, ray.on, to.position, Some(to.primitive)))
    });
    ExitCode::SUCCESS
}

/// Writes rays with the distances of their hits.
fn write<'r>(scene: &Scene, file: &Path, rays: impl Iterator<Item = &'r Ray>) -> io::Result<()> {
    let mut out = io::BufWriter::new(std::fs::File::create(file)?);
    for ray in rays {
        let hit = nearest(scene, ray);
        let t = hit.map_or(f32::INFINITY, |hit| hit.position.distance(ray.from));
        for number in ray.from.to_array().into_iter().chain(ray.direction.to_array()).chain([t]) {
            out.write_all(&number.to_le_bytes())?;
        }
    }
    out.flush()
}

fn uniform(random: &mut Pcg32) -> f64 {
    random.next()
}

fn nearest(scene: &Scene, ray: &Ray) -> Option<Hit> {
    scene.intersect(ray.from, ray.direction, ray.on)
}

/// The hit of a ray, with the normal on the side that the ray comes from.
fn seen_side(scene: &Scene, ray: &Ray) -> Option<Hit> {
    let mut hit = nearest(scene, ray)?;
    if hit.geometric_normal.dot(ray.direction) > 0.0 {
        hit.geometric_normal = -hit.geometric_normal;
    }
    Some(hit)
}

/// As many rays through as many pixels as there are, row by row.
fn camera_rays(scene: &Scene, count: usize) -> Vec<Ray> {
    let camera = &scene.camera;
    let columns = (count as f64).sqrt().ceil() as usize;
    let size = Vec2::new(camera.width as f32, camera.height as f32);
    let ray = |i: usize| {
        let place = Vec2::new((i % columns) as f32, (i / columns) as f32) + 0.5;
        let direction = camera.direction(place / columns as f32 * size);
        Ray { from: camera.origin, on: None, direction, to: None }
    };
    (0..count).map(ray).collect()
}

/// A ray from a hit to the side that it was seen from, all directions alike but for their cosine.
fn scatter(hit: &Hit, random: &mut Pcg32) -> Ray {
    let z = 2.0 * uniform(random) - 1.0;
    let (sine, cosine) = (std::f64::consts::TAU * uniform(random)).sin_cos();
    let r = (1.0 - z * z).sqrt();
    let around = Vec3::new((r * cosine) as f32, (r * sine) as f32, z as f32);
    let direction = (hit.geometric_normal + 0.999 * around).normalize();
    Ray { from: hit.position, on: Some(hit.primitive), direction, to: None }
}

fn segment(a: &Hit, b: &Hit) -> Ray {
    let direction = b.position - a.position;
    Ray { from: a.position, on: Some(a.primitive), direction, to: Some(*b) }
}

/// The same rays by the octant of their directions, and by where they start in a grid of 256³ cells, along a Z curve.
fn sorted(mut rays: Vec<Ray>) -> Vec<Ray> {
    let low = rays.iter().map(|ray| ray.from).fold(Vec3::INFINITY, Vec3::min);
    let high = rays.iter().map(|ray| ray.from).fold(Vec3::NEG_INFINITY, Vec3::max);
    let spread = |x: f32| (0..8).map(|bit| ((x as u32 >> bit) & 1) << (3 * bit)).sum::<u32>();
    rays.sort_by_cached_key(|ray| {
        let cell = (ray.from - low) / (high - low).max(Vec3::splat(f32::MIN_POSITIVE)) * 255.0;
        let place = spread(cell.x) | spread(cell.y) << 1 | spread(cell.z) << 2;
        ray.direction.is_negative_bitmask() << 24 | place
    });
    rays
}

/// Prints the fastest of some rounds.
fn report(name: &str, rounds: usize, rays: &[Ray], found: impl Fn(&Ray) -> bool) {
    let mut least = f64::INFINITY;
    let mut hits = 0;
    for _ in 0..rounds {
        let start = Instant::now();
        hits = cast(rays, &found);
        least = least.min(start.elapsed().as_secs_f64());
    }
    let share = 100.0 * hits as f64 / rays.len() as f64;
    println!("{name:30} {:7.2} M/s, {share:.2} % found", rays.len() as f64 / least * 1e-6);
}

#[inline(never)]
fn cast(rays: &[Ray], found: impl Fn(&Ray) -> bool) -> usize {
    rays.iter().filter(|ray| found(ray)).count()
}
