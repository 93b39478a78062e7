//! The files that a render writes.

use std::collections::BTreeMap;
use std::ffi::OsStr;
use std::path::{Path, PathBuf};

use super::Failure;
use super::arguments::RenderArguments;
use super::checkpoint::place;
use super::plan::Plan;
use super::settings::{of_image, settings};
use crate::convergence::reference::crop_text;
use crate::gradient_domain::reconstructed;
use crate::image::exr::{Attribute, CORRELATION, Exr};
use crate::image::{RgbImage, png};
use crate::poisson::Reconstruction;
use crate::render::layers::contact_sheet;
use crate::render::{Layer, Rendered};
use crate::scene::Scene;

/// Further images by their names.
pub(super) type More = BTreeMap<String, RgbImage>;

/// The EXR file to write: by default, the name of the scene in the current directory.
pub(super) fn output_path(arguments: &RenderArguments) -> Result<PathBuf, Failure> {
    let Some(output) = &arguments.output else {
        let Some(stem) = arguments.scene.file_stem() else {
            let scene = arguments.scene.display();
            return Err(Failure::new(format!("`{scene}` is not the name of a scene file")));
        };
        let mut name = stem.to_owned();
        name.push(".exr");
        return Ok(name.into());
    };
    let is_exr = |extension: &OsStr| extension.eq_ignore_ascii_case("exr");
    if output.extension().is_none_or(is_exr) {
        return Ok(output.clone());
    }
    let output = output.display();
    Err(Failure::new(format!("the output `{output}` must end in .exr; a PNG is written beside it")))
}

/// All files that a render writes, but for its checkpoint.
pub(super) fn written(output: &Path, plan: &Plan, arguments: &RenderArguments) -> Vec<PathBuf> {
    let mut files = vec![output.to_owned(), output.with_extension("png")];
    if plan.integrator == "gdpt" {
        files.push(beside(output, "-primal.exr"));
        files.extend(GRADIENTS.map(|layer| beside(output, &format!("-{layer}.exr"))));
    }
    if arguments.technique_images.is_some() {
        files.push(beside(output, "-techniques.png"));
    }
    files
}

/// The file beside an output whose name is that with another end.
fn beside(output: &Path, end: &str) -> PathBuf {
    let mut file = output.file_stem().unwrap_or_default().to_owned();
    file.push(end);
    output.with_file_name(file)
}

/// That nothing which a scene is read from would be overwritten.
pub(super) fn keep_files_of(scene: &Scene, written: &[PathBuf]) -> Result<(), Failure> {
    let read: Vec<PathBuf> = scene.files.iter().map(|file| place(file)).collect();
    let is_read = |file: &&PathBuf| read.contains(&place(file));
    let Some(file) = written.iter().find(is_read) else { return Ok(()) };
    Err(Failure::new(format!(
        "the scene is read from `{}`, which the render would overwrite; name another output with -o",
        file.display()
    )))
}

/// Writes the EXR and, unless the output is a device, the PNG and the sheet of techniques, whose paths are
/// returned. What else is to be seen takes its time: the image is written before, and with it once more.
pub(super) fn write_files(
    output: &Path,
    plan: &Plan,
    arguments: &RenderArguments,
    rendered: &Rendered,
    more: &dyn Fn() -> Result<More, Failure>,
) -> Result<Vec<PathBuf>, Failure> {
    let variance = rendered.film.variance();
    let attributes = attributes(plan, arguments, rendered);
    let gradients = plan.integrator == "gdpt";
    let is_device = output.exists() && !output.is_file();
    // What was sampled first, as it takes a while to make a large image of it; which is written whatever becomes of that.
    let sampled = match gradients && !is_device {
        true => write_gradients(output, rendered, &attributes),
        false => Ok(()),
    };
    let rgb = reconstructed(rendered, plan.reconstruction);
    // The variance of what gradients and pixels make together is not known.
    let known = !gradients || plan.reconstruction == Reconstruction::None;
    let mut layers = More::new();
    for (layer, [image, _]) in &rendered.layers {
        if let Layer::Technique { .. } = layer {
            layers.insert(layer.to_string(), image.clone());
        }
    }
    let mut exr = Exr { rgb, variance: variance.filter(|_| known), layers, attributes };
    if is_device {
        exr.layers.extend(more()?);
        exr.write(output)?;
        return Ok(Vec::new());
    }
    write_or_save(&exr, output)?;
    sampled?;
    let more = more()?;
    if !more.is_empty() {
        exr.layers.extend(more);
        write_or_save(&exr, output)?;
    }
    let picture = output.with_extension("png");
    png::write(&exr.rgb, &picture)?;
    let Some(sheet) = contact_sheet(&rendered.layers) else { return Ok(vec![picture]) };
    let techniques = beside(output, "-techniques.png");
    png::write(&sheet, &techniques)?;
    Ok(vec![picture, techniques])
}

/// Writes an image, and where that fails, for a disk that is full or a directory that is gone, into the directory for temporary
/// files: it may have taken hours. That is an error all the same, which says where the image is.
fn write_or_save(exr: &Exr, output: &Path) -> Result<(), Failure> {
    let Err(error) = exr.write(output) else { return Ok(()) };
    let name = beside(output, &format!("-{}.exr", std::process::id()));
    let saved = std::env::temp_dir().join(name.file_name().unwrap_or_default());
    if exr.write(&saved).is_err() {
        return Err(error.into());
    }
    Err(Failure::new(format!("{error}; the image is in `{}`", saved.display())))
}

/// What is written beside an image that is made of gradients and of what was sampled.
const GRADIENTS: [Layer; 3] = [Layer::Dx, Layer::Dy, Layer::Direct];

/// Writes what an image is made of, beside it: for `NAME.exr`, the image as it was sampled as `NAME-primal.exr`, the
/// right and lower neighbours minus each pixel as `NAME-dx.exr` and `NAME-dy.exr`, and what they leave out as
/// `NAME-direct.exr`.
fn write_gradients(
    output: &Path,
    rendered: &Rendered,
    attributes: &BTreeMap<String, Attribute>,
) -> Result<(), Failure> {
    let write = |name: &str, rgb: RgbImage, variance: Option<RgbImage>| {
        let exr = Exr { rgb, variance, layers: BTreeMap::new(), attributes: attributes.clone() };
        exr.write(&beside(output, &format!("-{name}.exr")))
    };
    let (width, height) = rendered.film.size();
    let black = || RgbImage::filled(width as usize, height as usize, [0.0; 3]);
    write("primal", rendered.film.image(), rendered.film.variance())?;
    for layer in GRADIENTS {
        let found = rendered.layers.get(&layer).cloned();
        let [rgb, variance] = found.unwrap_or_else(|| [black(), black()]);
        write(&layer.to_string(), rgb, Some(variance))?;
    }
    Ok(())
}

/// How the image was made, for the header of the file.
fn attributes(
    plan: &Plan,
    arguments: &RenderArguments,
    rendered: &Rendered,
) -> BTreeMap<String, Attribute> {
    let text = |text: &str| Attribute::Text(text.to_owned());
    let count = |samples: u32| Attribute::Integer(i32::try_from(samples).unwrap_or(i32::MAX));
    let (fewest, most) = rendered.film.samples();
    let mut attributes = BTreeMap::from([
        ("scene", text(&arguments.scene.to_string_lossy())),
        ("integrator", text(&plan.integrator)),
        ("settings", text(&of_image(&settings(plan, arguments)))),
        // As text, for a seed has 64 bits and an integer attribute 32.
        ("seed", text(&plan.seed.to_string())),
        ("sampler", text(plan.sampler_name())),
        ("samples", count(fewest)),
        ("seconds", Attribute::Number(rendered.seconds)),
        ("rays", text(&rendered.work.rays().to_string())),
        ("densities", text(&rendered.work.densities.to_string())),
        ("crop", text(&crop_text(plan.crop))),
        ("program", text(concat!("aether ", env!("CARGO_PKG_VERSION")))),
    ]);
    if most != fewest {
        attributes.insert("samplesMost", count(most));
    }
    if rendered.film.correlation() != 1.0 {
        attributes.insert(CORRELATION, Attribute::Number(rendered.film.correlation()));
    }
    attributes.into_iter().map(|(name, value)| (name.to_owned(), value)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cli::summary::summary;
    use crate::cli::tests::parsed;
    use crate::render::{Budget, PixelKernel, RenderSettings, render};
    use crate::scene::SamplerKind;

    /// Two values in turn: mean 2, variance of the mean of four samples 1/3.
    struct Alternating;

    impl PixelKernel for Alternating {
        type Scratch = ();

        fn scratch(&self) {}

        fn sample(&self, _: &mut (), _: (u32, u32), sample: u32) -> [f32; 3] {
            [1.0 + 2.0 * (sample % 2) as f32; 3]
        }
    }

    #[test]
    fn output_names() {
        let name = |line: &[&str]| output_path(&parsed(line)).map_err(|e| e.to_string());
        assert_eq!(name(&["scenes/a.b.xml"]), Ok("a.b.exr".into()));
        assert_eq!(name(&["a.xml", "-o", "x/y.EXR"]), Ok("x/y.EXR".into()));
        assert!(name(&["a.xml", "-o", "y.png"]).unwrap_err().contains("must end in .exr"));
        assert!(name(&[".."]).is_err());
    }

    #[test]
    fn files_carry_pixels_variance_and_history() {
        let plan = Plan {
            integrator: "path".to_owned(),
            size: (7, 5),
            crop: (0, 0),
            samples: 4,
            seed: u64::MAX,
            sampler: SamplerKind::Independent,
            max_depth: None,
            rr_depth: 5,
            kind: "Everything".to_owned(),
            techniques: Default::default(),
            light_paths: None,
            clamp: None,
            mutations: Default::default(),
            separate_direct: true,
            reconstruction: Default::default(),
            hide_emitters: false,
            sample_parameters: Vec::new(),
        };
        let settings = RenderSettings::new(plan.size, Budget::Samples(4));
        let rendered = render(&Alternating, &settings, &());
        let output = std::env::temp_dir().join(format!("aether-render-{}.exr", std::process::id()));
        let arguments = parsed(&["box.xml", "-D", "a=1", "-D", "b=2"]);
        let more = || Ok(More::from([("albedo".to_owned(), RgbImage::filled(7, 5, [0.5; 3]))]));
        let pictures = write_files(&output, &plan, &arguments, &rendered, &more).unwrap();
        assert_eq!(pictures, [output.with_extension("png")]);
        let exr = Exr::read(&output).unwrap();
        std::fs::remove_file(&output).unwrap();
        std::fs::remove_file(&pictures[0]).unwrap();
        assert_eq!(exr.layers["albedo"].pixel(3, 3), [0.5; 3]);

        assert_eq!(exr.rgb.pixel(6, 4), [2.0; 3]);
        assert_eq!(exr.variance.unwrap().pixel(0, 0), [1.0 / 3.0; 3]);
        let text = |text: &str| Attribute::Text(text.to_owned());
        assert_eq!(exr.attributes["scene"], text("box.xml"));
        assert_eq!(exr.attributes["integrator"], text("path"));
        assert_eq!(exr.attributes["settings"], text("max_depth=-1 rr_depth=5 -D a=1 -D b=2"));
        assert_eq!(exr.attributes["seed"], text("18446744073709551615"));
        assert_eq!(exr.attributes["sampler"], text("independent"));
        assert_eq!(exr.attributes["samples"], Attribute::Integer(4));
        assert!(matches!(exr.attributes["seconds"], Attribute::Number(s) if s > 0.0));
        assert!(
            matches!(&exr.attributes["program"], Attribute::Text(v) if v.starts_with("aether"))
        );

        let line = summary(&output, &pictures, &rendered);
        assert!(
            line.contains("4 samples per pixel in") && line.ends_with("error 28.9 %"),
            "{line}"
        );
    }
}
