//! What is in a scene, for people and for programs.

use std::collections::BTreeMap;
use std::fmt::Write;

use glam::{DVec3, Vec3};
use serde_json::{Value, json};

use super::camera::Projection;
use super::{Filter, Scene, ShapeKind, Sky};
use crate::kind;
use crate::vertex::SceneVertex;

const KINDS: [ShapeKind; 8] = [
    ShapeKind::Rectangle,
    ShapeKind::Cube,
    ShapeKind::Sphere,
    ShapeKind::Disk,
    ShapeKind::Cylinder,
    ShapeKind::Obj,
    ShapeKind::Ply,
    ShapeKind::Serialized,
];

/// The scene in JSON. Vectors are arrays, power is π · area · radiance summed over the primitives
/// of a shape, `max_depth` is null if unlimited, `bounds` is null if there are no primitives.
pub fn json(scene: &Scene) -> Value {
    let kinds = KINDS.iter().map(|kind| {
        let count = scene.shapes.iter().filter(|s| s.kind == *kind).count();
        (kind.name().to_owned(), json!(count))
    });
    let kinds = kinds.filter(|(_, count)| *count != json!(0));
    let bounds = (!scene.primitives.is_empty()).then(
        || json!({"min": place(scene, scene.bounds.min), "max": place(scene, scene.bounds.max)}),
    );
    let camera = &scene.camera;
    json!({
        "shapes": kinds.collect::<serde_json::Map<_, _>>(),
        "primitives": scene.primitives.len(),
        "smooth_triangles": scene.normals.len(),
        "degenerate_triangles": scene.degenerate_triangles,
        "bsdfs": bsdfs(scene).into_iter().map(|(name, n)| (name.to_owned(), json!(n)))
            .collect::<serde_json::Map<_, _>>(),
        "emitters": emitters(scene),
        "lights": {
            "constant": usize::from(matches!(scene.sky, Some(Sky::Constant(_)))),
            "envmap": usize::from(matches!(scene.sky, Some(Sky::Picture(_)))),
            "point": scene.bulbs.iter().filter(|bulb| bulb.cone.is_none()).count(),
            "spot": scene.bulbs.iter().filter(|bulb| bulb.cone.is_some()).count(),
            "directional": scene.distant.len(),
        },
        "kind": kind_of(scene).map(|kind| json!({
            "name": kind.name,
            "vertex_bytes": kind.vertex,
            "has": kind.has,
            "left_out": kind.left_out,
        })),
        "camera": {
            "type": camera.projection.name(),
            "origin": place(scene, camera.origin),
            "forward": vector(camera.forward),
            "up": vector(camera.up),
            "right": vector(camera.right),
            "fov_x": 2.0 * f64::from(camera.tan_x).atan().to_degrees(),
        },
        "film": {
            "width": scene.film.width,
            "height": scene.film.height,
            "filter": scene.film.filter.name(),
            "filter_radius": number(scene.film.filter.radius()),
        },
        "sampler": {
            "type": scene.sampler.kind.name(),
            "sample_count": scene.sampler.sample_count,
            "seed": scene.sampler.seed,
        },
        "integrator": {
            "type": scene.integrator.name,
            "max_depth": scene.integrator.max_depth,
            "rr_depth": scene.integrator.rr_depth,
            "hide_emitters": scene.integrator.hide_emitters,
        },
        "bounds": bounds,
    })
}

/// The scene in a few lines of text.
pub fn summary(scene: &Scene) -> String {
    let mut text = String::new();
    // Writing to a string cannot fail.
    let mut line = |name: &str, value: String| {
        let _ = writeln!(text, "{name:<12}{value}");
    };
    let in_file = |point: Vec3| scene.in_file(point).as_vec3();
    let kinds = KINDS.iter().filter_map(|kind| {
        let count = scene.shapes.iter().filter(|s| s.kind == *kind).count();
        (count > 0).then(|| format!("{count} {}", kind.name()))
    });
    let kinds: Vec<String> = kinds.collect();
    line("shapes", format!("{} ({})", scene.shapes.len(), kinds.join(", ")));
    let smooth = scene.normals.len();
    let dropped = scene.degenerate_triangles;
    line(
        "primitives",
        format!("{} ({smooth} smooth, {dropped} degenerate left out)", scene.primitives.len()),
    );
    let materials = bsdfs(scene).into_iter().map(|(name, count)| format!("{count} {name}"));
    line("materials", materials.collect::<Vec<_>>().join(", "));
    for shape in emissive_shapes(scene) {
        let [r, g, b] = shape.power;
        let power = format!("power {r:.4} {g:.4} {b:.4} over {} primitives", shape.primitives);
        line("emitter", format!("{}: {power}", shape.name));
    }
    let bulbs = scene.bulbs.len();
    for (count, name) in [
        (usize::from(scene.sky.is_some()), "sky"),
        (bulbs, "point"),
        (scene.distant.len(), "parallel"),
    ] {
        if count > 0 {
            line("light", format!("{count} {name}"));
        }
    }
    let camera = &scene.camera;
    let fov = 2.0 * camera.tan_x.atan().to_degrees();
    line(
        "camera",
        match camera.projection {
            Projection::Orthographic { .. } => {
                format!("orthographic, at {} towards {}", in_file(camera.origin), camera.forward)
            }
            other => format!(
                "{} at {} towards {}, {fov:.2}° wide",
                other.name(),
                in_file(camera.origin),
                camera.forward
            ),
        },
    );
    line(
        "film",
        format!("{} x {}, {}", scene.film.width, scene.film.height, filter(scene.film.filter)),
    );
    let sampler = &scene.sampler;
    line(
        "sampler",
        format!(
            "{}, {} per pixel, seed {}",
            sampler.kind.name(),
            sampler.sample_count,
            sampler.seed
        ),
    );
    let integrator = &scene.integrator;
    let depth = integrator.max_depth.map_or("unlimited".to_owned(), |d| d.to_string());
    line(
        "integrator",
        format!("{}, max depth {depth}, roulette from {}", integrator.name, integrator.rr_depth),
    );
    if let Some(kind) = kind_of(scene) {
        let Kind { name, vertex, has, .. } = &kind;
        line("kind", format!("{name}, {vertex} bytes a vertex: {}", has.join(", ")));
        line("left out", kind.left_out.join(", "));
    }
    if !scene.primitives.is_empty() {
        line("bounds", format!("{} to {}", in_file(scene.bounds.min), in_file(scene.bounds.max)));
    }
    text
}

/// How many materials there are of each plugin type.
fn bsdfs(scene: &Scene) -> BTreeMap<&'static str, usize> {
    let mut counts = BTreeMap::new();
    for bsdf in &scene.bsdfs {
        *counts.entry(bsdf.name()).or_default() += 1;
    }
    counts
}

/// What a render of a scene is compiled for.
struct Kind {
    name: &'static str,
    /// Bytes of a vertex.
    vertex: usize,
    has: Vec<&'static str>,
    left_out: Vec<&'static str>,
}

/// The smallest precompiled kind that covers a scene.
fn kind_of(scene: &Scene) -> Option<Kind> {
    struct Describe;
    impl kind::WithKind for Describe {
        type Output = Kind;
        fn with<K: kind::SceneKind>(self) -> Result<Kind, kind::NotCovered> {
            let (has, left_out) = kind::FEATURES.iter().partition(|name| kind::has::<K>(name));
            let vertex = size_of::<SceneVertex<K>>();
            Ok(Kind { name: K::NAME, vertex, has, left_out })
        }
    }
    kind::named(kind::smallest(scene), Describe)?.ok()
}

fn filter(filter: Filter) -> String {
    match filter {
        Filter::Box => "box filter".to_owned(),
        Filter::Tent { radius } => format!("tent filter, radius {radius}"),
        Filter::Gaussian { stddev } => format!("gaussian filter, stddev {stddev}"),
        Filter::Cubic { b, c } => format!("{} filter, B {b}, C {c}", filter.name()),
        Filter::Lanczos { lobes } => format!("lanczos filter, {lobes} lobes"),
    }
}

struct EmissiveShape<'a> {
    name: &'a str,
    kind: ShapeKind,
    radiance: Vec3,
    primitives: u32,
    area: f64,
    power: [f64; 3],
}

fn emissive_shapes(scene: &Scene) -> impl Iterator<Item = EmissiveShape<'_>> {
    scene.shapes.iter().filter_map(|shape| {
        let radiance = shape.emission?.value;
        let first = shape.first_primitive as usize;
        let primitives = &scene.primitives[first..first + shape.primitive_count as usize];
        let area: f64 = primitives.iter().map(|p| f64::from(p.area())).sum();
        let power = radiance.to_array();
        Some(EmissiveShape {
            name: &shape.name,
            kind: shape.kind,
            radiance,
            primitives: shape.primitive_count,
            area,
            power: power.map(|channel| std::f64::consts::PI * area * f64::from(channel)),
        })
    })
}

fn emitters(scene: &Scene) -> Vec<Value> {
    let shapes = emissive_shapes(scene).map(|shape| {
        json!({
            "shape": shape.name,
            "kind": shape.kind.name(),
            "primitives": shape.primitives,
            "area": shape.area,
            "radiance": vector(shape.radiance),
            "power": shape.power,
        })
    });
    shapes.collect()
}

/// A point in the world of the file.
fn place(scene: &Scene, point: Vec3) -> Value {
    if scene.origin == DVec3::ZERO {
        return vector(point);
    }
    json!(scene.in_file(point).to_array())
}

fn vector(v: Vec3) -> Value {
    Value::Array(v.to_array().map(number).to_vec())
}

/// The shortest decimal that reads back as the same f32, rather than its digits in f64.
fn number(x: f32) -> Value {
    json!(x.to_string().parse::<f64>().unwrap_or(f64::from(x)))
}
