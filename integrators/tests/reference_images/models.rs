//! Scattering models and lights, each in a scene of its own: against Mitsuba's images, in white furnaces,
//! in the limit of smooth surfaces, and compiled for more than is needed.

use std::path::Path;

use integrators::image::RgbImage;
use integrators::image::block_test::holm;
use integrators::kind::{DiffuseRooms, Everything, GlossyRooms, NotCovered, SceneKind};
use integrators::path::PathTracer;
use integrators::render::Film;
use integrators::scene::SamplerKind::{Independent, LowDiscrepancy};
use integrators::scene::envmap::EnvironmentMap;
use integrators::scene::{Scene, Sky};
use integrators::scene_kind;

use super::scenes::{Reference, film, path_traced, path_tracer, scene, scores, settings};
use super::{is_exact, report};

/// The scenes of `tests/scenes/models`, and samples per pixel.
const MODELS: [(&str, u32); 31] = [
    ("conductor", 128),
    ("mirror", 128),
    ("dielectric", 128),
    ("thindielectric", 128),
    ("plastic", 128),
    ("plastic-nonlinear", 128),
    ("roughconductor-ggx", 128),
    ("roughconductor-ggx-all", 128),
    ("roughconductor-beckmann", 128),
    ("roughdielectric-ggx", 128),
    ("roughdielectric-beckmann", 128),
    ("mask", 128),
    ("blendbsdf", 128),
    ("textures", 128),
    ("anisotropic", 128),
    ("varying", 128),
    ("bumps", 128),
    ("bumped-mesh", 128),
    ("roughplastic-mitsuba3", 128),
    ("constant", 128),
    ("envmap", 128),
    ("textured-lights", 128),
    ("point", 128),
    ("spot", 128),
    ("directional", 128),
    ("thinlens", 128),
    ("orthographic", 128),
    ("crop", 128),
    ("cylinder", 256),
    ("instance", 128),
    ("near-lamp", 128),
];

/// The chance that any of the comparisons with stored images fails for no reason, over the seeds.
const FALSE_ALARM_RATE: f64 = 1e-4;

#[test]
fn models_agree_with_the_stored_images() {
    let mut all = Vec::new();
    for (index, (name, samples)) in MODELS.into_iter().enumerate() {
        let name = format!("models/{name}");
        let reference = Reference::stored(&name);
        let kinds = [(Independent, samples), (LowDiscrepancy, samples / 4)];
        let (sampler, samples) = kinds[usize::from(index % 4 > 0)];
        let what = format!("{name}, {}, {samples} samples", sampler.name());
        let scores = scores(&path_traced(&name, sampler, samples, None, 1), &reference);
        report(&what, &scores);
        all.extend(scores.into_iter().map(|score| (what.clone(), score)));
    }
    let p_values: Vec<f64> = all.iter().map(|(_, score)| score.p_value).collect();
    let rejected = holm(&p_values, FALSE_ALARM_RATE);
    let failures: Vec<_> = all.iter().zip(rejected).filter(|(_, r)| *r).map(|(s, _)| s).collect();
    assert!(failures.is_empty(), "{failures:#?}");
}

/// A sphere of some material under a sky of radiance 1.
fn furnace(bsdf: &str) -> Scene {
    let xml = format!(
        r#"<scene version="3.0.0">
        <integrator type="path"><integer name="rr_depth" value="1000"/></integrator>
        <sensor type="perspective"><float name="fov" value="16"/>
            <transform name="to_world"><lookat origin="0,1,8" target="0,0,0" up="0,1,0"/></transform>
            <film type="hdrfilm"><integer name="width" value="24"/><integer name="height" value="24"/>
                <rfilter type="box"/></film>
            <sampler type="independent"><integer name="sample_count" value="16"/></sampler>
        </sensor>
        <emitter type="constant"><rgb name="radiance" value="1"/></emitter>
        <shape type="sphere">{bsdf}</shape></scene>"#
    );
    Scene::from_str(&xml, Path::new("."), &[]).unwrap_or_else(|error| panic!("{error}"))
}

fn furnace_film(bsdf: &str, samples: u32, seed: u64) -> Film {
    let scene = furnace(bsdf);
    film(&*path_tracer(&scene, seed), &scene, samples, None)
}

const WHITE: &str = r#"<rgb name="diffuse_reflectance" value="1"/>"#;
const MATTE: &str = r#"<bsdf type="twosided"><bsdf type="diffuse"><rgb name="reflectance" value="1"/></bsdf></bsdf>"#;

#[test]
fn models_that_conserve_energy_vanish_in_white_light() {
    let mut models = vec![
        MATTE.to_owned(),
        r#"<bsdf type="conductor"/>"#.to_owned(),
        r#"<bsdf type="dielectric"/>"#.to_owned(),
        r#"<bsdf type="dielectric"><float name="int_ior" value="0.7"/></bsdf>"#.to_owned(),
        r#"<bsdf type="thindielectric"/>"#.to_owned(),
        format!(r#"<bsdf type="plastic">{WHITE}</bsdf>"#),
        format!(r#"<bsdf type="mask"><float name="opacity" value="0.3"/>{MATTE}</bsdf>"#),
        format!(
            r#"<bsdf type="blendbsdf"><float name="weight" value="0.6"/>{MATTE}
            <bsdf type="conductor"/></bsdf>"#
        ),
    ];
    for alpha in [0.05, 0.2, 0.5] {
        for distribution in ["beckmann", "ggx"] {
            models.push(format!(
                r#"<bsdf type="roughplastic"><float name="alpha" value="{alpha}"/>{WHITE}
                <string name="distribution" value="{distribution}"/></bsdf>"#
            ));
        }
    }
    for (seed, model) in (1..).zip(&models) {
        let film = furnace_film(model, 64, seed);
        let (z, within) = is_exact(&film, [1.0; 3]);
        println!("{z:.2?} standard errors for {model}");
        // The table of rough plastic is good to a few parts in ten thousand.
        let mean = film.pixels().iter().map(|p| p.mean()[0]).sum::<f64>() / 576.0;
        let close = model.contains("roughplastic") && (mean - 1.0).abs() < 2e-3;
        assert!(within || close, "{z:.2?} standard errors, mean {mean}: {model}");
    }
    // The same light as a picture.
    let mut scene = furnace(&models[0]);
    let white = RgbImage::filled(8, 5, [0.5; 3]);
    let sky = EnvironmentMap::new(white, 2.0, &glam::DMat4::IDENTITY).unwrap();
    scene.sky = Some(Sky::Picture(sky));
    let (z, within) = is_exact(&film(&*path_tracer(&scene, 1), &scene, 64, None), [1.0; 3]);
    assert!(within, "{z:.2?} standard errors for a white picture");
    // It can fail.
    let grey = furnace_film(
        r#"<bsdf type="conductor"><rgb name="specular_reflectance" value="0.99"/></bsdf>"#,
        64,
        1,
    );
    assert!(!is_exact(&grey, [1.0; 3]).1);
}

/// The number of blocks along each side of a picture whose means are compared.
const BLOCKS: usize = 4;

/// The difference of the means of two films in standard errors and relative to their size, and the largest difference of
/// the means of sixteen blocks in standard errors.
fn difference(a: &Film, b: &Film) -> (f64, f64, f64) {
    let (width, height) = (a.size().0 as usize, a.size().1 as usize);
    let sums = |film: &Film, wanted: &dyn Fn(usize) -> bool| {
        let pixels = film.pixels().iter().enumerate().filter(|(i, _)| wanted(*i));
        pixels.fold((0.0, 0.0), |(mean, variance), (_, pixel)| {
            // The channels of a sample share their noise: their errors add up at worst.
            let v = pixel.variance_of_mean().unwrap_or_default();
            let error = v.iter().map(|v| v.sqrt()).sum::<f64>();
            (mean + pixel.mean().iter().sum::<f64>(), variance + error * error)
        })
    };
    let compare = |wanted: &dyn Fn(usize) -> bool| {
        let ((a, va), (b, vb)) = (sums(a, wanted), sums(b, wanted));
        ((a - b) / (va + vb).sqrt(), (a - b) / b)
    };
    let block_of = |i: usize| i / width * BLOCKS / height * BLOCKS + i % width * BLOCKS / width;
    let blocks = (0..BLOCKS * BLOCKS).map(|block| compare(&|i| block_of(i) == block).0.abs());
    let (z, off) = compare(&|_| true);
    // Of two black blocks nothing is known.
    (z, off, blocks.fold(0.0, f64::max))
}

/// A scene of `tests/scenes/models` with another material in it.
fn stage(bsdf: &str) -> Film {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../tests/scenes/models");
    let xml = format!(
        r#"<scene version="3.0.0"><include filename="room.xml"/>
        <shape type="sphere"><point name="center" x="0" y="0.6" z="0"/>{bsdf}</shape></scene>"#
    );
    let scene = Scene::from_str(&xml, &folder, &[]).unwrap_or_else(|error| panic!("{error}"));
    film(&*path_tracer(&scene, 3), &scene, 32, None)
}

/// Indices of refraction next to one, and roughness: the first is read as one, the others bend light. Facets hide each
/// other whatever the index is, which takes a hundredth of the light at a roughness of 0.3.
const AIR: [(&str, &str); 3] = [("1.000001", "0.3"), ("1.00004", "0.05"), ("0.99996", "0.05")];

/// Of seventeen normal numbers one exceeds this in one of 5,400 pictures.
const LIMIT: f64 = 4.4;

#[test]
fn rough_surfaces_converge_to_smooth_ones() {
    let gold = r#"<string name="material" value="Au"/>"#;
    let smooth = stage(&format!(r#"<bsdf type="conductor">{gold}</bsdf>"#));
    let glass = stage(r#"<bsdf type="dielectric"/>"#);
    // A boundary that hardly refracts is not to be seen, but at the rim of the sphere, where facets hide each other;
    // and lamps are seen through it rarely and brightly, so that means of blocks are not normally distributed.
    let nothing = stage(
        r#"<bsdf type="mask"><float name="opacity" value="0"/>
        <bsdf type="diffuse"/></bsdf>"#,
    );
    for distribution in ["beckmann", "ggx"] {
        let rough = |kind: &str, alpha: &str, more: &str| {
            stage(&format!(
                r#"<bsdf type="{kind}">{more}<float name="alpha" value="{alpha}"/>
                <string name="distribution" value="{distribution}"/></bsdf>"#
            ))
        };
        for alpha in ["1e-3", "1e-4"] {
            for (kind, more, smooth) in
                [("roughconductor", gold, &smooth), ("roughdielectric", "", &glass)]
            {
                let (z, off, block) = difference(&rough(kind, alpha, more), smooth);
                let what = format!(
                    "{kind}, {distribution} {alpha}: {z:.2} standard errors, {off:.1e} off"
                );
                println!("{what}, {block:.2} in the worst block");
                assert!(z.abs() < LIMIT && block < LIMIT, "{what}, {block:.2} in the worst block");
            }
        }
        for (index, alpha) in AIR {
            let index = format!(
                r#"<float name="int_ior" value="{index}"/><float name="ext_ior" value="1"/>"#
            );
            let (z, off, _) = difference(&rough("roughdielectric", alpha, &index), &nothing);
            println!("{distribution} {index}: {z:.2} standard errors, {off:.1e} off");
            assert!(z.abs() < LIMIT, "{distribution}, {index}: {z} standard errors, {off} off");
        }
    }
}

fn film_of_kind<K: SceneKind>(scene: &Scene) -> Film {
    let tracer = PathTracer::<K>::new(scene, settings(scene), 5).unwrap();
    film(&tracer, scene, 4, None)
}

#[test]
fn what_a_kind_has_besides_does_not_change_a_bit() {
    let room = scene("cornell-box");
    assert!(film_of_kind::<DiffuseRooms>(&room) == film_of_kind::<Everything>(&room));
    for name in ["roughconductor-ggx", "roughdielectric-beckmann"] {
        let glossy = scene(&format!("models/{name}"));
        assert!(
            film_of_kind::<GlossyRooms>(&glossy) == film_of_kind::<Everything>(&glossy),
            "{name}"
        );
    }
}

#[test]
fn a_kind_that_is_too_small_is_an_error() {
    let message = |name: &str| {
        let scene = scene(&format!("models/{name}"));
        PathTracer::<DiffuseRooms>::new(&scene, settings(&scene), 1).err().map(|e| e.to_string())
    };
    let expected = |feature: &str| {
        format!(
            "the scene needs `{feature}`, which the kind `DiffuseRooms` leaves out: add it to the kind"
        )
    };
    assert_eq!(message("conductor"), Some(expected("Conductor")));
    assert_eq!(message("constant"), Some(expected("Constant")));
    assert_eq!(message("mask"), Some(expected("Mask")));
    assert_eq!(message("directional"), Some(expected("Directional")));
    for (sensor, feature) in [("thinlens", "ThinLens"), ("orthographic", "Orthographic")] {
        let radius = r#"<float name="aperture_radius" value="1"/>"#;
        let radius = if feature == "ThinLens" { radius } else { "" };
        let xml = format!(
            r#"<scene version="3.0.0"><sensor type="{sensor}">{radius}</sensor><shape type="sphere"/></scene>"#
        );
        let scene = Scene::from_str(&xml, Path::new("."), &[]).unwrap();
        let error = PathTracer::<DiffuseRooms>::new(&scene, settings(&scene), 1).err();
        assert_eq!(error.map(|e| e.to_string()), Some(expected(feature)));
    }
    // Textures, which would otherwise be their mean colour.
    let checked =
        furnace(r#"<bsdf type="diffuse"><texture type="checkerboard" name="reflectance"/></bsdf>"#);
    scene_kind! {
        /// Plain surfaces under a sky.
        struct Plain: Diffuse, Constant;
    }
    let error = PathTracer::<Plain>::new(&checked, settings(&checked), 1).err();
    assert_eq!(error, Some(NotCovered { kind: "Plain", feature: "Textures" }));
}
