//! All integrators against the same images as the path tracer.

use std::sync::atomic::{AtomicU32, Ordering};

use aether_core::special::beta_inc;
use integrators::algorithm::Algorithm;
use integrators::bidirectional::Bidirectional;
use integrators::gradient_domain::{GradientDomain, reconstructed};
use integrators::image::RgbImage;
use integrators::image::block_test::holm;
use integrators::instant_radiosity::InstantRadiosity;
use integrators::kind;
use integrators::light_tracer::LightTracer;
use integrators::metropolis::{MUTATIONS, Metropolis};
use integrators::path::PathSettings;
use integrators::photon_mapping::PhotonMapping;
use integrators::poisson::Reconstruction;
use integrators::portals::Portals;
use integrators::primary_sample::PrimarySample;
use integrators::render::{Budget, Film, Layer, Observer, Progress, RenderSettings, render};
use integrators::scene::{Filter, Scene};
use integrators::tridirectional::Tridirectional;
use integrators::vertex_merging::VertexMerging;

use super::report;
use super::scenes::{Reference, film, scene, scores, settings};

/// The chance that any of the comparisons of a test fails for no reason, over the seeds.
const FALSE_ALARM_RATE: f64 = 1e-4;

/// A render by the smallest kind of an integrator that covers the scene.
pub fn rendered(algorithm: Algorithm, scene: &Scene, samples: u32, seed: u64) -> Film {
    let kernel = algorithm.kernel(kind::smallest(scene), scene, scene.sampler.seeded(seed));
    let kernel = kernel.expect("a precompiled kind").expect("a kind that covers the scene");
    film(&*kernel, scene, samples, None)
}

/// The settings of a scene, with some techniques.
pub fn only(scene: &Scene, techniques: &str) -> PathSettings {
    PathSettings { techniques: techniques.parse().expect("a selection"), ..settings(scene) }
}

fn bidirectional(path: PathSettings) -> Algorithm {
    Algorithm::Bidirectional(Bidirectional::new(path))
}

/// Compares renders of integrators with independent samples with the stored images: each block and the means.
fn assert_alike(renders: impl IntoIterator<Item = (String, Film, Reference)>) {
    let mut all = Vec::new();
    for (what, film, reference) in renders {
        let scores = scores(&film, &reference);
        report(&what, &scores);
        all.extend(scores.into_iter().map(|score| (what.clone(), score)));
    }
    let p_values: Vec<f64> = all.iter().map(|(_, score)| score.p_value).collect();
    let rejected = holm(&p_values, FALSE_ALARM_RATE);
    let failures: Vec<_> = all.iter().zip(rejected).filter(|(_, r)| *r).map(|(s, _)| s).collect();
    assert!(failures.is_empty(), "{failures:#?}");
}

/// Scenes, and samples for paths from both ends.
const BOTH_ENDS: [(&str, u32); 10] = [
    ("cornell-box", 16),
    ("models/smooth", 16),
    ("gaussian-filter", 4),
    ("models/dielectric", 16),
    ("models/roughdielectric-ggx", 8),
    ("models/mask", 8),
    ("models/envmap", 8),
    ("models/spot", 8),
    ("models/directional", 8),
    ("models/portal-room", 16),
];

#[test]
fn bidirectional_path_tracing_agrees_with_the_stored_images() {
    assert_alike(BOTH_ENDS.map(|(name, samples)| {
        let scene = scene(name);
        let film = rendered(bidirectional(settings(&scene)), &scene, samples, 1);
        (format!("bdpt, {name}"), film, Reference::stored(name))
    }));
}

#[test]
fn samples_may_have_more_light_paths_than_camera_paths() {
    // All techniques, and those alone that depend on the number of light paths.
    let selections = [
        ("gaussian-filter", "*:*", 2),
        ("gaussian-filter", "*:1", 2),
        ("models/smooth", "*:*", 4),
        ("cornell-box", "0:2,1:2,2:2,3:*", 16),
    ];
    assert_alike(selections.map(|(name, techniques, samples)| {
        let scene = scene(name);
        let path = only(&scene, techniques);
        let algorithm =
            Algorithm::Bidirectional(Bidirectional { light_paths: 3, ..Bidirectional::new(path) });
        let film = rendered(algorithm, &scene, samples, 3);
        (format!("3 light paths, techniques {techniques:?}, {name}"), film, Reference::stored(name))
    }));
}

#[test]
fn each_technique_alone_is_unbiased() {
    // Every path can be made by one technique of each selection.
    let selections = [
        ("cornell-box", "*:1", 16),
        ("gaussian-filter", "*:1", 4),
        ("cornell-box", "0:2,1:*", 16),
        ("cornell-box", "0:2,1:2,2:2,3:*", 16),
    ];
    assert_alike(selections.map(|(name, techniques, samples)| {
        let scene = scene(name);
        let film = rendered(bidirectional(only(&scene, techniques)), &scene, samples, 2);
        (format!("techniques {techniques}, {name}"), film, Reference::stored(name))
    }));
}

#[test]
fn scattering_alone_and_next_event_estimation_alone_are_unbiased() {
    // A lamp, which scattering finds; that it is seen is no matter of next-event estimation.
    let selections = [("0:*", 128), ("0:2,1:*", 32)];
    assert_alike(selections.map(|(techniques, samples)| {
        let scene = scene("cornell-box");
        let film = rendered(Algorithm::Path(only(&scene, techniques)), &scene, samples, 2);
        (format!("path {techniques}"), film, Reference::stored("cornell-box"))
    }));
}

#[test]
fn light_tracing_agrees_with_the_stored_images() {
    let scenes = ["cornell-box", "tent-filter", "models/constant", "models/point"];
    assert_alike(scenes.map(|name| {
        let scene = scene(name);
        let algorithm = Algorithm::LightTracer(LightTracer { path: settings(&scene) });
        (format!("ptracer, {name}"), rendered(algorithm, &scene, 32, 3), Reference::stored(name))
    }));
}

#[test]
fn tridirectional_path_tracing_agrees_with_the_stored_images() {
    // One light path through the hole is seen by pixels all over the image, so that the noise of means is half as
    // much again as that of independent pixels: it is that between seeds.
    const SEEDS: u64 = 24;
    let mut p = Vec::new();
    // A lamp in the next room, and the sky and the sun behind a window.
    for name in ["models/portal-room", "models/daylight"] {
        let scene = scene(&format!("{name}-tridir"));
        let portals = Portals::new(&scene).expect("a portal");
        let path = settings(&scene);
        let algorithm = Algorithm::Tridirectional(Tridirectional { path, portals });
        let render = |seed| rendered(algorithm.clone(), &scene, 1, seed + 10).image();
        let renders: Vec<RgbImage> = (0..SEEDS).map(render).collect();
        let reference = Reference::stored(name);
        for block in [16, scene.film.width as usize] {
            p.extend(p_values(&format!("tridir, {name}"), &reference, &renders, block));
        }
    }
    assert!(!holm(&p, FALSE_ALARM_RATE).contains(&true));
}

/// Every integrator with every scene that it can render: matte, smooth normals, glossy, a caustic of glass, a mirror, a
/// small light, one that is near, an environment, a room behind a portal, filters that are wider than a pixel.
#[test]
#[ignore = "takes minutes: cargo test -p integrators --test reference_images -- --ignored"]
fn every_unbiased_integrator_agrees_with_the_stored_image_of_every_scene() {
    let rough = [
        "cornell-box",
        "models/point",
        "models/near-lamp",
        "models/roughconductor-ggx",
        "models/portal-room",
        "tent-filter",
        "gaussian-filter",
    ];
    let smooth = ["models/smooth", "models/envmap", "models/dielectric", "models/mirror"];
    let mut p = Vec::new();
    for name in [&rough[..], &smooth].concat() {
        let scene = scene(name);
        let path = settings(&scene);
        let inner = Bidirectional::new(path);
        let lights = InstantRadiosity { path, light_paths: 64, clamp: None };
        let mut algorithms = vec![
            ("path", 16, Algorithm::Path(path)),
            ("bdpt", 8, Algorithm::Bidirectional(inner)),
            ("gdpt", 4, Algorithm::GradientDomain(GradientDomain::new(path))),
            ("mlt", 8, Algorithm::Metropolis(Metropolis::new(path))),
            ("pssmlt", 8, Algorithm::PrimarySample(PrimarySample::new(inner))),
        ];
        // What is seen in a mirror is found by no path from a light, and no virtual light lies on one.
        if !smooth.contains(&name) {
            algorithms.push(("ptracer", 32, Algorithm::LightTracer(LightTracer { path })));
            algorithms.push(("vpl", 2, Algorithm::InstantRadiosity(lights)));
        }
        for (integrator, samples, algorithm) in algorithms {
            let render =
                |seed| super::furnaces::image(algorithm.clone(), &scene, samples, seed + 40);
            let renders: Vec<RgbImage> = (0..SEEDS).map(render).collect();
            let found =
                p_values(&format!("{integrator}, {name}"), &Reference::stored(name), &renders, 16);
            p.extend(found.into_iter().map(|p| (p, integrator, name)));
        }
    }
    let rejected = holm(&p.iter().map(|(p, ..)| *p).collect::<Vec<_>>(), FALSE_ALARM_RATE);
    let failures: Vec<_> = p.iter().zip(rejected).filter(|(_, r)| *r).map(|(p, _)| p).collect();
    assert!(failures.is_empty(), "{failures:?}");
}

/// Seeds that integrators are rendered with whose pixels or samples depend on each other.
const SEEDS: u64 = 8;

/// The p-values of the means of blocks over renders with several seeds, against an expected image: Student's t.
pub fn p_values(what: &str, reference: &Reference, renders: &[RgbImage], block: usize) -> Vec<f64> {
    let (width, height) = (reference.rgb.width(), reference.rgb.height());
    let mut all = Vec::new();
    for corner in (0..height / block).flat_map(|y| (0..width / block).map(move |x| (x, y))) {
        for c in 0..3 {
            let pixels = (0..block * block)
                .map(|k| (corner.0 * block + k % block, corner.1 * block + k / block));
            let sum = |image: &RgbImage| {
                pixels.clone().map(|(x, y)| f64::from(image.pixel(x, y)[c])).sum::<f64>()
            };
            let means: Vec<f64> = renders.iter().map(sum).collect();
            let n = renders.len() as f64;
            let mean = means.iter().sum::<f64>() / n;
            let spread = means.iter().map(|m| (m - mean).powi(2)).sum::<f64>() / (n - 1.0);
            let (expected, noise) = (sum(&reference.rgb), sum(&reference.variance));
            // A sky without noise is rounded.
            let rounding = (1e-5 * expected).powi(2) + 1e-20;
            let t2 = (mean - expected).powi(2) / (spread / n + noise + rounding);
            let freedom = n - 1.0;
            all.push(beta_inc(0.5 * freedom, 0.5, freedom / (freedom + t2)));
        }
    }
    let least = all.iter().copied().fold(1.0, f64::min);
    println!("{what}: least p-value {least:.1e} of {}", all.len());
    all
}

fn assert_unbiased(name: &str, samples: u32, algorithm: impl Fn(&Scene) -> Algorithm) {
    let scene = scene(name);
    let render = |seed| rendered(algorithm(&scene), &scene, samples, seed + 10).image();
    let renders: Vec<RgbImage> = (0..SEEDS).map(render).collect();
    let p_values = p_values(name, &Reference::stored(name), &renders, 16);
    assert!(!holm(&p_values, FALSE_ALARM_RATE).contains(&true), "{name}");
}

/// The differences of an image to the right or down, with their variance; nothing where they lead out of it.
fn differences(image: &Reference, (dx, dy): (usize, usize)) -> Reference {
    let (width, height) = (image.rgb.width(), image.rgb.height());
    let of = |image: &RgbImage, value: &dyn Fn([f32; 2]) -> f32| {
        RgbImage::from_fn(width, height, |x, y| {
            let next = (x + dx < width && y + dy < height).then(|| image.pixel(x + dx, y + dy));
            let here = image.pixel(x, y);
            next.map_or([0.0; 3], |next| std::array::from_fn(|c| value([here[c], next[c]])))
        })
    };
    let variance = of(&image.variance, &|[here, next]| here + next);
    Reference { rgb: of(&image.rgb, &|[here, next]| next - here), variance }
}

/// A number made of each two.
fn zip(a: &RgbImage, b: &RgbImage, of: impl Fn(f32, f32) -> f32) -> RgbImage {
    RgbImage::from_fn(a.width(), a.height(), |x, y| {
        let (a, b) = (a.pixel(x, y), b.pixel(x, y));
        std::array::from_fn(|c| of(a[c], b[c]))
    })
}

fn product(a: &RgbImage, b: &RgbImage) -> RgbImage {
    zip(a, b, |a, b| a * b)
}

fn sum(a: &RgbImage, b: &RgbImage) -> RgbImage {
    zip(a, b, |a, b| a + b)
}

#[test]
fn gradients_are_those_of_the_image_and_least_squares_of_them_unbiased() {
    let scenes = [
        "cornell-box",
        "gaussian-filter",
        "models/dielectric",
        "models/mirror",
        "models/roughdielectric-ggx",
        "models/envmap",
    ];
    let mut p = Vec::new();
    for name in scenes {
        let scene = scene(name);
        let path = settings(&scene);
        let kernel = Algorithm::GradientDomain(GradientDomain::new(path));
        let mut renders = [const { Vec::new() }; 3];
        for seed in 0..SEEDS {
            let kernel = kernel.clone().kernel(
                kind::smallest(&scene),
                &scene,
                scene.sampler.seeded(seed + 10),
            );
            let kernel = kernel.expect("a kind").expect("it covers the scene");
            let size = (scene.film.width, scene.film.height);
            let budget = Budget::Samples(1);
            let gradients = render(&*kernel, &RenderSettings::new(size, budget), &());
            assert_eq!(gradients.invalid_samples, 0);
            renders[0].push(reconstructed(&gradients, Reconstruction::L2));
            renders[1].push(gradients.layers[&Layer::Dx][0].clone());
            renders[2].push(gradients.layers[&Layer::Dy][0].clone());
        }
        let image = Reference::stored(name);
        // Gradients are those of light that has been scattered.
        let seen = PathSettings { max_depth: Some(1), ..path };
        let seen = rendered(Algorithm::Path(seen), &scene, 512, 3);
        let seen_noise = seen.variance().expect("two samples a pixel");
        let noise = sum(&image.variance, &seen_noise);
        // A sky without noise is rounded, and what is left of it is nothing else.
        let rounding = zip(&image.rgb, &image.rgb, |a, b| 1e-10 * a * b);
        let rgb = zip(&image.rgb, &seen.image(), |all, seen| all - seen);
        let scattered = Reference { rgb, variance: sum(&noise, &rounding) };
        let [dx, dy] = [(1, 0), (0, 1)].map(|step| differences(&scattered, step));
        let expected = [image.clone(), dx, dy];
        let noise = Reference { rgb: seen.image(), variance: seen_noise };
        let steps = [(0, 0), (1, 0), (0, 1)];
        // In the tails of a wider filter a lamp is seen too rarely to be subtracted.
        let parts = if scene.film.filter == Filter::Box { 3 } else { 1 };
        for (part, (expected, renders)) in expected.iter().zip(&renders).enumerate().take(parts) {
            let what = format!("{name}, {}", ["least squares", "dx", "dy"][part]);
            p.extend(p_values(&what, expected, renders, 16));
            // Too weak or too strong gradients show when they are laid against those expected, where the noise
            // of these does not come in twice.
            let noise = differences(&noise, steps[part]).variance;
            let clean = zip(&expected.rgb, &noise, |e, noise| if noise > 0.0 { 0.0 } else { e });
            let along = |image: &RgbImage| product(image, &clean);
            let renders: Vec<RgbImage> = renders.iter().map(along).collect();
            let variance = product(&expected.variance, &product(&clean, &clean));
            let expected = Reference { rgb: along(&expected.rgb), variance };
            p.extend(p_values(
                &format!("{what}, along it"),
                &expected,
                &renders,
                image.rgb.width(),
            ));
        }
    }
    assert!(!holm(&p, FALSE_ALARM_RATE).contains(&true));
}

#[test]
fn chains_of_paths_are_distributed_as_they_should_be() {
    assert_unbiased("models/dielectric", 4, |scene| {
        Algorithm::Metropolis(Metropolis {
            candidates: Some(20_000),
            ..Metropolis::new(settings(scene))
        })
    });
}

#[test]
fn chains_of_primary_samples_are_distributed_as_they_should_be_with_direct_light() {
    assert_unbiased("cornell-box", 4, |scene| {
        let inner = Bidirectional::new(settings(scene));
        Algorithm::PrimarySample(PrimarySample {
            candidates: Some(20_000),
            direct: false,
            ..PrimarySample::new(inner)
        })
    });
}

/// Of the light of a scene full of caustics, the numbers of steps of a chain of some mutations and the image.
fn mutated(scene: &Scene, mutations: &str, seed: u64) -> (Vec<(String, Vec<f64>)>, RgbImage) {
    let mutations = mutations.parse().expect("names of mutations");
    let chains =
        Metropolis { mutations, candidates: Some(2000), ..Metropolis::new(settings(scene)) };
    let kernel =
        Algorithm::Metropolis(chains).kernel("Everything", scene, scene.sampler.seeded(seed));
    let kernel = kernel.expect("a precompiled kind").expect("a kind for all scenes");
    let image = film(&*kernel, scene, 16, None).image();
    let text = kernel.statistics().expect("the numbers of steps");
    println!("{text}");
    // NAME: STEPS steps, PART % with a proposal, PART % of these accepted
    let line = |line: &str| {
        let (name, counts) = line.split_once(": ").expect("a name");
        let words = counts.split_whitespace();
        (name.to_owned(), words.filter_map(|word| word.parse().ok()).collect())
    };
    (text.lines().map(line).collect(), image)
}

#[test]
fn every_mutation_alone_moves_chains() {
    let scene = scene("../../examples/scenes/mirrored-lamp");
    for name in MUTATIONS {
        for (mutation, numbers) in mutated(&scene, name, 1).0 {
            // All chains begin at paths that fit: each of their steps is one of this mutation.
            let steps = if mutation == name { 16.0 * 32.0 * 32.0 } else { 0.0 };
            assert_eq!(numbers[0], steps, "{mutation} of {name} alone");
            assert!(mutation != name || numbers.iter().all(|n| *n > 0.0), "{name}: {numbers:?}");
        }
    }
}

/// Each path fits one of the two, and so does all light.
#[test]
fn two_mutations_share_the_light_between_them() {
    let scene = scene("../../examples/scenes/mirrored-lamp");
    let both = |seed| {
        let [lens, chains] = ["lens", "multi-chain"].map(|name| mutated(&scene, name, seed).1);
        sum(&lens, &chains)
    };
    let images: Vec<RgbImage> = (0..SEEDS).map(both).collect();
    let film = rendered(bidirectional(settings(&scene)), &scene, 64, 1);
    let variance = film.variance().expect("two samples a pixel");
    let expected = Reference { rgb: film.image(), variance };
    let p = p_values("lens and multi-chain", &expected, &images, 16);
    assert!(!holm(&p, FALSE_ALARM_RATE).contains(&true));
}

#[test]
fn instant_radiosity_is_unbiased() {
    assert_unbiased("cornell-box", 1, |scene| {
        let path = settings(scene);
        Algorithm::InstantRadiosity(InstantRadiosity { path, light_paths: 64, clamp: None })
    });
}

#[test]
fn photon_mapping_converges() {
    // With a radius this small the bias is below the noise.
    assert_unbiased("models/dielectric", 16, |scene| {
        let settings = PhotonMapping { radius: 0.005, ..PhotonMapping::new(settings(scene)) };
        Algorithm::PhotonMapping(settings)
    });
}

#[test]
fn photons_are_seen_in_what_is_nearly_a_mirror() {
    let folder = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../tests/scenes/models");
    let [smooth, rough] = ["conductor", "roughconductor"].map(|bsdf| {
        let xml = format!(
            r#"<scene version="3.0.0"><include filename="room.xml"/><shape type="sphere">
            <point name="center" x="0" y="0.6" z="0"/><bsdf type="{bsdf}"><float name="alpha" value="1e-4"/></bsdf>
            </shape></scene>"#
        );
        let scene = Scene::from_str(&xml, &folder, &[]).unwrap_or_else(|error| panic!("{error}"));
        let algorithm = Algorithm::PhotonMapping(PhotonMapping::new(settings(&scene)));
        let film = rendered(algorithm, &scene, 8, 3);
        // The middle of the image, where the ball is.
        let (width, height) = (scene.film.width as usize, scene.film.height as usize);
        let middle = |size: usize| 7 * size / 16..9 * size / 16;
        let pixels = middle(height).flat_map(|y| middle(width).map(move |x| y * width + x));
        pixels.map(|pixel| film.pixels()[pixel].mean().iter().sum::<f64>()).sum::<f64>()
    });
    // If photons had to be where the ball is, hardly any would come from where it reflects much.
    assert!((rough / smooth - 1.0).abs() < 0.1, "{rough}, smooth {smooth}");
}

#[test]
fn merging_converges() {
    // Without connections of camera vertices to light paths, so that merges have most of the weight.
    assert_unbiased("models/dielectric", 4, |scene| {
        Algorithm::VertexMerging(VertexMerging::new(only(scene, "0:*,1:*,*:1,merge")))
    });
}

#[test]
fn the_number_of_threads_does_not_change_a_bit_of_splats() {
    let scene = scene("cornell-box");
    let render = |algorithm: Algorithm, threads| {
        let kernel = algorithm.kernel(kind::smallest(&scene), &scene, scene.sampler.seeded(5));
        film(&*kernel.expect("a kind").expect("it covers the scene"), &scene, 2, Some(threads))
    };
    let path = settings(&scene);
    let metropolis = Metropolis { candidates: Some(1000), ..Metropolis::new(path) };
    for algorithm in [
        bidirectional(settings(&scene)),
        Algorithm::Metropolis(metropolis),
        Algorithm::PhotonMapping(PhotonMapping::new(path)),
        Algorithm::VertexMerging(VertexMerging::new(path)),
        Algorithm::InstantRadiosity(InstantRadiosity { path, light_paths: 64, clamp: None }),
    ] {
        let one = render(algorithm.clone(), 1);
        assert!(one == render(algorithm.clone(), 3), "{algorithm:?}");
    }
}

/// Cancels when it has been asked for so many times whether to.
struct Impatient {
    patience: u32,
    asked: AtomicU32,
}

impl Observer for Impatient {
    fn progress(&self, _: &Progress) {}

    fn cancelled(&self) -> bool {
        self.asked.fetch_add(1, Ordering::Relaxed) >= self.patience
    }
}

#[test]
fn instant_radiosity_ends_within_a_sample_when_it_is_cancelled() {
    let scene = scene("cornell-box");
    let path = settings(&scene);
    let render = |light_paths, patience| {
        let lights = InstantRadiosity { path, light_paths, clamp: None };
        let kernel = Algorithm::InstantRadiosity(lights)
            .kernel("Everything", &scene, scene.sampler.seeded(5))
            .expect("a kind")
            .expect("it covers the scene");
        let size = (scene.film.width, scene.film.height);
        let settings = RenderSettings::new(size, Budget::Samples(1));
        let settings = RenderSettings { threads: Some(1), ..settings };
        render(&*kernel, &settings, &Impatient { patience, asked: AtomicU32::new(0) })
    };
    // While light paths are made; one takes a few rays.
    let early = render(1 << 24, 1000);
    assert!(early.cancelled && early.film.samples() == (0, 0));
    assert!(early.work.rays() < 100_000, "{}", early.work.rays());
    // While they light the first pixel that sees any surface, of which nothing counts then.
    let within = render(100_000, 100_100);
    assert!(within.cancelled);
    assert!(within.film.pixels().iter().all(|pixel| pixel.mean() == [0.0; 3]));
    assert!(within.work.rays() > 100_000);
    // While they light others: those that are complete are as they would have been.
    let whole = render(20, u32::MAX).film;
    let part = render(20, 4_000).film;
    assert_eq!((whole.samples(), part.samples()), ((1, 1), (0, 1)));
    for (pixel, complete) in part.pixels().iter().zip(whole.pixels()) {
        assert!(pixel.count() == 0 || pixel == complete);
    }
}
