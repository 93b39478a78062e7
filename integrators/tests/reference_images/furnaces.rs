//! Rooms without contrast, whose images are known, through every integrator.

use std::path::Path;

use integrators::algorithm::Algorithm;
use integrators::bidirectional::Bidirectional;
use integrators::gradient_domain::{GradientDomain, reconstructed};
use integrators::image::RgbImage;
use integrators::image::block_test::holm;
use integrators::instant_radiosity::InstantRadiosity;
use integrators::light_tracer::LightTracer;
use integrators::metropolis::Metropolis;
use integrators::photon_mapping::PhotonMapping;
use integrators::poisson::Reconstruction;
use integrators::portals::Portals;
use integrators::primary_sample::PrimarySample;
use integrators::render::{Budget, Layer, RenderSettings, render};
use integrators::scene::Scene;
use integrators::tridirectional::Tridirectional;
use integrators::vertex_merging::VertexMerging;

use super::algorithms::p_values;
use super::scenes::{Reference, settings};

/// The chance that the means, or the quarters, of images fail for no reason, over the seeds.
const FALSE_ALARM_RATE: f64 = 1e-4;
/// Renders of each integrator.
const SEEDS: u64 = 32;
/// The side of the images.
pub const SIDE: usize = 12;

/// A scene with a portal, which is no surface: a square of 2 by 2 that is transformed.
pub fn with_portal(
    max_depth: i32,
    (fov, look): (u32, &str),
    portal: &str,
    contents: &str,
) -> Scene {
    let xml = format!(
        r#"<scene version="3.0.0">
        <integrator type="path"><integer name="max_depth" value="{max_depth}"/>
            <string name="portal" value="opening"/></integrator>
        <sensor type="perspective">
            <float name="fov" value="{fov}"/><transform name="to_world"><lookat {look} up="0,1,0"/></transform>
            <sampler type="independent"/>
            <film type="hdrfilm"><integer name="width" value="{SIDE}"/><integer name="height" value="{SIDE}"/>
                <rfilter type="box"/></film>
        </sensor>
        <shape type="rectangle" id="opening"><transform name="to_world">{portal}</transform></shape>
        {contents}</scene>"#
    );
    Scene::from_str(&xml, Path::new("."), &[]).unwrap_or_else(|error| panic!("{error}"))
}

/// A scene without contrast, and with a portal somewhere.
fn furnace(max_depth: i32, look: &str, contents: &str) -> Scene {
    let portal = r#"<scale value="0.5"/><rotate y="1" angle="90"/>"#;
    with_portal(max_depth, (100, look), portal, contents)
}

/// Two balls that reflect all light, under a sky of radiance one: each sees the sky or the other ball, which is
/// as bright. Round surfaces with light as dense everywhere, so that photons within a radius show no bias.
fn open() -> (Scene, [f32; 3]) {
    let ball = |x: f32| {
        format!(
            r#"<shape type="sphere"><point name="center" x="{x}" y="0" z="0"/>
            <bsdf type="diffuse"><rgb name="reflectance" value="1"/></bsdf></shape>"#
        )
    };
    let balls = [ball(-1.2), ball(1.2)].concat();
    let sky = r#"<emitter type="constant"><rgb name="radiance" value="1"/></emitter>"#;
    let scene = furnace(-1, r#"origin="0,0.5,4" target="0,0,0""#, &(balls + sky));
    (scene, [1.0; 3])
}

/// Inside of a ball with reflectance r whose wall emits L: L (1 + r + r² + …), a term for each edge of the longest
/// path.
fn closed() -> (Scene, [f32; 3]) {
    let (r, l, edges) = ([0.8f32, 0.5, 0.2], [0.25, 0.5, 1.0], 5);
    let scene = furnace(
        edges,
        r#"origin="0.5,0.3,1" target="-0.4,0.1,-1""#,
        r#"<shape type="sphere"><boolean name="flip_normals" value="true"/><float name="radius" value="2"/>
            <bsdf type="diffuse"><rgb name="reflectance" value="0.8,0.5,0.2"/></bsdf>
            <emitter type="area"><rgb name="radiance" value="0.25,0.5,1"/></emitter></shape>"#,
    );
    (scene, [0, 1, 2].map(|c| l[c] * (0..edges).map(|k| r[c].powi(k)).sum::<f32>()))
}

/// Every integrator, with the numbers of its samples in the open and in the closed furnace: so many that two percent
/// show.
pub fn integrators(scene: &Scene) -> Vec<(&'static str, [u32; 2], Algorithm)> {
    let path = settings(scene);
    let bidirectional = Bidirectional::new(path);
    let portals = Portals::new(scene).expect("a portal");
    let chains = Metropolis { candidates: Some(1000), ..Metropolis::new(path) };
    let primary = PrimarySample { candidates: Some(1000), ..PrimarySample::new(bidirectional) };
    let lights = InstantRadiosity { path, light_paths: 32, clamp: None };
    // Within any radius of a point of a ball lies the same area as in the plane.
    let photons = PhotonMapping { radius: 0.08, ..PhotonMapping::new(path) };
    vec![
        ("path", [2, 1], Algorithm::Path(path)),
        ("ptracer", [240, 20], Algorithm::LightTracer(LightTracer { path })),
        ("bdpt", [4, 1], Algorithm::Bidirectional(bidirectional)),
        ("tridir", [4, 1], Algorithm::Tridirectional(Tridirectional { path, portals })),
        ("vpl", [2, 1], Algorithm::InstantRadiosity(lights)),
        ("ppm", [64, 4], Algorithm::PhotonMapping(photons)),
        ("vcm", [4, 1], Algorithm::VertexMerging(VertexMerging::new(path))),
        ("mlt", [16, 10], Algorithm::Metropolis(chains)),
        ("pssmlt", [8, 3], Algorithm::PrimarySample(primary)),
        ("gdpt", [1, 1], Algorithm::GradientDomain(GradientDomain::new(path))),
    ]
}

/// An image as the program writes it, with the unbiased reconstruction where there are gradients.
pub fn image(algorithm: Algorithm, scene: &Scene, samples: u32, seed: u64) -> RgbImage {
    let kernel = algorithm
        .kernel("Everything", scene, scene.sampler.seeded(seed))
        .expect("a precompiled kind");
    let size = (scene.film.width, scene.film.height);
    let settings = RenderSettings::new(size, Budget::Samples(samples));
    let rendered = render(&*kernel.expect("a kind for all scenes"), &settings, &());
    assert_eq!(rendered.invalid_samples, 0);
    if rendered.layers.contains_key(&Layer::Dx) {
        reconstructed(&rendered, Reconstruction::L2)
    } else {
        rendered.film.image()
    }
}

#[test]
fn furnaces_have_their_exact_answers_by_every_integrator() {
    let (mut means, mut quarters, mut weak) = (Vec::new(), Vec::new(), Vec::new());
    for (which, (name, (scene, answer))) in
        [("open", open()), ("closed", closed())].iter().enumerate()
    {
        let filled = |value| RgbImage::filled(SIDE, SIDE, value);
        let expected = |factor: f32| {
            let rgb = filled(answer.map(|value| factor * value));
            Reference { rgb, variance: filled([0.0; 3]) }
        };
        for (integrator, samples, algorithm) in integrators(scene) {
            let render = |seed| image(algorithm.clone(), scene, samples[which], seed + 20);
            let images: Vec<RgbImage> = (0..SEEDS).map(render).collect();
            let what = format!("{name} furnace by {integrator}");
            let p = |factor, block| p_values(&what, &expected(factor), &images, block);
            means.extend(p(1.0, SIDE));
            quarters.extend(p(1.0, SIDE / 2));
            // As many numbers as there are means in all.
            for factor in [0.98, 1.02] {
                let noticed = p(factor, SIDE).iter().any(|p| *p < FALSE_ALARM_RATE / 60.0);
                if !noticed {
                    weak.push(format!(
                        "{what}: an image that is {factor} times the right one passes"
                    ));
                }
            }
        }
    }
    assert!(weak.is_empty(), "{weak:#?}");
    for p in [means, quarters] {
        assert!(!holm(&p, FALSE_ALARM_RATE).contains(&true));
    }
}
