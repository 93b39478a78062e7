//! A million lights: what a hierarchy costs, and what it saves.
//!
//!     cargo run --release -p examples --bin many_lights [COUNT]
//!
//! Small triangles that shine hang at random over a floor. Points of the floor choose one of them, in
//! proportion to power and by the hierarchy, and estimate the light that arrives, shadows aside.

use std::error::Error;
use std::io::Write;
use std::path::Path;
use std::time::Instant;

use aether_core::discrete::Discrete;
use aether_core::{Pcg32, UniformSource};
use glam::Vec3;
use integrators::lights::{Form, Light, Selection};
use integrators::scene::{Primitive, Scene};
use integrators::scene_kind;
use integrators::vertex::SceneVertex;
use integrators::world::World;

scene_kind! {
    /// Matte surfaces and lamps.
    struct Rooms: Diffuse, Area;
}

/// How many choices are timed.
const CHOICES: u32 = 300_000;

/// A uniform number from 0 to `size`.
fn below(size: f32, random: &mut Pcg32) -> f32 {
    size * UniformSource::<f32>::next(random)
}

/// Writes triangles over the square [-50, 50]², some of them far larger than others.
fn write_lamps(path: &Path, count: u32) -> std::io::Result<()> {
    let mut file = std::io::BufWriter::new(std::fs::File::create(path)?);
    write!(file, "ply\nformat binary_little_endian 1.0\nelement vertex {}\n", 3 * count)?;
    write!(file, "property float x\nproperty float y\nproperty float z\nelement face {count}\n")?;
    write!(file, "property list uchar int vertex_indices\nend_header\n")?;
    let mut random = Pcg32::new(1, 0, 0);
    for _ in 0..count {
        let mut next = |size| below(size, &mut random);
        let corner = Vec3::new(next(100.0) - 50.0, next(100.0) - 50.0, 0.5 + next(20.0));
        let size = 0.01 + 0.2 * next(1.0).powi(8);
        let offset = |a: f32, b: f32, c: f32| size * Vec3::new(a - 0.5, b - 0.5, c - 0.5);
        let second = corner + offset(next(1.0), next(1.0), next(1.0));
        let third = corner + offset(next(1.0), next(1.0), next(1.0));
        for number in [corner, second, third].iter().flat_map(|v| v.to_array()) {
            file.write_all(&number.to_le_bytes())?;
        }
    }
    for face in 0..count {
        file.write_all(&[3])?;
        for corner in 0..3 {
            file.write_all(&(3 * face + corner).to_le_bytes())?;
        }
    }
    file.flush()
}

/// The memory of this program in megabytes, where the system tells.
fn megabytes() -> f64 {
    let pages = std::fs::read_to_string("/proc/self/statm").ok();
    let pages = pages.and_then(|text| text.split(' ').nth(1)?.parse::<f64>().ok());
    pages.map_or(f64::NAN, |pages| pages * 4096.0 / 1e6)
}

/// The light that the middle of a lamp sends to a point of the floor, per what one of power sends.
fn arrives(scene: &Scene, light: &Light<Rooms>, at: Vec3) -> f64 {
    let Light::Area(lamp) = light else { return 0.0 };
    let Form::Single(Primitive::Triangle { v0, v1, v2 }) = lamp.shape else { return 0.0 };
    let middle = (v0 + v1 + v2) / 3.0;
    let normal = scene.normal(integrators::scene::PrimitiveId(lamp.emitter.primitive), middle);
    let (way, squared) = ((at - middle).normalize(), at.distance_squared(middle));
    f64::from(lamp.emitter.area * normal.dot(way).max(0.0) * (-way.z).max(0.0) / squared)
}

/// Nanoseconds a choice, and the variance of one estimate over the square of its mean, in the mean over the
/// points.
fn measure<'w>(
    scene: &Scene,
    points: &[SceneVertex<Rooms>],
    choice: impl Fn(&SceneVertex<Rooms>) -> Selection<'w, Rooms>,
) -> (f64, f64) {
    let each = CHOICES as usize / points.len();
    let mut random = Pcg32::new(2, 0, 0);
    let start = Instant::now();
    let mut sum = 0.0;
    for point in points {
        for _ in 0..each {
            sum += choice(point).sample(below(1.0, &mut random)).probability;
        }
    }
    assert!(sum > 0.0);
    let time = start.elapsed().as_secs_f64() * 1e9 / (points.len() * each) as f64;
    let mut spread = 0.0;
    for point in points {
        let (mut first, mut second) = (0.0, 0.0);
        for _ in 0..each {
            let chosen = choice(point).sample(below(1.0, &mut random));
            let estimate =
                arrives(scene, chosen.item, point.position) / f64::from(chosen.probability);
            first += estimate;
            second += estimate * estimate;
        }
        let mean = first / each as f64;
        spread += (second / each as f64 / (mean * mean) - 1.0) / points.len() as f64;
    }
    (time, spread)
}

fn main() -> Result<(), Box<dyn Error>> {
    let count = std::env::args().nth(1).map_or(Ok(1_000_000), |text| text.parse())?;
    let folder = std::env::temp_dir();
    let name = format!("aether-lamps-{}.ply", std::process::id());
    write_lamps(&folder.join(&name), count)?;
    let xml = format!(
        r#"<scene version="3.0.0">
        <sensor type="perspective"><transform name="to_world">
            <lookat origin="0,0,30" target="0,0,0" up="0,1,0"/></transform></sensor>
        <shape type="rectangle"><transform name="to_world"><scale value="60"/></transform>
            <bsdf type="diffuse"/></shape>
        <shape type="ply"><string name="filename" value="{name}"/>
            <emitter type="area"><rgb name="radiance" value="1"/></emitter></shape></scene>"#
    );
    let scene = Scene::from_str(&xml, &folder, &[]);
    std::fs::remove_file(folder.join(&name))?;
    let (scene, before) = (scene?, megabytes());
    let start = Instant::now();
    let world = World::<Rooms>::new(&scene)?;
    println!("{} lights", scene.emitters.len());
    println!("built in {:.2} s", start.elapsed().as_secs_f64());
    println!("{:.0} MB for the lights, of {:.0} MB", megabytes() - before, megabytes());

    let eye = SceneVertex::eye(world.eye());
    let mut random = Pcg32::new(3, 0, 0);
    let mut points = Vec::new();
    while points.len() < 30 {
        let (x, y) = (below(2.0, &mut random) - 1.0, below(2.0, &mut random) - 1.0);
        let way = Vec3::new(x, y, -1.0).normalize();
        // The floor, not a lamp.
        let seen = world.trace(eye.position, way, None).map(SceneVertex::on);
        points.extend(seen.filter(|v| v.surface().is_some_and(|s| s.emitter.is_none())));
    }
    let by_power = world.lights.choice.as_ref().ok_or("no lights")?;
    let (time, spread) = measure(&scene, &points, |_| Selection::ByPower(by_power));
    println!("by power:        {time:.0} ns a choice, relative variance {spread:.1}");
    let by_place = |point: &SceneVertex<Rooms>| {
        world.lights.seen_from(point).unwrap_or(Selection::ByPower(by_power))
    };
    let (time, spread) = measure(&scene, &points, by_place);
    println!("by the hierarchy: {time:.0} ns a choice, relative variance {spread:.1}");
    Ok(())
}
