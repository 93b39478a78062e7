//! Slivers, fans, cameras in walls, walls in one plane with lights, normals that face away.

use std::fmt::Write;
use std::path::Path;

use integrators::scene::Scene;

use super::{assert_mean, camera, rendered, scene};

/// A furnace: what reflects half and emits half looks like 1 from everywhere, whatever its shape.
const WHITE: &str = r#"<bsdf type="diffuse"><rgb name="reflectance" value="0.5"/></bsdf>
    <emitter type="area"><rgb name="radiance" value="0.5"/></emitter>"#;

/// A mesh in a file of its own, and the shape that reads it.
fn mesh(name: &str, obj: &str) -> String {
    let folder = std::env::temp_dir().join(format!("aether-extremes-{}", std::process::id()));
    std::fs::create_dir_all(&folder).expect("a folder for the mesh");
    let path = folder.join(name);
    std::fs::write(&path, obj).expect("the mesh is written");
    let path = path.display();
    format!(
        r#"<shape type="obj"><string name="filename" value="{path}"/>
            <boolean name="face_normals" value="true"/>{WHITE}</shape>"#
    )
}

/// The cube [0, 2]³ seen from inside, each face a fan of `n` triangles a side round a corner that lies `offset` from
/// the edge at zero: the triangles at that edge are slivers. Next to zero the offset is not rounded away.
fn fans(n: usize, offset: f64) -> String {
    let mut text = String::new();
    let mut count = 0;
    for axis in 0..3 {
        for side in [0.0, 2.0] {
            let mut vertex = |p: f64, q: f64| {
                let mut v = [0.0; 3];
                (v[axis], v[(axis + 1) % 3], v[(axis + 2) % 3]) = (side, p, q);
                writeln!(text, "v {} {} {}", v[0], v[1], v[2]).expect("text");
            };
            vertex(1.0, offset);
            // Round the square, the same points on shared edges of the cube.
            let step = |k: usize| 2.0 * (k as f64) / (n as f64);
            for k in 0..n {
                vertex(step(k), 0.0);
            }
            for k in 0..n {
                vertex(2.0, step(k));
            }
            for k in 0..n {
                vertex(step(n - k), 2.0);
            }
            for k in 0..n {
                vertex(0.0, step(n - k));
            }
            for k in 0..4 * n {
                let (a, b) = (count + 2 + k, count + 2 + (k + 1) % (4 * n));
                // Facing inwards.
                let (a, b) = if side > 0.0 { (b, a) } else { (a, b) };
                writeln!(text, "f {} {a} {b}", count + 1).expect("text");
            }
            count += 1 + 4 * n;
        }
    }
    text
}

fn inside() -> String {
    camera([0.2, -0.3, 0.1], [0.0, 0.5, -0.1], 120.0)
}

#[test]
fn fans_of_slivers_are_a_closed_furnace() {
    // 400 triangles share a corner; those at the edge are 1e9 times as long as they are wide.
    let room = camera([1.2, 0.7, 1.1], [1.0, 1.5, 0.9], 120.0);
    for (n, offset) in [(100, 2e-11), (1, 2e-9), (100, 1.0), (3, 1e-7), (100, 1e-5)] {
        let name = format!("{n}-{offset}.obj");
        let mut scene = scene(&room, 16, -1, &mesh(&name, &fans(n, offset)));
        scene.integrator.rr_depth = 5;
        assert_eq!((scene.primitives.len(), scene.degenerate_triangles), (24 * n, 0));
        let film = rendered(&mut scene, 64, 1);
        assert_mean(&format!("fans of {n}, offset {offset:e}"), &film, 1.0);
    }
}

#[test]
fn triangles_without_area_are_left_out_with_a_count() {
    let obj = "v 0 0 0\nv 1 0 0\nv 2 0 0\nv 0 1 0\nv 1 0 0\nf 1 2 3\nf 1 1 4\nf 2 4 5\nf 1 2 4\n";
    let scene = scene(&inside(), 4, 2, &mesh("flat.obj", obj));
    assert_eq!((scene.primitives.len(), scene.degenerate_triangles), (1, 3));
}

/// A camera exactly on a wall, in a corner of the room, or in the plane of a light looks into a furnace: its own
/// wall is not in its way.
#[test]
fn cameras_in_walls() {
    let room =
        format!(r#"<shape type="cube"><boolean name="flip_normals" value="true"/>{WHITE}</shape>"#);
    for origin in [[1.0, 0.0, 0.0], [1.0, 1.0, -1.0], [0.0, -1.0, 0.25]] {
        let mut scene = scene(&camera(origin, [0.1, 0.2, 0.0], 40.0), 8, -1, &room);
        scene.integrator.rr_depth = 5;
        let film = rendered(&mut scene, 256, 1);
        assert_mean(&format!("a camera at {origin:?}"), &film, 1.0);
    }
}

/// The index of refraction of air.
const AIR: f64 = 1.000_277;

/// A camera enclosed by a solid sees its inside and nothing of the light outside: black where its surface is matt and has
/// one side, the light where it shines inwards, and through glass the square of its index times what is around.
#[test]
fn cameras_inside_of_solids() {
    let sky = r#"<emitter type="constant"><rgb name="radiance" value="1"/></emitter>"#;
    let matt = r#"<bsdf type="diffuse"/>"#;
    let glass = r#"<bsdf type="dielectric"><float name="int_ior" value="1.5"/></bsdf>"#;
    let shining = r#"<boolean name="flip_normals" value="true"/>
        <emitter type="area"><rgb name="radiance" value="1"/></emitter>"#;
    let solids = [
        ("cube", matt, 0.0),
        ("sphere", matt, 0.0),
        ("cube", shining, 1.0),
        ("sphere", shining, 1.0),
        ("sphere", glass, 2.25 / AIR.powi(2)),
    ];
    for (size, (kind, surface, expected)) in
        [1.0, 1e-6].into_iter().flat_map(|s| solids.map(|k| (s, k)))
    {
        let solid = format!(
            r#"<shape type="{kind}"><transform name="to_world"><scale value="{size}"/></transform>{surface}</shape>"#
        );
        let eye = camera([0.2 * size, 0.1 * size, 0.0], [1.0, 0.3, 0.2], 70.0);
        let mut scene = scene(&eye, 8, 200, &(sky.to_owned() + &solid));
        scene.integrator.rr_depth = 1000;
        assert_mean(
            &format!("inside a {kind} of {size:e}"),
            &rendered(&mut scene, 64, 1),
            expected,
        );
    }
}

/// A light in the plane of a wall, on it and beside it: the wall gets nothing from it, so that each sample is
/// black or the light itself, and beside it the mean is the part of the picture that the light covers.
#[test]
fn a_light_in_the_plane_of_a_wall() {
    let (samples, radiance) = (256, 3.0);
    for beside in [0.0, 1.5] {
        let elements = format!(
            r#"<shape type="rectangle">
                <bsdf type="diffuse"><rgb name="reflectance" value="0.5"/></bsdf></shape>
            <shape type="rectangle"><transform name="to_world"><scale value="0.5"/>
                <translate x="0" y="{beside}" z="0"/></transform>
                <bsdf type="diffuse"><rgb name="reflectance" value="0.5"/></bsdf>
                <emitter type="area"><rgb name="radiance" value="{radiance}"/></emitter></shape>"#
        );
        let mut scene = scene(&camera([0.0, -2.0, 2.0], [0.0; 3], 70.0), 16, 4, &elements);
        let film = rendered(&mut scene, samples, 1);
        for pixel in film.pixels() {
            let seen = pixel.mean()[0] / radiance * f64::from(samples);
            assert!((seen - seen.round()).abs() < 1e-4, "{beside}: {seen} samples are light");
        }
        if beside > 0.0 {
            assert_mean("beside the wall", &film, radiance * covered(beside));
        }
    }
}

/// The part of the picture of the camera above that a square of side one round (0, y, 0) covers, by the middles
/// of a fine grid.
fn covered(y: f64) -> f64 {
    let n = 2000;
    let (root, tangent) = (0.5f64.sqrt(), 35f64.to_radians().tan());
    let at = |i: usize| tangent * ((2 * i + 1) as f64 / n as f64 - 1.0);
    let hits = |(a, b): (f64, f64)| {
        // From (0, -2, 2), ahead is (0, 1, -1) and up (0, 1, 1), over the root of two.
        let [along, down] = [root * (1.0 + b), root * (1.0 - b)];
        let distance = 2.0 / down;
        (distance * a).abs() < 0.5 && (distance * along - 2.0 - y).abs() < 0.5
    };
    let grid = (0..n * n).map(|i| (at(i % n), at(i / n)));
    grid.filter(|point| hits(*point)).count() as f64 / (n * n) as f64
}

/// Shading normals that face away from the viewer or lie in the surface: dark perhaps, never NaN and
/// never brighter than in a furnace, where all is 0.5 + 0.5. Five standard errors of a pixel: one chance in
/// three thousand that one of the pixels fails for no reason.
#[test]
fn shading_normals_that_face_away() {
    let obj = "v -1 -1 0\nv 1 -1 0\nv 1 1 0\nv -1 1 0\nvn 0 0 -1\nvn 1 0 0\nvn 0 0 1\nvn 0 1 1e-20\n\
               f 1//1 2//2 3//3\nf 1//1 3//3 4//4\n";
    let bent = mesh("bent.obj", obj).replace(r#"<boolean name="face_normals" value="true"/>"#, "");
    let sky = format!(
        r#"<shape type="sphere"><boolean name="flip_normals" value="true"/>
            <float name="radius" value="10"/>{WHITE}</shape>"#
    );
    for origin in [[0.0, 0.0, 3.0], [3.0, 0.0, 1e-4], [0.0, 0.0, -3.0], [2.0, 1.0, 0.0]] {
        let mut scene =
            scene(&camera(origin, [0.1, 0.0, 0.0], 60.0), 16, 6, &(sky.clone() + &bent));
        let film = rendered(&mut scene, 64, 1);
        for pixel in film.pixels() {
            let mean = pixel.mean()[0];
            let error = pixel.variance_of_mean().expect("two samples a pixel")[0].sqrt();
            assert!(
                (0.0..=1.0 + 5.0 * error + 1e-5).contains(&mean),
                "{origin:?}: {mean} +- {error}"
            );
        }
    }
}

/// The file is refused where single precision cannot compute with it, and says so.
#[test]
fn coordinates_out_of_range_are_an_error() {
    let huge = r#"<scene version="3.0.0"><sensor type="perspective"/><shape type="sphere">
        <float name="radius" value="1e30"/></shape></scene>"#;
    let error = Scene::from_str(huge, Path::new("."), &[]).err().expect("refused").to_string();
    assert!(error.contains("too small or too large") && error.contains("scene.xml:"), "{error}");
}
