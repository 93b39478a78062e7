//! Rays against brute force, at all scales, and at the places where they leak.

use std::path::Path;

use glam::{DVec3, Vec3};

use super::packet::{Packet, Ray};
use super::segment::{End, On, RawHit};
use super::simd::{At, Eight, LANES, Plain, Task};
use super::trace::Tracer;
use super::{Hit, Primitive, PrimitiveId, Scene};

/// A reproducible stream of uniforms (SplitMix64).
struct Random(u64);

impl Random {
    fn uniform(&mut self) -> f32 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((z ^ (z >> 31)) >> 40) as f32 / (1u64 << 24) as f32
    }

    fn in_cube(&mut self) -> Vec3 {
        Vec3::new(self.uniform(), self.uniform(), self.uniform()) * 2.0 - 1.0
    }

    fn direction(&mut self) -> Vec3 {
        loop {
            let v = self.in_cube();
            if v.length() > 0.1 && v.length() < 1.0 {
                return v.normalize();
            }
        }
    }
}

fn icosphere(subdivisions: u32) -> Vec<[Vec3; 3]> {
    let g = 0.5 * (1.0 + 5f32.sqrt());
    let mut corners = Vec::new();
    for (a, b) in [(1.0, g), (1.0, -g), (-1.0, g), (-1.0, -g)] {
        corners.extend([[a, b, 0.0], [0.0, a, b], [b, 0.0, a]].map(Vec3::from_array));
    }
    // The faces of an icosahedron are the triples of corners at distance 2.
    let near = |a: Vec3, b: Vec3| (a.distance(b) - 2.0).abs() < 1e-3;
    let mut triangles = Vec::new();
    for i in 0..12 {
        for j in 0..i {
            for k in 0..j {
                let [a, b, c] = [corners[i], corners[j], corners[k]];
                if near(a, b) && near(b, c) && near(c, a) {
                    let outside = (b - a).cross(c - a).dot(a) > 0.0;
                    let [b, c] = if outside { [b, c] } else { [c, b] };
                    triangles.push([a, b, c].map(Vec3::normalize));
                }
            }
        }
    }
    for _ in 0..subdivisions {
        let split = |[a, b, c]: &[Vec3; 3]| {
            // Sums commute, so both neighbours of an edge find the same middle.
            let (ab, bc, ca) = (a + b, b + c, c + a);
            let [ab, bc, ca] = [ab, bc, ca].map(Vec3::normalize);
            [[*a, ab, ca], [ab, *b, bc], [ca, bc, *c], [ab, bc, ca]]
        };
        triangles = triangles.iter().flat_map(split).collect();
    }
    triangles
}

fn primitives(triangles: &[[Vec3; 3]]) -> Vec<Primitive> {
    let triangle = |[v0, v1, v2]: &[Vec3; 3]| Primitive::Triangle { v0: *v0, v1: *v1, v2: *v2 };
    triangles.iter().map(triangle).collect()
}

fn free(point: Vec3) -> End {
    End { point, on: None }
}

type Start = (End, Option<On>);

/// Whether rays meet anything, as tasks of the machine.
enum Query {
    Ray(Start, Vec3),
    Segment(Start, Start),
}

impl Task for (&Tracer, Query) {
    type Output = bool;

    fn run<E: Eight>(self, at: At<'_, E>) -> bool {
        match self.1 {
            Query::Ray(from, direction) => self.0.is_open::<E>(at, from, direction),
            Query::Segment(from, to) => self.0.unoccluded::<E>(at, from, to),
        }
    }
}

impl Task for (&Tracer, Start, Vec3) {
    type Output = Option<RawHit>;

    fn run<E: Eight>(self, at: At<'_, E>) -> Option<RawHit> {
        self.0.nearest::<E>(at, self.1, self.2)
    }
}

fn nearest(tracer: &Tracer, from: End, on: Option<On>, direction: Vec3) -> Option<RawHit> {
    tracer.machine().run((tracer, (from, on), direction))
}

fn is_open(tracer: &Tracer, from: End, on: Option<On>, direction: Vec3) -> bool {
    tracer.machine().run((tracer, Query::Ray((from, on), direction)))
}

fn unoccluded(tracer: &Tracer, from: Start, to: Start) -> bool {
    tracer.machine().run((tracer, Query::Segment(from, to)))
}

#[test]
fn no_ray_leaks_through_edges_or_corners() {
    let triangles = icosphere(4);
    assert_eq!(triangles.len(), 5120);
    let mut random = Random(1);
    for (scale, offset) in [(1.0, Vec3::ZERO), (1e-3, Vec3::new(5.0, -3.0, 0.1))] {
        let moved: Vec<[Vec3; 3]> =
            triangles.iter().map(|t| t.map(|v| v * scale + offset)).collect();
        let primitives = primitives(&moved);
        let tracer = Tracer::new(&primitives, offset);
        let mut leaks = 0;
        for round in 0..12 {
            for [a, b, c] in &moved {
                let s = random.uniform();
                let targets = [*a, a.lerp(*b, s), b.lerp(*c, s), c.lerp(*a, 0.5)];
                let inside = offset + random.in_cube() * (0.5 * scale);
                let outside = offset + random.direction() * (3.0 * scale);
                for target in targets {
                    // From inside every ray must hit. From outside only those that do not aim at
                    // the silhouette: the centre is on the line, nearly.
                    let from = if round % 4 == 0 { offset } else { inside };
                    leaks += u32::from(nearest(&tracer, free(from), None, target - from).is_none());
                    let through = 0.5 * (target + offset);
                    let hit = nearest(&tracer, free(outside), None, through - outside);
                    leaks += u32::from(hit.is_none());
                }
            }
        }
        assert_eq!(leaks, 0, "scale {scale}");
    }
}

#[test]
fn edge_functions_tell_which_side_is_met() {
    let mut random = Random(5);
    let mut met = [0; 2];
    for _ in 0..2000 {
        let triangles: Vec<[Vec3; 3]> =
            (0..LANES).map(|_| [0; 3].map(|_| random.in_cube())).collect();
        let numbered = triangles.iter().enumerate().map(|(i, t)| (PrimitiveId(i as u32), *t));
        let packet = Packet::new(numbered);
        let ray = Ray::new(random.in_cube(), random.direction());
        let nothing = [u32::MAX; 2];
        let Some(found) = packet.meet::<Plain>((), &ray, nothing, f32::MAX) else { continue };
        for (lane, [a, b, c]) in triangles.iter().enumerate() {
            let rise = (b - a).cross(c - a).dot(ray.direction);
            if found.met >> lane & 1 == 1 && rise.abs() > 1e-4 {
                assert_eq!(found.rises >> lane & 1 == 1, rise > 0.0, "{ray:?}, {a} {b} {c}");
                met[usize::from(rise > 0.0)] += 1;
            }
        }
    }
    assert!(met.iter().all(|&met| met > 500), "{met:?}");
}

fn mixed_primitives(random: &mut Random) -> Vec<Primitive> {
    let mut list = Vec::new();
    for _ in 0..60 {
        let c = random.in_cube();
        let (a, b) = (0.3 * random.in_cube(), 0.3 * random.in_cube());
        list.push(Primitive::Triangle { v0: c, v1: c + a, v2: c + b });
        let center = random.in_cube();
        list.push(Primitive::Sphere {
            center,
            radius: 0.01 + 0.1 * random.uniform(),
            flipped: false,
        });
        list.push(Primitive::Cylinder {
            base: random.in_cube(),
            axis: 0.3 * random.in_cube(),
            radius: 0.01 + 0.1 * random.uniform(),
            flipped: false,
        });
        let [u_axis, v_axis] = [0.15 * random.in_cube(), 0.15 * random.in_cube()];
        list.push(Primitive::Disk {
            center: random.in_cube(),
            normal: u_axis.cross(v_axis).normalize(),
            u_axis,
            v_axis,
        });
    }
    list
}

/// The distance of the nearest hit in plain f64, and how far from the edge of its primitive it is.
fn brute_force(primitives: &[Primitive], o: Vec3, d: Vec3) -> Option<(usize, f64)> {
    let (o, d) = (o.as_dvec3(), d.as_dvec3().normalize());
    let distance = |primitive: &Primitive| match *primitive {
        Primitive::Triangle { v0, v1, v2 } => {
            let [a, b, c] = [v0, v1, v2].map(Vec3::as_dvec3);
            let (e1, e2) = (b - a, c - a);
            let p = d.cross(e2);
            let u = (o - a).dot(p) / e1.dot(p);
            let v = d.dot((o - a).cross(e1)) / e1.dot(p);
            let t = e2.dot((o - a).cross(e1)) / e1.dot(p);
            (u >= 0.0 && v >= 0.0 && u + v <= 1.0).then_some(t)
        }
        Primitive::Sphere { center, radius, .. } => {
            let oc = o - center.as_dvec3();
            let b = oc.dot(d);
            let root = (b * b - oc.length_squared() + f64::from(radius).powi(2)).sqrt();
            [-b - root, -b + root].into_iter().find(|t| *t > 0.0)
        }
        Primitive::Cylinder { base, axis, radius, .. } => {
            let (axis, o) = (axis.as_dvec3(), o - base.as_dvec3());
            let height = |v: DVec3| v.dot(axis) / axis.length_squared();
            let [p, q] = [o, d].map(|v| v - height(v) * axis);
            let (a, b, c) = (q.dot(q), p.dot(q), p.dot(p) - f64::from(radius).powi(2));
            let root = (b * b - a * c).sqrt();
            let between = |t: &f64| *t > 0.0 && (0.0..=1.0).contains(&height(o + *t * d));
            [(-b - root) / a, (-b + root) / a].into_iter().find(between)
        }
        Primitive::Disk { center, u_axis, v_axis, .. } => {
            let [u, v] = [u_axis.as_dvec3(), v_axis.as_dvec3()];
            let m = glam::DMat3::from_cols(u, v, -d).inverse();
            let local = m * (o - center.as_dvec3());
            (local.truncate().length() <= 1.0).then_some(local.z)
        }
    };
    let hits = primitives.iter().enumerate();
    let hits = hits.filter_map(|(i, p)| distance(p).map(|t| (i, t)));
    hits.filter(|(_, t)| *t > 0.0).min_by(|a, b| a.1.total_cmp(&b.1))
}

#[test]
fn nearest_hits_agree_with_brute_force() {
    let mut random = Random(2);
    let primitives = mixed_primitives(&mut random);
    let tracer = Tracer::new(&primitives, Vec3::ZERO);
    let (mut hits, mut differences) = (0, 0);
    for _ in 0..20_000 {
        let (o, d) = (1.5 * random.in_cube(), random.direction());
        let found = nearest(&tracer, free(o), None, d);
        match (found, brute_force(&primitives, o, d)) {
            (None, None) => {}
            (Some(hit), Some((index, t))) if hit.primitive.0 as usize == index => {
                hits += 1;
                let error = (f64::from(hit.t) - t).abs();
                let (Primitive::Sphere { radius, .. } | Primitive::Cylinder { radius, .. }) =
                    primitives[index]
                else {
                    // Grazing hits amplify rounding.
                    assert!(error < 1e-4, "{error}");
                    continue;
                };
                assert!(error < 1e-5 * (1.0 + t / f64::from(radius)), "{error}");
            }
            _ => differences += 1,
        }
    }
    assert!(hits > 2_500, "{hits}");
    // Only rays within rounding of an edge may differ.
    assert!(differences <= 3, "{differences}");
}

#[test]
fn occlusion_agrees_with_the_nearest_hit() {
    let mut random = Random(3);
    let primitives = mixed_primitives(&mut random);
    let tracer = Tracer::new(&primitives, Vec3::ZERO);
    let (mut blocked, mut differences) = (0, 0);
    for _ in 0..20_000 {
        let (a, b) = (random.in_cube(), random.in_cube());
        let first = nearest(&tracer, free(a), None, b - a);
        let expected = first.is_none_or(|hit| hit.t >= a.distance(b));
        let found = unoccluded(&tracer, (free(a), None), (free(b), None));
        blocked += u32::from(!found);
        differences += u32::from(found != expected);
    }
    assert!(blocked > 2_000, "{blocked}");
    assert!(differences <= 2, "{differences}");
}

#[test]
fn hits_do_not_depend_on_the_unit_of_length() {
    let mut random = Random(4);
    let primitives = mixed_primitives(&mut random);
    let reference = Tracer::new(&primitives, Vec3::ZERO);
    for scale in [1e-6, 1e-3, 0.25, 3.0, 1e3, 1e6] {
        let enlarged: Vec<Primitive> = primitives.iter().map(|p| enlarge(p, scale)).collect();
        let tracer = Tracer::new(&enlarged, Vec3::ZERO);
        let mut differences = 0;
        for _ in 0..5_000 {
            let (o, d) = (1.5 * random.in_cube(), random.direction());
            let expected = nearest(&reference, free(o), None, d);
            let found = nearest(&tracer, free(o * scale), None, d);
            match (expected, found) {
                (None, None) => {}
                (Some(a), Some(b)) if a.primitive == b.primitive => {
                    assert!((a.t * scale - b.t).abs() < 2e-4 * scale, "{scale}: {a:?} {b:?}");
                }
                _ => differences += 1,
            }
        }
        // Scaling by 0.25 is exact; else rays within rounding of an edge may differ.
        assert!(differences <= if scale == 0.25 { 0 } else { 3 }, "{scale}: {differences}");
    }
}

#[test]
fn hits_do_not_depend_on_the_machine() {
    let mut random = Random(22);
    let mut primitives = mixed_primitives(&mut random);
    // Corners that rays from the origin meet exactly, and walls to start on.
    primitives.extend(self::primitives(&icosphere(2)));
    let here = Tracer::new(&primitives, Vec3::ZERO);
    let anywhere = Tracer::new(&primitives, Vec3::ZERO).on_any_machine();
    let all = |hit: RawHit| (hit.primitive, hit.t, hit.weights);
    let bits = |(id, t, w): (PrimitiveId, f32, Vec3)| (id, [t, w.x, w.y, w.z].map(f32::to_bits));
    for i in 0..20_000 {
        let index = i % primitives.len();
        let (d, to) = (random.direction(), random.in_cube());
        let (from, on) = match primitives[index] {
            Primitive::Triangle { v0, v1, v2 } if i % 4 != 0 => {
                let on = Some(PrimitiveId(index as u32));
                let normal = (v1 - v0).cross(v2 - v0).normalize();
                let surface = On::new(&primitives[index], normal);
                (End { point: (v0 + v1 + v2) / 3.0, on }, Some(surface))
            }
            Primitive::Triangle { v0, .. } => (free(v0 * 0.25), None),
            _ => (free(random.in_cube()), None),
        };
        let found = [&here, &anywhere].map(|tracer| {
            let first = nearest(tracer, from, on, d).map(all).map(bits);
            let open = is_open(tracer, from, on, d);
            // The nearest hit and whether there is any are one question.
            assert_eq!(open, first.is_none(), "{from:?} {d}");
            (first, unoccluded(tracer, (from, on), (free(to), None)))
        });
        assert_eq!(found[0], found[1], "{from:?} {d}");
    }
}

fn enlarge(primitive: &Primitive, scale: f32) -> Primitive {
    let mut result = *primitive;
    match &mut result {
        Primitive::Triangle { v0, v1, v2 } => [v0, v1, v2].into_iter().for_each(|v| *v *= scale),
        Primitive::Sphere { center, radius, .. } => {
            *center *= scale;
            *radius *= scale;
        }
        Primitive::Cylinder { base, axis, radius, .. } => {
            *base *= scale;
            *axis *= scale;
            *radius *= scale;
        }
        Primitive::Disk { center, u_axis, v_axis, .. } => {
            [center, u_axis, v_axis].into_iter().for_each(|v| *v *= scale)
        }
    }
    result
}

fn scene(shapes: &str) -> Scene {
    let xml = format!("<scene version=\"3.0.0\"><sensor type=\"perspective\"/>{shapes}</scene>");
    Scene::from_str(&xml, Path::new(""), &[]).unwrap()
}

/// A closed room of two-triangle walls with a sphere in it, far from the origin.
fn room(scale: f32) -> Scene {
    scene(&format!(
        "<shape type=\"cube\"><boolean name=\"flip_normals\" value=\"true\"/>
         <transform name=\"to_world\"><rotate x=\"1\" y=\"2\" angle=\"33\"/>
         <translate x=\"5\" y=\"-7\" z=\"3\"/><scale value=\"{scale}\"/></transform></shape>
         <shape type=\"sphere\"><transform name=\"to_world\"><scale value=\"0.3\"/>
         <translate x=\"5\" y=\"-7\" z=\"3\"/><scale value=\"{scale}\"/></transform></shape>"
    ))
}

/// A direction above the surface, often grazing.
fn leaving(random: &mut Random, normal: Vec3) -> Vec3 {
    let mut d = random.direction();
    if random.uniform() < 0.5 {
        d -= normal * d.dot(normal) * 0.999;
    }
    let d = d.normalize();
    let d = if d.dot(normal) < 0.0 { d - 2.0 * d.dot(normal) * normal } else { d };
    // Within rounding of the surface there is neither above nor below.
    if d.dot(normal) > 4.0 * f32::EPSILON { d } else { normal }
}

#[test]
fn surfaces_do_not_hit_themselves() {
    for scale in [1e-6, 1.0, 1e6] {
        let scene = room(scale);
        let mut random = Random(5);
        let center = (f64::from(scale) * DVec3::new(5.0, -7.0, 3.0) - scene.origin).as_vec3();
        let mut last: Option<Hit> = None;
        let (mut escaped, mut near, mut hidden) = (0, 0, 0);
        for _ in 0..100_000 {
            let hit = match last {
                Some(from) => {
                    let d = leaving(&mut random, from.geometric_normal);
                    scene.intersect(from.position, d, Some(from.primitive))
                }
                None => scene.intersect(center, random.direction(), None),
            };
            let Some(hit) = hit else {
                escaped += 1;
                last = None;
                continue;
            };
            if let Some(from) = last {
                // In this convex room a hit on the same wall is a false one; neighbours in a
                // corner are met at any distance, but not along the same normal.
                near += u32::from(from.geometric_normal.dot(hit.geometric_normal) > 0.9999);
                let (a, b) = (from.position, hit.position);
                let (p, q) = (Some(from.primitive), Some(hit.primitive));
                // Rounded off to grazing, either answer is right.
                let steep = |h: &Hit| {
                    let d = (b - a).normalize_or_zero();
                    d.dot(h.geometric_normal).abs() > 1e-2
                };
                if a.distance(b) > 1e-3 * scale && steep(&from) && steep(&hit) {
                    hidden += u32::from(!scene.visible(a, p, b, q));
                    hidden += u32::from(!scene.visible(b, q, a, p));
                }
            }
            last = Some(hit);
        }
        assert_eq!((escaped, near, hidden), (0, 0, 0), "scale {scale}");
    }
}

#[test]
fn spheres_are_left_through_the_other_side() {
    let scene = scene("<shape type=\"sphere\"/>");
    let id = Some(PrimitiveId(0));
    let top = Vec3::Z;
    let hit = scene.intersect(top, -Vec3::Z, id).unwrap();
    assert_eq!((hit.t, hit.position, hit.geometric_normal), (2.0, -Vec3::Z, -Vec3::Z));
    assert_eq!(scene.intersect(top, Vec3::Z, id), None);
    assert_eq!(scene.intersect(top, Vec3::X, id), None);
    let inside = scene.intersect(Vec3::ZERO, Vec3::new(0.0, 3.0, 0.0), None).unwrap();
    assert_eq!((inside.t, inside.position), (1.0, Vec3::Y));
    // A chord is free, the way through the sphere to something beyond it is not.
    assert!(scene.visible(top, id, Vec3::X, id));
    assert!(scene.visible(top, id, Vec3::new(0.0, 0.0, 0.5), None));
    assert!(!scene.visible(top, id, Vec3::new(0.0, 0.0, -2.0), None));
    assert!(!scene.visible(Vec3::new(0.0, 0.0, -2.0), None, top, id));
    assert!(scene.visible(Vec3::new(0.0, 0.0, 2.0), None, top, id));
    assert!(scene.visible(Vec3::ZERO, None, top, id));
    assert!(!scene.visible(2.0 * Vec3::X, None, -2.0 * Vec3::X, None));
}

#[test]
fn cylinders_are_left_through_the_other_side_or_an_end() {
    let scene =
        scene("<shape type=\"cylinder\"><point name=\"p0\" x=\"0\" y=\"0\" z=\"-1\"/></shape>");
    let id = Some(PrimitiveId(0));
    let side = Vec3::X;
    let hit = scene.intersect(side, -Vec3::X, id).unwrap();
    assert_eq!((hit.t, hit.position, hit.geometric_normal), (2.0, -Vec3::X, -Vec3::X));
    assert_eq!(scene.intersect(side, Vec3::new(-1.0, 0.0, 1.0), id), None);
    assert_eq!(scene.intersect(side, Vec3::X, id), None);
    assert_eq!(scene.intersect(side, Vec3::Z, id), None);
    // From outside through an end to the inside, and past it.
    let slanted = Vec3::new(1.0, 0.0, -1.0);
    let inside = scene.intersect(Vec3::new(-0.5, 0.0, 2.0), slanted, None).unwrap();
    assert!((inside.position - Vec3::new(1.0, 0.0, 0.5)).length() < 1e-6);
    assert_eq!(scene.intersect(Vec3::new(-0.5, 0.0, 3.0), slanted, None), None);
    assert_eq!(scene.intersect(Vec3::ZERO, Vec3::Z, None), None);
    assert!(scene.visible(side, id, -Vec3::X, id));
    assert!(scene.visible(side, id, Vec3::new(0.0, 0.0, 3.0), None));
    assert!(!scene.visible(side, id, Vec3::new(-3.0, 0.0, 0.0), None));
    assert!(!scene.visible(Vec3::new(-3.0, 0.0, 0.0), None, side, id));
}

#[test]
fn round_surfaces_do_not_hit_themselves() {
    for scale in [1e-6, 1.0, 1e6] {
        // A closed drum: a cylinder with two disks.
        let scene = scene(&format!(
            "<shape type=\"cylinder\"><boolean name=\"flip_normals\" value=\"true\"/>
             <point name=\"p1\" x=\"2\" y=\"1\" z=\"-1\"/>
             <transform name=\"to_world\"><translate x=\"5\"/><scale value=\"{scale}\"/></transform></shape>
             <shape type=\"sphere\"><boolean name=\"flip_normals\" value=\"true\"/>
             <point name=\"center\" x=\"1\" y=\"0.5\" z=\"-0.5\"/><float name=\"radius\" value=\"3\"/>
             <transform name=\"to_world\"><translate x=\"5\"/><scale value=\"{scale}\"/></transform></shape>"
        ));
        let center = (f64::from(scale) * DVec3::new(6.0, 0.5, -0.5) - scene.origin).as_vec3();
        let mut random = Random(8);
        let (mut last, mut escaped, mut near): (Option<Hit>, u32, u32) = (None, 0, 0);
        for _ in 0..50_000 {
            let mut cosine = 0.0;
            let hit = match last {
                Some(from) => {
                    let side = if random.uniform() < 0.5 { 1.0 } else { -1.0 };
                    let side = if from.primitive.0 == 1 { 1.0 } else { side };
                    let d = leaving(&mut random, side * from.geometric_normal);
                    cosine = d.dot(from.geometric_normal).abs();
                    scene.intersect(from.position, d, Some(from.primitive))
                }
                None => scene.intersect(center, random.direction(), None),
            };
            escaped += u32::from(hit.is_none());
            if let (Some(from), Some(hit)) = (&last, &hit) {
                // A surface is met again only across its inside.
                let same = from.primitive == hit.primitive;
                near += u32::from(same && cosine > 1e-5 && hit.t < 1e-6 * scale);
            }
            last = hit;
        }
        assert_eq!((escaped, near), (0, 0), "scale {scale}");
    }
}

#[test]
fn bad_rays_hit_nothing() {
    let scene = scene("<shape type=\"sphere\"/><shape type=\"cube\"/>");
    for bad in [Vec3::NAN, Vec3::INFINITY, Vec3::new(0.0, f32::NAN, 1.0)] {
        assert_eq!(scene.intersect(bad, Vec3::X, None), None);
        assert_eq!(scene.intersect(Vec3::ZERO, bad, None), None);
        assert!(!scene.visible(bad, None, Vec3::ZERO, None));
    }
    assert_eq!(scene.intersect(Vec3::ZERO, Vec3::ZERO, None), None);
    assert!(scene.visible(Vec3::ZERO, None, Vec3::ZERO, None));
    let empty = self::scene("");
    assert_eq!(empty.intersect(Vec3::ZERO, Vec3::X, None), None);
    assert!(empty.visible(Vec3::ZERO, None, Vec3::X, None));
}

#[test]
fn many_coincident_primitives_are_no_trouble() {
    let triangle = [Vec3::ZERO, Vec3::X, Vec3::Y];
    let primitives = primitives(&[triangle; 20_000]);
    let tracer = Tracer::new(&primitives, Vec3::ZERO);
    let hit = nearest(&tracer, free(Vec3::new(0.2, 0.2, 1.0)), None, -Vec3::Z).unwrap();
    assert!((hit.t - 1.0).abs() < 1e-6);
    let weights = DVec3::new(0.6, 0.2, 0.2);
    assert!((hit.weights.as_dvec3() - weights).length() < 1e-6);
}

#[test]
fn hits_on_slivers_of_any_length_lie_on_their_rays() {
    // Turned by a quarter, the floor is level to rounding only.
    for width in ["1e3", "1e8", "1e15"] {
        let scene = scene(&format!(
            "<shape type=\"rectangle\"><transform name=\"to_world\"><rotate x=\"1\" angle=\"-90\"/>\
             <scale x=\"{width}\" y=\"1\" z=\"3\"/></transform></shape>"
        ));
        let origin = Vec3::new(0.3, 1.9, 2.5);
        let mut random = Random(21);
        for _ in 0..200 {
            let d = Vec3::new(random.uniform() - 0.5, -1.0, 0.2 - 1.4 * random.uniform());
            let d = d.normalize();
            let hit = scene.intersect(origin, d, None).expect("the floor");
            let exact = -origin.y / d.y;
            assert!((hit.t / exact - 1.0).abs() < 1e-3, "{width}: {} instead of {exact}", hit.t);
            assert!(hit.position.distance(origin + exact * d) < 1e-2, "{width}: {hit:?}");
        }
    }
}
