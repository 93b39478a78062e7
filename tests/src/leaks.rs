//! Rays at the edges and corners of closed rooms, where they would get lost.

use std::path::Path;

use aether_core::{Pcg32, UniformSource};
use glam::Vec3;
use integrators::scene::{Primitive, Scene};

use crate::stability::on_all_threads;

/// What became of rays.
#[derive(Clone, Debug, Default)]
pub struct Leaks {
    /// How many were aimed.
    pub aimed: u64,
    /// How many there were, with those that went on from where they hit.
    pub rays: u64,
    /// How many of them left the room.
    pub lost: u64,
    /// The first of those: where each came from, and in which direction.
    pub first: Vec<String>,
}

impl Leaks {
    fn merge(mut self, other: Leaks) -> Leaks {
        self.aimed += other.aimed;
        self.rays += other.rays;
        self.lost += other.lost;
        self.first.extend(other.first);
        self.first.truncate(5);
        self
    }
}

/// The faces of a cube whose corners have the signs of the three lowest bits of their numbers.
const FACES: [[usize; 4]; 6] =
    [[0, 4, 6, 2], [1, 3, 7, 5], [0, 1, 5, 4], [2, 6, 7, 3], [0, 2, 3, 1], [4, 5, 7, 6]];

/// The division of a room into fans of hundreds of triangles.
pub const FANS: usize = 4;

/// A face of the cube as a fan about its middle, with `n` triangles a side. Points of an edge are the same bits from
/// both of its faces.
fn fan(face: [usize; 4], n: i32) -> String {
    let corner = |i: usize| [0, 1, 2].map(|axis| if face[i % 4] >> axis & 1 == 1 { 1 } else { -1 });
    let middle = [0, 1, 2].map(|axis| (0..4).map(|i| corner(i)[axis]).sum::<i32>() / 4);
    let mut text = format!("v {} {} {}\n", middle[0], middle[1], middle[2]);
    let sides = (0..4).flat_map(|side| (0..n).map(move |k| (side, k)));
    for (side, k) in sides {
        let at = |axis: usize| {
            f64::from(corner(side)[axis] * (n - k) + corner(side + 1)[axis] * k) / f64::from(n)
        };
        text += &format!("v {} {} {}\n", at(0), at(1), at(2));
    }
    // From the last vertex back.
    let last = 4 * n;
    for k in 0..last {
        text += &format!("f {} {} {}\n", -last - 1, k - last, (k + 1) % last - last);
    }
    text
}

/// A cube around places that are no round numbers, seen from inside: each of its first `walls` faces is a fan of two
/// triangles about another of its corners, or of four hundred about its middle if `turn` is [`FANS`].
///
/// # Panics
/// If it cannot be written to a folder for temporary files.
pub fn room(scale: f32, turn: usize, walls: usize) -> Scene {
    let mut obj = String::new();
    for i in 0..8 {
        let sign = |axis: usize| if i >> axis & 1 == 1 { 1 } else { -1 };
        obj += &format!("v {} {} {}\n", sign(0), sign(1), sign(2));
    }
    for (index, face) in FACES.iter().enumerate().take(walls) {
        if turn == FANS {
            obj += &fan(*face, 100);
            continue;
        }
        let corner = |i: usize| face[(i + turn * (index + 1)) % 4] + 1;
        obj += &format!("f {} {} {} {}\n", corner(0), corner(1), corner(2), corner(3));
    }
    let name = format!("aether-room-{}-{scale:e}-{turn}-{walls}.obj", std::process::id());
    let path = std::env::temp_dir().join(name);
    std::fs::write(&path, obj).expect("there is a folder for temporary files");
    let xml = format!(
        "<scene version=\"3.0.0\"><sensor type=\"perspective\"/>
         <shape type=\"obj\"><string name=\"filename\" value=\"{}\"/>
         <boolean name=\"face_normals\" value=\"true\"/><boolean name=\"flip_normals\" value=\"true\"/>
         <transform name=\"to_world\"><rotate x=\"1\" y=\"2\" angle=\"33\"/>
         <translate x=\"5\" y=\"-7\" z=\"3\"/><scale value=\"{scale}\"/></transform></shape></scene>",
        path.display()
    );
    let scene = Scene::from_str(&xml, Path::new(""), &[]).unwrap_or_else(|e| panic!("{e}"));
    let _ = std::fs::remove_file(&path);
    scene
}

/// Rays are shot in parts of so many, by whichever thread is free.
const PART: u64 = 1_000_000;

/// So many rays aimed in closed rooms of three sizes, divided into triangles in five ways.
pub fn leaks(rays: u64) -> Leaks {
    let sizes = [1e-6, 1.0, 1e6];
    let rooms = sizes.iter().flat_map(|&scale| (0..=FANS).map(move |turn| room(scale, turn, 6)));
    let rooms: Vec<Scene> = rooms.collect();
    let each = rays.div_ceil(rooms.len() as u64);
    let parts = each.div_ceil(PART) as usize;
    let all = on_all_threads(rooms.len() * parts, |k| {
        let (room, part) = (k / parts, (k % parts) as u64);
        let mut source = Pcg32::new(12, k as u64, 0);
        // What grazes a sliver that meets others at an edge may begin outside, since its origin is rounded: one in
        // some millions does.
        let onward = if room % (FANS + 1) == FANS { 0 } else { 3 };
        aimed(&rooms[room], PART.min(each - part * PART), onward, &mut source)
    });
    all.into_iter().fold(Leaks::default(), Leaks::merge)
}

fn in_cube(source: &mut Pcg32) -> Vec3 {
    let mut next = || 2.0 * UniformSource::<f32>::next(source) - 1.0;
    Vec3::new(next(), next(), next())
}

/// A direction above a surface, often grazing.
fn leaving(source: &mut Pcg32, normal: Vec3) -> Vec3 {
    let mut d = in_cube(source).normalize_or(normal);
    if UniformSource::<f32>::next(source) < 0.5 {
        d -= normal * d.dot(normal) * 0.999;
    }
    let d = d.normalize_or(normal);
    let d = if d.dot(normal) < 0.0 { d - 2.0 * d.dot(normal) * normal } else { d };
    // Within rounding of the surface there is neither above nor below.
    if d.dot(normal) > 4.0 * f32::EPSILON { d } else { normal }
}

/// So many rays aimed at the edges and corners of a room from within, and from where they meet them on in directions that are
/// often grazing: `onward` times, unless one is lost before.
pub fn aimed(scene: &Scene, rays: u64, onward: usize, source: &mut Pcg32) -> Leaks {
    let middle = 0.5 * (scene.bounds.min + scene.bounds.max);
    let triangles = scene.primitives.iter().filter_map(|p| match *p {
        Primitive::Triangle { v0, v1, v2 } => Some([v0, v1, v2]),
        _ => None,
    });
    let triangles: Vec<[Vec3; 3]> = triangles.collect();
    let mut found = Leaks::default();
    while found.aimed < rays {
        found.aimed += 1;
        let mut next = || UniformSource::<f32>::next(source);
        let triangle = triangles[(next() * triangles.len() as f32) as usize % triangles.len()];
        let edge = (3.0 * next()) as usize % 3;
        // On the edge, towards one end more often than elsewhere.
        let near = if next() < 0.5 { 1 } else { 24 };
        let target = triangle[edge].lerp(triangle[(edge + 1) % 3], next().powi(near));
        // Inside: a cube within the room's inner sphere.
        let mut from = middle + (target - middle).length() * 0.3 * in_cube(source);
        let (mut d, mut on) = (target - from, None);
        for _ in 0..=onward {
            found.rays += 1;
            let Some(hit) = scene.intersect(from, d, on) else {
                found.lost += 1;
                if found.first.len() < 5 {
                    found.first.push(format!("from {from:?} on {on:?}, towards {d:?}"));
                }
                break;
            };
            (from, on) = (hit.position, Some(hit.primitive));
            d = leaving(source, hit.geometric_normal);
        }
    }
    found
}
