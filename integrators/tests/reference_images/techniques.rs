//! Each technique of each integrator alone: it has the light of those paths that it can make.
//!
//! In a matte room with a lamp of some size every technique can make every path with its number of vertices, so that
//! it has all light that has been scattered so many times, and no other.

use integrators::algorithm::Algorithm;
use integrators::bidirectional::Bidirectional;
use integrators::gradient_domain::GradientDomain;
use integrators::image::RgbImage;
use integrators::image::block_test::holm;
use integrators::instant_radiosity::InstantRadiosity;
use integrators::light_tracer::LightTracer;
use integrators::metropolis::Metropolis;
use integrators::path::PathSettings;
use integrators::photon_mapping::PhotonMapping;
use integrators::portals::Portals;
use integrators::primary_sample::PrimarySample;
use integrators::scene::Scene;
use integrators::tridirectional::Tridirectional;
use integrators::vertex_merging::VertexMerging;

use super::algorithms::{only, p_values, rendered};
use super::furnaces::{SIDE, image, with_portal};
use super::scenes::Reference;

/// The chance that the test fails for no reason, over the seeds.
const FALSE_ALARM_RATE: f64 = 1e-4;
/// Renders of each technique.
const SEEDS: u64 = 16;

/// A matte ball around a lamp, and a portal that cuts it in two, seen from the half without the lamp.
fn room(look: &str) -> Scene {
    let contents = r#"
        <shape type="sphere"><boolean name="flip_normals" value="true"/><float name="radius" value="2"/>
            <bsdf type="diffuse"><rgb name="reflectance" value="0.8,0.6,0.4"/></bsdf></shape>
        <shape type="sphere"><point name="center" x="1" y="0.5" z="0"/><float name="radius" value="0.5"/>
            <emitter type="area"><rgb name="radiance" value="2,3,4"/></emitter></shape>"#;
    with_portal(3, (50, look), r#"<scale value="2"/><rotate y="1" angle="90"/>"#, contents)
}

/// An integrator with the techniques of some settings.
type With = fn(&Scene, PathSettings) -> Algorithm;

/// Selections that make all paths with so many vertices, for each integrator with the samples of a pixel.
const ALONE: [(&str, u32, With, &[&[&str]]); 10] = [
    ("path", 4, |_, path| Algorithm::Path(path), &[&["0:2"], &["0:3", "1:2"], &["0:4", "1:3"]]),
    (
        "gdpt",
        1,
        |_, path| Algorithm::GradientDomain(GradientDomain::new(path)),
        &[&["0:2"], &["0:3", "1:2"], &["0:4", "1:3"]],
    ),
    (
        "ptracer",
        8,
        |_, path| Algorithm::LightTracer(LightTracer { path }),
        &[&["1:1"], &["2:1"], &["3:1"]],
    ),
    (
        "bdpt",
        4,
        |_, path| Algorithm::Bidirectional(Bidirectional::new(path)),
        &[&["0:2", "1:1"], &["0:3", "1:2", "2:1"], &["0:4", "1:3", "2:2", "3:1"]],
    ),
    (
        "pssmlt",
        6,
        |_, path| {
            let chains = PrimarySample::new(Bidirectional::new(path));
            Algorithm::PrimarySample(PrimarySample { candidates: Some(300), ..chains })
        },
        &[&["1:1"], &["0:3"], &["1:3", "2:2"]],
    ),
    (
        "mlt",
        6,
        |_, path| {
            Algorithm::Metropolis(Metropolis { candidates: Some(300), ..Metropolis::new(path) })
        },
        &[&[], &["0:3", "2:1"], &["1:3", "2:2"]],
    ),
    (
        "vpl",
        1,
        |_, path| {
            Algorithm::InstantRadiosity(InstantRadiosity { path, light_paths: 32, clamp: None })
        },
        &[&["0:2"], &["1:2"], &["2:2"]],
    ),
    (
        "ppm",
        8,
        |_, path| Algorithm::PhotonMapping(PhotonMapping::new(path)),
        &[&["0:2"], &["merge-2:2"], &["merge-3:2"]],
    ),
    (
        "vcm",
        6,
        |_, path| {
            // With more merges than there would be in a larger image, and little bias still.
            Algorithm::VertexMerging(VertexMerging { radius: 0.02, ..VertexMerging::new(path) })
        },
        &[&[], &["2:1", "merge-2:2"], &["2:2", "merge-2:3", "merge-3:2"]],
    ),
    ("tridir", 4, tridirectional, &[&[], &["1:2", "2:1"], &["2:2"]]),
];

fn tridirectional(scene: &Scene, path: PathSettings) -> Algorithm {
    let portals = Portals::new(scene).expect("a portal");
    Algorithm::Tridirectional(Tridirectional { path, portals })
}

/// All light that is carried by paths with so many vertices.
fn carried(scene: &Scene, vertices: usize) -> Reference {
    let techniques = format!("0:{vertices},1:{}", vertices - 1);
    let film = rendered(Algorithm::Path(only(scene, &techniques)), scene, 1024, 1);
    let variance = film.variance().expect("two samples a pixel");
    Reference { rgb: film.image(), variance }
}

/// The p-values of techniques against all light that they should have.
fn compared(
    scene: &Scene,
    expected: &Reference,
    (integrator, samples, with): (&str, u32, With),
    techniques: &str,
) -> Vec<f64> {
    let algorithm = with(scene, only(scene, techniques));
    let render = |seed| image(algorithm.clone(), scene, samples, seed + 30);
    let images: Vec<RgbImage> = (0..SEEDS).map(render).collect();
    let sum = |image: &RgbImage| image.pixels().iter().flatten().sum::<f32>();
    let ratio = images.iter().map(sum).sum::<f32>() / (SEEDS as f32 * sum(&expected.rgb));
    assert!(ratio > 0.0, "{techniques} of {integrator} contributes nothing");
    let what = format!("{techniques} of {integrator}, {ratio:.3} of the light");
    [SIDE, SIDE / 2].iter().flat_map(|block| p_values(&what, expected, &images, *block)).collect()
}

#[test]
fn each_technique_alone_has_the_light_of_the_paths_that_it_can_make() {
    let mut p = Vec::new();
    let scene = room(r#"origin="-1.2,0,0" target="1,0.2,0""#);
    let expected = [2, 3, 4].map(|vertices| carried(&scene, vertices));
    for (integrator, samples, with, lengths) in ALONE {
        for (expected, alone) in expected.iter().zip(lengths) {
            for techniques in *alone {
                p.extend(compared(&scene, expected, (integrator, samples, with), techniques));
            }
        }
    }
    // The camera looks away from the portal, so that light passes it once: on its way to what is seen, or before.
    let scene = room(r#"origin="-0.3,0,0" target="-1,0,0""#);
    for (vertices, techniques) in [(3, "portal-0:1"), (4, "portal-1:1,portal-0:2")] {
        let expected = carried(&scene, vertices);
        p.extend(compared(&scene, &expected, ("tridir", 16, tridirectional), techniques));
    }
    assert!(!holm(&p, FALSE_ALARM_RATE).contains(&true));
}
