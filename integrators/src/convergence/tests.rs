//! The harness on integrands whose answers are known.

use std::path::{Path, PathBuf};

use aether_core::{Pcg32, UniformSource};

use super::bias::spread;
use super::findings::findings;
use super::measure::{Effort, Subject, ladder, measure};
use super::record::{Curve, Estimate, Row, read_estimates, read_rows, write_estimates, write_rows};
use super::reference::Reference;
use super::report::Measurements;
use super::summary::{Reached, SceneSummary, summarise};
use super::{adapter, picture, table};
use crate::image::RgbImage;
use crate::image::exr::{Attribute, Exr};
use crate::render::PixelKernel;

const SIZE: (u32, u32) = (32, 24);

/// An estimator of 1 from a uniform number, the same in every pixel.
struct Constant {
    seed: u64,
    estimate: fn(f32) -> f32,
}

impl PixelKernel for Constant {
    type Scratch = ();

    fn scratch(&self) {}

    fn sample(&self, _: &mut (), pixel: (u32, u32), sample: u32) -> [f32; 3] {
        let stream = u64::from(pixel.1) << 32 | u64::from(pixel.0);
        let mut uniforms = Pcg32::new(self.seed, stream, u64::from(sample));
        [0; 3].map(|_| (self.estimate)(uniforms.next()))
    }
}

/// Twice a uniform number: mean 1, variance 1/3.
fn unbiased(u: f32) -> f32 {
    2.0 * u
}

/// The same, with bright samples cut off.
fn clamped(u: f32) -> f32 {
    (2.0 * u).min(1.8)
}

/// The integral of 3x² over [0, 1], from x with density 2x: unbiased.
fn right_density(u: f32) -> f32 {
    let x = (1.0 - u).sqrt();
    3.0 * x * x / (2.0 * x)
}

/// The same, but the density is thought to be steeper, with integral one.
fn wrong_density(u: f32) -> f32 {
    let x = (1.0 - u).sqrt();
    3.0 * x * x / (2.0 * x * (1.0 + 0.3 * (x - 2.0 / 3.0)))
}

fn exact() -> Reference {
    let filled = |value| RgbImage::filled(SIZE.0 as usize, SIZE.1 as usize, [value; 3]);
    let (image, variance) = (filled(1.0), Some(filled(0.0)));
    Reference { image, variance, made_by: "hand".to_owned(), doubts: Vec::new() }
}

/// A name, and an estimate from a uniform number.
type Estimator = (&'static str, fn(f32) -> f32);

/// Measures estimators with six seeds and 256 samples.
fn measured(estimators: &[Estimator]) -> Measurements {
    let effort = Effort { scene: "constant".to_owned(), size: SIZE, threads: Some(1), budget: 1.0 };
    let reference = exact();
    let mut all = Measurements::default();
    for (name, estimate) in estimators {
        let kernel = |seed| Ok(Box::new(Constant { seed, estimate: *estimate }) as Box<_>);
        let reconstruction = Default::default();
        let subject =
            Subject { name: (*name).to_owned(), kernel: Box::new(kernel), reconstruction };
        let mut images = Vec::new();
        for seed in 0..6 {
            let (rows, image) = measure(&subject, (seed, 256), &effort, &reference, &()).unwrap();
            all.rows.extend(rows);
            images.push(image);
        }
        let spread = spread(&images.iter().collect::<Vec<_>>(), &reference).unwrap();
        let (v, b) = (spread.variance, spread.bias);
        all.estimates.push(Estimate {
            curve: all.rows.last().unwrap().curve.clone(),
            seeds: 6,
            spp: 256,
            variance: [v.value, v.low, v.high].map(|v| 256.0 * v),
            bias: [b.value, b.low, b.high],
            biased: spread.biased,
            floor: reference.floor(),
            reference: reference.made_by.clone(),
        });
    }
    all
}

fn scene(measurements: &Measurements) -> SceneSummary {
    summarise(&measurements.rows, &measurements.estimates).remove(0)
}

/// Intervals of 99 % at fixed seeds: each assertion of one fails by chance for one choice of seeds in a hundred.
#[test]
fn slope_and_variance_of_a_known_integrand() {
    let measurements = measured(&[("path", unbiased), ("density", right_density)]);
    let scene = scene(&measurements);
    for summary in &scene.curves {
        let spps: Vec<u32> = summary.points.iter().map(|point| point.spp).collect();
        assert_eq!(spps, [1, 2, 4, 8, 16, 32, 64, 128, 256]);
        let slope = summary.slope.unwrap();
        assert!(slope.contains(-0.5) && slope.high - slope.low < 0.05, "{slope:?}");
        assert!(!summary.estimate.as_ref().unwrap().biased);
    }
    // The variance 1/3 of a sample, over 1² + 0.01.
    let [value, low, high] = measurements.estimates[0].variance;
    let expected = 1.0 / 3.0 / 1.01;
    assert!(low < expected && expected < high, "{low} {expected} {high}");
    // From 2304 values and five degrees of freedom: a relative standard deviation of 1.3 %.
    assert!((value / expected - 1.0).abs() < 0.05 && high - low < 0.2 * expected);
    // relMSE with n samples is the same over n, and the target that of 64 samples.
    approx::assert_relative_eq!(
        scene.target.unwrap(),
        (expected / 64.0).sqrt(),
        max_relative = 0.1
    );
    assert_eq!(findings(&scene), [""; 0]);
}

#[test]
fn bias_is_called_so() {
    let measurements =
        measured(&[("path", unbiased), ("clamped", clamped), ("wrong", wrong_density)]);
    let scene = scene(&measurements);
    let biased: Vec<bool> = measurements.estimates.iter().map(|e| e.biased).collect();
    assert_eq!(biased, [false, true, true]);
    // Clamping at 1.8 loses 0.1 · 0.1.
    approx::assert_relative_eq!(
        measurements.estimates[1].bias[0],
        1e-4 / 1.01,
        max_relative = 0.15
    );
    let texts = findings(&scene);
    for name in ["clamped", "wrong"] {
        let told = |text: &&String| text.contains(name) && text.contains("biased");
        assert!(texts.iter().any(|text| told(&text)), "{name}: {texts:?}");
    }
    assert!(texts.iter().all(|text| !text.contains("path")), "{texts:?}");
    assert!(table::cells(&scene.curves[1])[7].ends_with('*'));
}

/// A bias that is hidden in the noise of a pixel shows in blocks.
#[test]
fn a_bias_below_the_noise_is_found() {
    let images = |scale: f32| -> Vec<RgbImage> {
        let mut uniforms = Pcg32::new(3, 0, 0);
        let mut image = || {
            RgbImage::from_fn(64, 64, |_, _| {
                [0; 3].map(|_| {
                    let u: f32 = uniforms.next();
                    scale * 2.0 * u
                })
            })
        };
        (0..8).map(|_| image()).collect()
    };
    let filled = |value| RgbImage::filled(64, 64, [value; 3]);
    let (image, variance) = (filled(1.0), Some(filled(0.0)));
    let reference = Reference { image, variance, made_by: String::new(), doubts: Vec::new() };
    let biased = |scale| {
        let images = images(scale);
        spread(&images.iter().collect::<Vec<_>>(), &reference).unwrap().biased
    };
    // One sample a pixel with a standard deviation of 58 %.
    assert_eq!((biased(1.0), biased(1.03)), (false, true));
}

fn row(integrator: &str, seed: u64, spp: u32, seconds: f64, relmse: f64) -> Row {
    let curve = Curve {
        scene: "room".to_owned(),
        renderer: "aether".to_owned(),
        integrator: integrator.to_owned(),
    };
    let (rays, densities) = (Some(12), None);
    let rmse = relmse.sqrt();
    Row { curve, seed, spp, seconds, rays, densities, rmse, relmse, smape: 0.1, flip: 0.2 }
}

/// Errors that fall as a power of the samples, with a factor for each seed.
fn rows(integrator: &str, exponent: f64, speed: f64, factors: &[f64]) -> Vec<Row> {
    let steps =
        ladder(256).into_iter().flat_map(|spp| factors.iter().enumerate().map(move |f| (spp, f)));
    let row = |(spp, (seed, factor)): (u32, (usize, &f64))| {
        let error = factor * f64::from(spp).powf(2.0 * exponent);
        row(integrator, seed as u64, spp, f64::from(spp) * speed, error)
    };
    steps.map(row).collect()
}

#[test]
fn what_stands_out_is_told() {
    let mut all = rows("path", -0.5, 0.1, &[1.0, 1.01, 0.99, 1.02, 0.98]);
    all.extend(rows("slow", -0.3, 0.1, &[1.0, 1.01, 0.99, 1.02, 0.98]));
    all.extend(rows("spiky", -0.5, 0.1, &[1.0, 1.01, 0.99, 1.02, 0.98]));
    all.last_mut().unwrap().relmse *= 9.0;
    let scene = summarise(&all, &[]).remove(0);
    let texts = findings(&scene);
    assert_eq!(texts.len(), 2, "{texts:?}");
    assert!(
        texts[0].contains("room, slow: the error falls as n^-0.") && texts[0].contains("slower")
    );
    assert!(texts[1].contains("room, spiky: seed 4 stands out"), "{texts:?}");
}

#[test]
fn efficiency_and_time_to_a_target() {
    let even = [1.0, 1.0, 1.0];
    let mut all = rows("path", -0.5, 0.1, &even);
    // Half the squared error and twice the time: the same efficiency. A quarter in the same time: four times.
    all.extend(rows("even", -0.5, 0.2, &even.map(|f| f / 2.0)));
    all.extend(rows("better", -0.5, 0.1, &even.map(|f| f / 4.0)));
    all.extend(rows("best", -0.5, 0.1, &even.map(|f| f / 1000.0)));
    all.extend(rows("worse", -0.5, 0.1, &even.map(|f| f * 16.0)));
    let scene = summarise(&all, &[]).remove(0);
    let reached: Vec<Reached> = scene.curves.iter().map(|s| s.reached.unwrap()).collect();
    let expected = [6.4, 6.4, 1.6, 0.1, 102.4];
    for (found, expected) in reached.iter().zip(expected) {
        let (Reached::Within(s) | Reached::Before(s) | Reached::Extrapolated(s)) = *found;
        approx::assert_relative_eq!(s, expected, max_relative = 1e-9);
    }
    assert!(matches!(reached[3..], [Reached::Before(_), Reached::Extrapolated(_)]));
    for (summary, expected) in scene.curves.iter().zip([1.0, 1.0, 4.0, 1000.0, 1.0 / 16.0]) {
        approx::assert_relative_eq!(summary.efficiency.unwrap(), expected, max_relative = 1e-9);
    }
}

/// A directory that is removed at the end of a test.
struct Directory(PathBuf);

impl Directory {
    fn new(name: &str) -> Self {
        let path = std::env::temp_dir().join(format!("aether-{name}-{}", std::process::id()));
        std::fs::create_dir_all(&path).unwrap();
        Self(path)
    }
}

impl Drop for Directory {
    fn drop(&mut self) {
        let _ = std::fs::remove_dir_all(&self.0);
    }
}

fn files(directory: &Path) -> Vec<(PathBuf, Vec<u8>)> {
    let entries = std::fs::read_dir(directory).unwrap().flatten().map(|entry| entry.path());
    let mut files: Vec<PathBuf> = entries.filter(|path| path.is_file()).collect();
    files.sort();
    let contents = |path: PathBuf| {
        let bytes = std::fs::read(&path).unwrap();
        (path.strip_prefix(directory).unwrap().to_owned(), bytes)
    };
    files.into_iter().map(contents).collect()
}

#[test]
fn a_report_is_a_function_of_the_tables() {
    let path = rows("path", -0.5, 0.1, &[1.0, 1.1, 0.9]);
    let mut measurements = Measurements { rows: path, ..Measurements::default() };
    measurements.rows.extend(rows("a <b>", -0.3, 0.2, &[1.0, 1.1, 0.9]));
    measurements.notes.push("A remark & more.".to_owned());
    let image = RgbImage::from_fn(12, 9, |x, y| [x as f32 / 12.0, y as f32 / 9.0, 0.5]);
    let picture = crate::image::png::encode(&image).unwrap();
    for name in
        ["room-reference-", "room-reference--crop", "room-aether-path", "room-aether-path-crop"]
    {
        measurements.pictures.push((name.to_owned(), picture.clone()));
    }
    measurements.pictures.sort();
    let (data, one, two) = (Directory::new("data"), Directory::new("one"), Directory::new("two"));
    measurements.write(&data.0).unwrap();
    let read = Measurements::read(std::slice::from_ref(&data.0)).unwrap();
    assert_eq!(read.rows.len(), measurements.rows.len());
    assert_eq!((&read.notes, &read.pictures), (&measurements.notes, &measurements.pictures));
    let text = read.report(&one.0).unwrap();
    let again = Measurements::read(std::slice::from_ref(&data.0)).unwrap().report(&two.0).unwrap();
    assert_eq!(text, again);
    assert!(files(&one.0) == files(&two.0));
    let names: Vec<PathBuf> = files(&one.0).into_iter().map(|(name, _)| name).collect();
    let expected = ["report.html", "report.md", "room-strip.svg", "room.svg"].map(PathBuf::from);
    assert_eq!(names, expected);
    // Well-formed, and nothing that has to be fetched.
    for (name, bytes) in files(&one.0) {
        let text = String::from_utf8(bytes).unwrap();
        assert!(!text.replace("http://www.w3.org/2000/svg", "").contains("http"), "{name:?}");
        if name.extension().unwrap() == "svg" {
            roxmltree::Document::parse(&text).unwrap();
        }
    }
    assert!(text.contains("| room | a <b> | 256 |") && text.contains("A remark & more."));
    assert!(Measurements::read(&[data.0.join("images")]).unwrap_err().contains("errors.csv"));
}

#[test]
fn tables_are_read_as_written() {
    let rows = vec![row("path", u64::MAX, 64, 1.5, 0.25), row("b, c", 1, 1, 0.0, 1.0)];
    let text = write_rows(&rows);
    let mut expected = rows.clone();
    expected[1].curve.integrator = "b  c".to_owned();
    assert_eq!(read_rows(&text).unwrap(), expected);
    let estimates = measured(&[("path", unbiased)]).estimates;
    let again = read_estimates(&write_estimates(&estimates)).unwrap();
    assert_eq!(write_estimates(&again), write_estimates(&estimates));
    for (wrong, message) in [
        ("a,b\n".to_owned(), "line 1: expected the columns"),
        (text.replacen("64,1.5", "64", 1), "line 2: 11 fields in place of 12"),
        (text.replacen("64,1.5", "x,1.5", 1), "line 2: `x` is no value for `spp`"),
        (text.replacen("2.500000e-1", "NaN", 1), "line 2: `relmse` is NaN"),
        (text.replacen("64,1.5", "64,-1.5", 1), "line 2: `seconds` is -1.5"),
        (text.replacen("room", "", 1), "line 2: `scene` is empty"),
    ] {
        let error = read_rows(&wrong).unwrap_err();
        assert!(error.contains(message), "{error}");
    }
}

#[test]
fn references_that_cannot_be_used_are_refused() {
    let directory = Directory::new("references");
    let path = directory.0.join("reference.exr");
    let write = |rgb: RgbImage, crop: &str| {
        let variance = Some(RgbImage::filled(rgb.width(), rgb.height(), [0.01; 3]));
        let crop = ("crop".to_owned(), Attribute::Text(crop.to_owned()));
        Exr { rgb, variance, layers: Default::default(), attributes: [crop].into() }
            .write(&path)
            .unwrap();
        Reference::read(&path, (8, 6), (0, 0))
    };
    let good = RgbImage::filled(8, 6, [0.5; 3]);
    let reference = write(good.clone(), "0,0").unwrap();
    approx::assert_relative_eq!(reference.floor().unwrap(), 0.01 / 0.26, max_relative = 1e-6);
    let mut broken = good.clone();
    broken.pixels_mut()[3][1] = f32::NAN;
    for (result, message) in [
        (write(RgbImage::filled(9, 6, [0.5; 3]), "0,0"), "9x6 pixels, the render 8x6"),
        (write(broken, "0,0"), "has 1 pixels that are NaN or infinite"),
        (write(good.clone(), "4,0"), "begins at pixel 4,0, the render that at 0,0"),
        (write(RgbImage::filled(8, 6, [0.0; 3]), "0,0"), "is black"),
        (Reference::read(&directory.0.join("none.exr"), (8, 6), (0, 0)), "none.exr"),
    ] {
        let error = result.unwrap_err();
        assert!(error.contains(message), "{error}");
    }
    let bare = Exr {
        rgb: good,
        variance: None,
        layers: Default::default(),
        attributes: Default::default(),
    };
    bare.write(&path).unwrap();
    let bare = Reference::read(&path, (8, 6), (0, 0)).unwrap();
    assert!(bare.floor().is_none() && bare.doubts[0].contains("own error is not known"));
}

#[test]
fn a_union_weighs_by_variance_and_notices_disagreement() {
    let filled = |value| RgbImage::filled(16, 16, [value; 3]);
    let part = |name: &str, value, variance| (name.to_owned(), filled(value), filled(variance));
    let union = Reference::union(&[part("a", 1.0, 0.01), part("b", 1.0, 0.03)]).unwrap();
    assert_eq!((union.made_by.as_str(), union.doubts.len()), ("a (75 %) + b (25 %)", 0));
    let variance = union.variance.as_ref().unwrap().pixel(3, 3)[0];
    approx::assert_relative_eq!(variance, 0.0075, max_relative = 1e-5);
    let apart = Reference::union(&[part("a", 1.0, 0.001), part("b", 1.2, 0.001)]).unwrap();
    assert!(apart.doubts[0].contains("a and b differ in 4 of 4 blocks"), "{:?}", apart.doubts);
    let other =
        ("c".to_owned(), RgbImage::filled(8, 8, [1.0; 3]), RgbImage::filled(8, 8, [1.0; 3]));
    assert!(Reference::union(&[part("a", 1.0, 0.01), other]).is_err());
}

#[test]
fn lists_of_images_of_other_renderers() {
    let directory = Directory::new("lists");
    let path = directory.0.join("images.csv");
    std::fs::write(&path, format!("{}\nother,path,3,16,0.5,a.exr\n", adapter::LIST_COLUMNS))
        .unwrap();
    let entries = adapter::read_list(&path).unwrap();
    assert_eq!((entries[0].spp, &entries[0].file), (16, &directory.0.join("a.exr")));
    std::fs::write(&path, format!("{}\nother,path,3,16,x,a.exr\n", adapter::LIST_COLUMNS)).unwrap();
    let error = adapter::read_list(&path).unwrap_err();
    assert!(error.contains("images.csv`, line 2: `x` is no value for `seconds`"), "{error}");
}

#[test]
fn steps_and_crops() {
    assert_eq!(ladder(1), [1]);
    assert_eq!(ladder(100), [1, 2, 4, 8, 16, 32, 64, 100]);
    assert_eq!(ladder(80), [1, 2, 4, 8, 16, 32, 80]);
    let reference = RgbImage::filled(30, 30, [1.0; 3]);
    let noisy = RgbImage::from_fn(30, 30, |x, y| [if x > 21 && y > 21 { 3.0 } else { 1.0 }; 3]);
    let crop = picture::telling_crop(&[&reference, &noisy], &reference);
    assert!(crop.0 >= 18 && crop.1 >= 18, "{crop:?}");
    assert_eq!(picture::cut(&noisy, crop).width(), 10);
    let error = picture::error_picture(&noisy, &reference);
    assert!(error.pixel(0, 0) == [0.0; 3] && error.pixel(29, 29)[0] > 0.9);
}
