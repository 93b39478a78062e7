//! The path tracer against images that another renderer made, and against exact answers.
//!
//! Sample counts are chosen for two reasons. Light that rarely finds its way to a pixel makes the
//! distribution of a block's mean skew and its measured variance unreliable, so that a z-score is
//! normally distributed only with enough samples: `ply-binary`, with most of its light in a few
//! pixels at the rim of a lamp, is the worst. And an error of one percent in a density must stand
//! out of the noise: where little light is reflected (filters, sphere) it shows less, so these scenes
//! take more samples.
//!
//! `sphere` has a block with a sliver of the lamp that a pixel's samples can miss altogether; its
//! score is then -4.76, the distance of the reference from black, whatever the number of samples.
//! The limit is at 5.5.

mod algorithms;
#[path = "../common/mod.rs"]
mod common;
mod furnaces;
mod hidden;
mod models;
mod scenes;
mod techniques;

use integrators::image::block_test::{BlockScore, holm};
use integrators::render::Film;
use integrators::scene::SamplerKind::{self, Independent, LowDiscrepancy};
use scenes::{MisjudgingTracer, Reference, film, path_traced, scene, scores};

/// The scenes with a stored image, and samples per pixel.
const SCENES: [(&str, u32); 15] = [
    ("cornell-box", 256),
    ("rectangle", 256),
    ("cube", 256),
    ("sphere", 512),
    ("disk", 256),
    ("obj", 256),
    ("ply-ascii", 256),
    ("ply-binary", 2048),
    ("two-lights", 256),
    ("tent-filter", 1024),
    ("mitchell-filter", 256),
    ("gaussian-filter", 1024),
    ("lanczos-filter", 128),
    ("furnace-enclosure", 64),
    ("furnace-white", 64),
];

/// Scenes whose answer is known: `L (1 - r^d) / (1 - r)` for walls of reflectance r that emit L, at
/// depth d; for `furnace-white` L is 1 - r and d unlimited.
const FURNACES: [(&str, [f32; 3]); 3] = [
    ("furnace-enclosure", [0.624_96, 1.968_75, 0.922_32]),
    ("furnace-sphere", [0.859_75, 1.088, 1.417]),
    ("furnace-white", [1.0; 3]),
];

/// The chance that any of the comparisons with stored images fails for no reason, over the seeds.
const FALSE_ALARM_RATE: f64 = 1e-4;

/// How many numbers are compared with a stored image: 64 blocks and two means in three channels.
const COMPARISONS: usize = SCENES.len() * 66 * 3;

fn most_significant(scores: &[BlockScore]) -> &BlockScore {
    scores.iter().min_by(|a, b| a.p_value.total_cmp(&b.p_value)).expect("there are scores")
}

/// One line of figures, to be seen with `--nocapture`.
fn report(what: &str, scores: &[BlockScore]) {
    let (blocks, means) = scores.split_at(scores.len() - 6);
    let z = |s: &BlockScore| format!("{:6.2}", s.z);
    let ratio = |s: &BlockScore| format!("{:.5}", s.mean / s.reference_mean);
    println!(
        "{what:<42} worst block {}  mean {}, ratio {}  weighted {}",
        z(most_significant(blocks)),
        means[..3].iter().map(z).collect::<String>(),
        means[..3].iter().map(ratio).collect::<Vec<_>>().join(" "),
        means[3..].iter().map(z).collect::<String>(),
    );
}

#[test]
fn renders_agree_with_the_stored_images() {
    let mut all = Vec::new();
    for (index, (name, samples)) in SCENES.into_iter().enumerate() {
        let reference = Reference::stored(name);
        // Both kinds of uniforms. The measured variance of stratified samples is too large rather
        // than too small.
        let kinds = [(Independent, samples), (LowDiscrepancy, samples / 4)];
        let (sampler, samples) = kinds[usize::from(index % 4 > 0)];
        let what = format!("{name}, {}, {samples} samples", sampler.name());
        let scores = scores(&path_traced(name, sampler, samples, None, 1), &reference);
        report(&what, &scores);
        all.extend(scores.into_iter().map(|score| (what.clone(), score)));
    }
    assert_eq!(all.len(), COMPARISONS);
    let p_values: Vec<f64> = all.iter().map(|(_, score)| score.p_value).collect();
    let rejected = holm(&p_values, FALSE_ALARM_RATE);
    let failures: Vec<_> = all.iter().zip(rejected).filter(|(_, r)| *r).map(|(s, _)| s).collect();
    assert!(failures.is_empty(), "{failures:#?}");
}

/// Whether each channel of the mean of a film is the exact answer, within four standard errors and a
/// rounding error of 1e-5. Tells by how many standard errors it is off.
fn is_exact(film: &Film, answer: [f32; 3]) -> ([f64; 3], bool) {
    let count = film.pixels().len() as f64;
    let sum = |value: &dyn Fn(usize) -> f64| (0..film.pixels().len()).map(value).sum::<f64>();
    let offs = [0, 1, 2].map(|c| {
        let mean = sum(&|i| film.pixels()[i].mean()[c]) / count;
        let variance = sum(&|i| film.pixels()[i].variance_of_mean().unwrap_or_default()[c]);
        (mean - f64::from(answer[c]), variance.sqrt() / count)
    });
    let within = offs.iter().all(|(off, error)| off.abs() <= 4.0 * error + 1e-5);
    (offs.map(|(off, error)| off / error), within)
}

#[test]
fn furnaces_have_their_exact_answers() {
    for (name, answer) in FURNACES {
        for (sampler, seed) in [(Independent, 2), (LowDiscrepancy, 3)] {
            let film = path_traced(name, sampler, 32, None, seed);
            let (z, within) = is_exact(&film, answer);
            println!("{name}, {}: {z:.2?} standard errors", sampler.name());
            assert!(within, "{name}, {}: {z:.2?} standard errors off", sampler.name());
        }
    }
}

/// A film of a scene rendered with wrong densities of scattering and of light sampling.
fn misjudged(
    name: &str,
    (sampler, samples): (SamplerKind, u32),
    scatter_factor: f32,
    light_factor: f32,
) -> Film {
    let mut scene = scene(name);
    scene.sampler.kind = sampler;
    let mut tracer = MisjudgingTracer::new(&scene, 1);
    (tracer.scatter_factor, tracer.light_factor) = (scatter_factor, light_factor);
    film(&tracer, &scene, samples, None)
}

/// Fails the comparison above already at its first step, whatever the other scenes do.
fn assert_noticed(
    name: &str,
    uniforms: (SamplerKind, u32),
    scatter_factor: f32,
    light_factor: f32,
) {
    let film = misjudged(name, uniforms, scatter_factor, light_factor);
    let scores = scores(&film, &Reference::stored(name));
    let what = format!("{name}, scatter x {scatter_factor}, light x {light_factor}");
    report(&what, &scores);
    let p_value = most_significant(&scores).p_value;
    assert!(p_value < FALSE_ALARM_RATE / COMPARISONS as f64, "{what} passes: {p_value:e}");
}

// Weighting makes up for much of an error in the density of the lesser technique: where light
// sampling has most of the weight, an error in scattering is next to invisible in the image, and
// conversely. So each scene gets an error in the density that matters to it.

#[test]
fn one_percent_in_the_density_of_light_sampling_is_noticed() {
    // A lamp of each shape.
    let some = ["cornell-box", "sphere", "disk"];
    for (name, samples) in SCENES.into_iter().filter(|(name, _)| some.contains(name)) {
        assert_noticed(name, (Independent, samples), 1.0, 1.01);
    }
}

#[test]
fn one_percent_in_the_density_of_scattering_is_noticed() {
    for (name, samples) in SCENES.into_iter().filter(|(name, _)| name.starts_with("furnace")) {
        assert_noticed(name, (LowDiscrepancy, samples / 4), 1.01, 1.0);
    }
    for (name, answer) in FURNACES {
        let (z, within) = is_exact(&misjudged(name, (LowDiscrepancy, 32), 1.01, 1.0), answer);
        assert!(!within, "{name} passes with {z:.2?} standard errors");
    }
}

#[test]
fn right_densities_give_the_image_of_the_path_tracer() {
    // The deliberate errors above are all that differs.
    for name in ["two-lights", "tent-filter"] {
        let standard = path_traced(name, Independent, 2, None, 1);
        assert!(misjudged(name, (Independent, 2), 1.0, 1.0) == standard, "{name}");
    }
}

#[test]
fn the_number_of_threads_does_not_change_a_bit() {
    for name in ["cornell-box", "two-lights", "gaussian-filter"] {
        for sampler in [Independent, LowDiscrepancy] {
            let one = path_traced(name, sampler, 4, Some(1), 9);
            for threads in [2, 5] {
                let many = path_traced(name, sampler, 4, Some(threads), 9);
                assert!(one == many, "{name}, {}, {threads} threads", sampler.name());
            }
            let other = path_traced(name, sampler, 4, Some(2), 10);
            assert!(one != other, "{name}, {}: the seed changes nothing", sampler.name());
        }
    }
}
