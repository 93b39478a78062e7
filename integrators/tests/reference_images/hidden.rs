//! Lamps that the camera is not to see, before a wall that they light: it sees the wall.

use std::path::Path;

use integrators::algorithm::Algorithm;
use integrators::image::RgbImage;
use integrators::image::block_test::holm;
use integrators::metropolis::Metropolis;
use integrators::primary_sample::PrimarySample;
use integrators::scene::Scene;

use super::algorithms::p_values;
use super::furnaces::{SIDE, image, integrators};
use super::scenes::Reference;

/// The chance that the means of images fail for no reason, over the seeds.
const FALSE_ALARM_RATE: f64 = 1e-4;
/// Renders of each integrator.
const SEEDS: u64 = 16;

/// Half the side of the square of the wall that is seen, which lies 3 behind the lamp and 8 before the camera.
const HALF: f64 = 1.4;

/// The sensors: all see the same square of the wall.
fn sensors() -> [(&'static str, String); 3] {
    let fov = 2.0 * (HALF / 8.0).atan().to_degrees();
    let look = r#"<lookat origin="0,0,5" target="0,0,0" up="0,1,0"/>"#;
    // In focus is the wall.
    let lens =
        r#"<float name="aperture_radius" value="0.3"/><float name="focus_distance" value="8"/>"#;
    [
        (
            "perspective",
            format!(
                r#"<float name="fov" value="{fov}"/><transform name="to_world">{look}</transform>"#
            ),
        ),
        (
            "thinlens",
            format!(
                r#"<float name="fov" value="{fov}"/>{lens}<transform name="to_world">{look}</transform>"#
            ),
        ),
        (
            "orthographic",
            format!(
                r#"<transform name="to_world"><scale x="{HALF}" y="{HALF}"/>{look}</transform>"#
            ),
        ),
    ]
}

/// A ball with a radiance of one before a wall that reflects half of the light.
fn scene(sensor: &str, placed: &str) -> Scene {
    let xml = format!(
        r#"<scene version="3.0.0">
        <integrator type="path"><integer name="max_depth" value="3"/><boolean name="hide_emitters" value="true"/>
            <string name="portal" value="opening"/></integrator>
        <sensor type="{sensor}">{placed}<sampler type="independent"/>
            <film type="hdrfilm"><integer name="width" value="{SIDE}"/><integer name="height" value="{SIDE}"/>
                <rfilter type="box"/></film>
        </sensor>
        <shape type="rectangle" id="opening"><transform name="to_world"><scale value="2"/><translate z="-2"/>
            </transform></shape>
        <shape type="rectangle"><transform name="to_world"><scale value="5"/><translate z="-3"/></transform>
            <bsdf type="diffuse"/></shape>
        <shape type="sphere"><emitter type="area"><float name="radiance" value="1"/></emitter></shape></scene>"#
    );
    Scene::from_str(&xml, Path::new("."), &[]).unwrap_or_else(|error| panic!("{error}"))
}

/// The mean radiance of the square. The ball, of radius one, gives a point at a distance r the irradiance π cos θ / r²,
/// of which the integral over the square is π times the solid angle that the square fills as seen from the ball's centre.
fn answer() -> f64 {
    let (a, h) = (HALF, 3.0);
    let solid_angle = 4.0 * (a * a / (h * (h * h + 2.0 * a * a).sqrt())).atan();
    0.5 * solid_angle / (4.0 * a * a)
}

#[test]
fn every_integrator_sees_what_is_behind_hidden_lamps() {
    let (mut p, mut weak) = (Vec::new(), Vec::new());
    let filled = |value: f64| RgbImage::filled(SIDE, SIDE, [value as f32; 3]);
    let expected =
        |factor: f64| Reference { rgb: filled(factor * answer()), variance: filled(0.0) };
    for (sensor, placed) in sensors() {
        let scene = scene(sensor, &placed);
        let mut all: Vec<_> =
            integrators(&scene).into_iter().map(|(name, _, algorithm)| (name, algorithm)).collect();
        // With direct light by their chains too.
        for (_, algorithm) in all.clone() {
            match algorithm {
                Algorithm::Metropolis(it) => all.push((
                    "chained mlt",
                    Algorithm::Metropolis(Metropolis { direct: false, ..it }),
                )),
                Algorithm::PrimarySample(it) => {
                    let it = PrimarySample { direct: false, ..it };
                    all.push(("chained pssmlt", Algorithm::PrimarySample(it)))
                }
                _ => {}
            }
        }
        for (name, algorithm) in all {
            let samples = match name {
                "ptracer" => 256,
                "ppm" => 256,
                "vpl" => 64,
                "chained mlt" | "chained pssmlt" => 16,
                _ => 8,
            };
            let render = |seed| image(algorithm.clone(), &scene, samples, seed + 60);
            let images: Vec<RgbImage> = (0..SEEDS).map(render).collect();
            let what = format!("{sensor} by {name}");
            p.extend(p_values(&what, &expected(1.0), &images, SIDE));
            for factor in [0.9, 1.1] {
                let least = p_values(&what, &expected(factor), &images, SIDE);
                let noticed = least.iter().any(|p| *p < FALSE_ALARM_RATE / 100.0);
                if !noticed {
                    weak.push(format!(
                        "{what}: an image that is {factor} times the right one passes"
                    ));
                }
            }
        }
    }
    assert!(weak.is_empty(), "{weak:#?}");
    assert!(!holm(&p, FALSE_ALARM_RATE).contains(&true));
}
