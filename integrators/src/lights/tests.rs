//! Every light: sampling it and finding it by scattering give the same mean.

use std::f32::consts::PI;
use std::path::Path;

use aether_core::discrete::Discrete;
use aether_core::{Estimator, Pcg32};
use glam::{DMat4, Vec3};

use crate::chi_square::{FINE, FINER, SHARP, Sampled, deviation};
use crate::emission::sample_emission;
use crate::image::RgbImage;
use crate::integrand::Radiance;
use crate::kind::Everything;
use crate::path::PathArena;
use crate::scene::envmap::EnvironmentMap;
use crate::scene::{Filter, Scene, Sky};
use crate::strategies::{Aim, sample_bsdf, sample_camera, sample_camera_direction, sample_light};
use crate::vertex::{Eye, Lamp, Place, SceneVertex};
use crate::world::World;

const SAMPLES: u32 = 40_000;
const ALBEDO: f32 = 0.6;

/// A matte floor at z = 0, seen from above in its middle, and lights.
fn scene(lights: &str) -> Scene {
    let xml = format!(
        r#"<scene version="3.0.0"><sensor type="perspective"><float name="fov" value="0.001"/>
        <transform name="to_world"><lookat origin="0.1,0,0.2" target="0,0,0" up="0,1,0"/></transform>
        <film type="hdrfilm"><integer name="width" value="1"/><integer name="height" value="1"/>
            <rfilter type="box"/></film></sensor>
        <shape type="rectangle"><bsdf type="diffuse">
            <rgb name="reflectance" value="{ALBEDO}"/></bsdf></shape>{lights}</scene>"#
    );
    Scene::from_str(&xml, Path::new("."), &[]).unwrap_or_else(|error| panic!("{error}"))
}

/// The mean light that the floor reflects from a light directly, and the variance of that mean; the last
/// vertex is found by sampling lights or by scattering.
fn direct(scene: &Scene, by_light: bool, samples: u32) -> (f64, f64) {
    direct_of(&World::new(scene).unwrap(), by_light, samples)
}

fn direct_of(world: &World<'_, Everything>, by_light: bool, samples: u32) -> (f64, f64) {
    let mut arena = PathArena::new();
    let (mut sum, mut squares) = (0.0, 0.0);
    for sample in 0..samples {
        arena.clear();
        let mut path = arena.sequence();
        path.append(sample_camera(world))
            .append(sample_camera_direction(world, Aim::Pixel((0, 0))));
        if by_light {
            path.append(sample_light(world));
        } else {
            path.append(sample_bsdf(world, 1000, None));
        }
        path.sample(&mut Pcg32::new(5, u64::from(by_light), u64::from(sample)));
        let estimator = Estimator::paths(Radiance::new(world));
        let radiance = estimator.of(&path) * estimator.integrand().response((0, 0), &path);
        let value = f64::from(radiance.element_sum());
        (sum, squares) = (sum + value, squares + value * value);
    }
    let n = f64::from(samples);
    (sum / n, (squares / n - (sum / n).powi(2)) / (n - 1.0))
}

fn area(kind: &str, to_world: &str) -> String {
    format!(
        r#"<shape type="{kind}"><transform name="to_world">{to_world}</transform>
        <emitter type="area"><rgb name="radiance" value="1,2,3"/></emitter></shape>"#
    )
}

const DOWN: &str = r#"<rotate x="1" angle="180"/>"#;

#[test]
fn lights_are_sampled_as_they_are_found() {
    let square = |more: &str| area("rectangle", &format!("{DOWN}{more}"));
    let checked = square(r#"<translate x="0.3" z="1"/>"#).replace(
        r#"<rgb name="radiance" value="1,2,3"/>"#,
        r#"<texture name="radiance" type="checkerboard"><rgb name="color0" value="1,0.5,0.2"/>
            <transform name="to_uv"><scale x="2" y="3"/></transform></texture>"#,
    );
    let cubes = (0..3).map(|k| {
        let place = format!(r#"<scale value="0.2"/><translate x="{}" y="0.3" z="0.7"/>"#, k - 1);
        area("cube", &place)
    });
    let cubes: String = cubes.collect();
    // Walls all around, with corners above and below each other.
    let walls = area("cube", r#"<scale x="1.5" z="1.1"/><translate x="0.3" z="1"/>"#)
        .replace("<emitter", r#"<boolean name="flip_normals" value="true"/><emitter"#);
    let constant = r#"<emitter type="constant"/>"#;
    let mut scenes = vec![
        ("a sphere", scene(&area("sphere", r#"<scale value="0.6"/><translate x="0.4" z="1"/>"#))),
        ("a disk", scene(&area("disk", &format!(r#"{DOWN}<translate x="0.4" z="0.8"/>"#)))),
        ("a square near by", scene(&square(r#"<rotate y="1" angle="30"/><translate z="0.9"/>"#))),
        ("a square far away", scene(&square(r#"<scale value="2"/><translate z="9"/>"#))),
        ("a square with a pattern", scene(&checked)),
        ("walls", scene(&walls)),
        ("many triangles", scene(&cubes)),
        ("many triangles and a sky", scene(&(cubes + constant))),
        ("a sky", scene(constant)),
        ("a picture of the sky", scene(constant)),
    ];
    let image = RgbImage::from_fn(9, 6, |x, y| [((5 * x + 3 * y) % 8) as f32, 1.0, 0.0]);
    let map = EnvironmentMap::new(image, 0.3, &DMat4::from_rotation_x(0.9)).unwrap();
    scenes.last_mut().unwrap().1.sky = Some(Sky::Picture(map));
    for (what, scene) in &scenes {
        let (light, light_variance) = direct(scene, true, SAMPLES);
        // A far light is seldom found.
        let samples = if what.contains("far") { 10 * SAMPLES } else { SAMPLES };
        let (found, found_variance) = direct(scene, false, samples);
        let error = (light_variance + found_variance).sqrt();
        let z = (light - found) / error;
        println!("{what}: {light:.4} {found:.4}, {z:.2} standard errors of {:.1e}", error / found);
        // False alarms: one in 1500 for all of them, for one of these seeds.
        assert!(z.abs() < 4.0, "{what}: {light} sampled, {found} found, {z} standard errors");
        // An error of five percent would be noticed.
        assert!((1.05 * light - found).abs() > 4.0 * error || what.contains("far"), "{what}");
    }
}

/// The directions in which a light is sampled.
#[test]
fn samples_of_lights_have_the_densities_that_they_say() {
    let triangle = r#"<shape type="ply"><string name="filename" value="../tests/scenes/meshes/octahedron.ply"/>
        <transform name="to_world"><scale value="0.6"/><translate z="0.8"/></transform>
        <emitter type="area"/></shape>"#;
    let place = r#"<scale value="0.5"/><rotate x="1" angle="140"/><translate x="0.2" z="0.9"/>"#;
    let sky = r#"<emitter type="constant"/>"#;
    let cubes: String = (0..3)
        .map(|k| {
            area("cube", &format!(r#"<scale value="0.2"/><translate x="{}" z="0.7"/>"#, k - 1))
        })
        .collect();
    let image = RgbImage::from_fn(9, 6, |x, y| [((5 * x + 3 * y) % 8) as f32, 1.0, 0.0]);
    let picture = EnvironmentMap::new(image, 0.3, &DMat4::from_rotation_x(0.9)).unwrap();
    let mut off = Vec::new();
    for (seed, (what, lights)) in (1..).zip([
        ("a rectangle", area("rectangle", place)),
        ("a sphere", area("sphere", place)),
        ("a disk", area("disk", place)),
        ("a cylinder", area("cylinder", place)),
        ("triangles", triangle.to_owned()),
        ("many triangles and a sky", cubes + sky),
        ("a sky", sky.to_owned()),
        ("a picture of the sky", sky.to_owned()),
    ]) {
        let mut scene = scene(&lights);
        if what.starts_with("a picture") {
            scene.sky = Some(Sky::Picture(picture.clone()));
        }
        let world = &World::new(&scene).unwrap();
        let down = |from: Vec3| world.trace(from, Vec3::NEG_Z, None).expect("the floor is below");
        // On the floor, and next to the lamp, or within it if it is closed.
        let floor = SceneVertex::on(down(Vec3::new(-0.7, 0.1, 0.1)));
        let bare = |p: [f32; 3]| SceneVertex::eye(Eye::Pinhole(p.into()));
        for here in [floor, bare([0.2, -0.13, 0.75])] {
            let sampled = Sampled { world, strategy: sample_light(world), path: vec![here] };
            let z = sampled.deviation(seed, SHARP);
            println!("{z:.1} standard deviations: {what} from {}", here.position);
            if z > 5.0 {
                off.push((z, what, here.position));
            }
        }
    }
    // One of all would be that far off once in a hundred thousand runs.
    assert!(off.is_empty(), "{off:#?}");
    // A lamp that is a little larger is told apart.
    let [a, b] = [0.5, 0.52].map(|radius| {
        scene(&area("sphere", &format!(r#"<scale value="{radius}"/><translate z="0.9"/>"#)))
    });
    let [a, b] = [&a, &b].map(|scene| World::new(scene).unwrap());
    let [a, b] = [&a, &b].map(|world| {
        let here = SceneVertex::eye(Eye::Pinhole(Vec3::new(0.4, 0.0, 0.2)));
        Sampled { world, strategy: sample_light(world), path: vec![here] }
    });
    assert!(deviation(&a.counts(1), &b.expected(SHARP)) > 5.0);
}

/// The directions in which lights shine and cameras look, inside a large ball.
#[test]
fn starts_of_paths_have_the_densities_that_they_say() {
    let xml = r#"<scene version="3.0.0">
        <sensor type="thinlens"><float name="fov" value="100"/><float name="aperture_radius" value="0.5"/>
            <float name="focus_distance" value="2"/>
            <transform name="to_world"><lookat origin="0,0,0" target="3,2,1" up="0,0,1"/></transform>
            <film type="hdrfilm"><integer name="width" value="5"/><integer name="height" value="5"/></film>
        </sensor>
        <emitter type="spot"><float name="cutoff_angle" value="50"/></emitter><emitter type="point"/>
        <shape type="rectangle"><transform name="to_world"><rotate x="1" angle="20"/><translate z="-5"/></transform>
            <emitter type="area"/></shape>
        <shape type="sphere"><float name="radius" value="20"/></shape></scene>"#;
    let mut scene = Scene::from_str(xml, Path::new("."), &[]).unwrap();
    let mut off = Vec::new();
    let mut note = |what: String, z: f64| {
        println!("{z:.1} standard deviations: {what}");
        if z > 5.0 {
            off.push((z, what));
        }
    };
    {
        let world = &World::new(&scene).unwrap();
        let lamp = world.trace(Vec3::ZERO, Vec3::NEG_Z, None).expect("the lamp is below");
        let bulb = |index| SceneVertex::lamp(Lamp::Bulb(index));
        for (what, light) in [("a cone", 0), ("a point", 1)]
            .map(|(what, index)| (what, bulb((index, world.scene.bulbs[index as usize].position))))
            .into_iter()
            .chain([("a surface", SceneVertex::on(lamp))])
        {
            let sampled = Sampled { world, strategy: sample_emission(world), path: vec![light] };
            note(format!("light of {what}"), sampled.deviation(1, FINE));
        }
    }
    let filters = [
        Filter::Box,
        Filter::Tent { radius: 2.0 },
        Filter::Gaussian { stddev: 0.5 },
        Filter::Cubic { b: 0.0, c: 0.5 },
        Filter::Lanczos { lobes: 3 },
    ];
    for filter in filters {
        scene.film.filter = filter;
        let world = &World::new(&scene).unwrap();
        let lens = world.lens().expect("there is a lens");
        let eye = SceneVertex { position: lens.centre + 0.4 * lens.across, place: Place::Camera };
        let strategy = sample_camera_direction(world, Aim::Pixel((2, 2)));
        let sampled = Sampled { world, strategy, path: vec![eye] };
        note(format!("a camera with {filter:?}"), sampled.deviation(1, FINER));
    }
    assert!(off.is_empty(), "{off:#?}");
}

#[test]
fn lights_that_are_atoms_have_their_closed_answers() {
    let answers = [
        (
            r#"<emitter type="point"><point name="position" x="1" y="2" z="2"/>
            <rgb name="intensity" value="3"/></emitter>"#,
            3.0 * (2.0 / 3.0) / 9.0,
        ),
        (
            r#"<emitter type="spot"><rgb name="intensity" value="4"/><float name="cutoff_angle" value="30"/>
            <transform name="to_world"><lookat origin="0,3,4" target="0,0,0" up="1,0,0"/></transform>
            </emitter>"#,
            4.0 * 0.8 / 25.0,
        ),
        (
            r#"<emitter type="directional"><vector name="direction" x="0" y="3" z="-4"/>
            <rgb name="irradiance" value="2"/></emitter>"#,
            2.0 * 0.8,
        ),
    ];
    for (light, irradiance) in answers {
        let (found, _) = direct(&scene(light), true, 4);
        let expected = f64::from(3.0 * irradiance * ALBEDO / PI);
        assert!((found / expected - 1.0).abs() < 1e-4, "{light}: {found}, not {expected}");
    }
    // Next to other lights, chosen by their power.
    let all: String = answers.iter().map(|(light, _)| *light).collect();
    let (found, variance) = direct(&scene(&all), true, SAMPLES);
    let sum = answers.iter().map(|(_, irradiance)| irradiance).sum::<f32>();
    let expected = f64::from(3.0 * sum * ALBEDO / PI);
    assert!((found - expected).abs() < 4.0 * variance.sqrt(), "{found}, not {expected}");
}

/// Many lights chosen by the hierarchy and by power alone light a place alike.
#[test]
fn the_hierarchy_and_power_agree() {
    let lamps: String = (0..40)
        .map(|k| {
            let (turn, reach) = (0.7 * k as f32, 0.3 + 0.15 * k as f32);
            let place = Vec3::new(reach * turn.cos(), reach * turn.sin(), 0.4);
            area(
                "sphere",
                &format!(
                    r#"<scale value="0.05"/><translate x="{}" y="{}" z="{}"/>"#,
                    place.x, place.y, place.z
                ),
            )
        })
        .collect();
    let scene = scene(&lamps);
    let by_place = direct(&scene, true, SAMPLES);
    let by_power = {
        let mut world = World::<Everything>::new(&scene).unwrap();
        assert!(world.lights.hierarchy.is_some());
        world.lights.hierarchy = None;
        direct_of(&world, true, SAMPLES)
    };
    let error = (by_place.1 + by_power.1).sqrt();
    let z = (by_place.0 - by_power.0) / error;
    println!(
        "{:.4} {:.4}: {z:.2}; variances {:.1e} {:.1e}",
        by_place.0, by_power.0, by_place.1, by_power.1
    );
    assert!(z.abs() < 4.0, "{by_place:?} by place, {by_power:?} by power: {z} standard errors");
    assert!(by_place.1 < by_power.1);
}

/// Of a few lights each has a probability at every place; together they make one, and sampling keeps to them.
#[test]
fn probabilities_of_a_few_lights_are_those_of_sampling() {
    let lamps: String = (0..5)
        .map(|k| {
            area(
                "sphere",
                &format!(r#"<scale value="0.{}"/><translate x="{}" z="1"/>"#, k + 1, 3 * k),
            )
        })
        .collect();
    let scene = scene(&lamps);
    let world = World::<Everything>::new(&scene).unwrap();
    let here = SceneVertex::eye(Eye::Pinhole(Vec3::new(0.5, 0.2, 3.0)));
    let choice = world.lights.seen_from(&here).expect("lights");
    let of = |index| choice.get(index).expect("a light").probability;
    let probabilities: Vec<f32> = (0..5).map(of).collect();
    assert!((probabilities.iter().sum::<f32>() - 1.0).abs() < 1e-5, "{probabilities:?}");
    assert!(probabilities.iter().all(|p| *p > 0.099), "{probabilities:?}");
    let mut found = [0; 5];
    const TRIES: u32 = 20_000;
    for k in 0..TRIES {
        let (light, rest) = choice.sample_reuse((k as f32 + 0.5) / TRIES as f32);
        assert!((0.0..1.0).contains(&rest));
        assert!((light.probability / of(light.index) - 1.0).abs() < 1e-5);
        found[light.index] += 1;
    }
    for (count, p) in found.iter().zip(&probabilities) {
        assert!((*count as f32 / TRIES as f32 - p).abs() < 1e-3, "{found:?}, {probabilities:?}");
    }
}
