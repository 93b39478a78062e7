//! What a render that goes on from a checkpoint has to have in common with the one before.

use std::fs::File;
use std::io;
use std::path::{Path, PathBuf};

use flate2::CrcWriter;

use super::Failure;
use super::arguments::RenderArguments;
use super::kernel::Plan;
use crate::image::check_writable;
use crate::render::checkpoint::Checkpoint;
use crate::scene::Scene;

/// The checkpoint of a render, in a file that is neither read nor one of those `written`.
pub(super) fn checkpoint(
    file: &Path,
    scene: &Scene,
    plan: &Plan,
    (arguments, written): (&RenderArguments, &[PathBuf]),
) -> Result<Checkpoint, Failure> {
    let own = place(file);
    let is_same = |other: &PathBuf| place(other) == own;
    let used = match (scene.files.iter().any(is_same), written.iter().any(is_same)) {
        (true, _) => "the scene is read from it",
        (_, true) => "the render writes an image to it",
        _ => {
            check_writable(file)?;
            return Ok(Checkpoint::new(file, settings(scene, plan, arguments)?));
        }
    };
    let file = file.display();
    Err(Failure::new(format!(
        "`{file}` cannot keep the state of the render: {used}; name another file with --checkpoint"
    )))
}

/// A file, whether it exists or not, by the one name that its directory has.
pub(super) fn place(file: &Path) -> PathBuf {
    let directory = file.parent().filter(|parent| !parent.as_os_str().is_empty());
    let in_directory = || {
        let directory = directory.unwrap_or(Path::new(".")).canonicalize().ok()?;
        Some(directory.join(file.file_name()?))
    };
    file.canonicalize().ok().or_else(in_directory).unwrap_or_else(|| file.to_owned())
}

/// All that the samples depend on, apart from how many there are, by names that a user knows.
fn settings(
    scene: &Scene,
    plan: &Plan,
    arguments: &RenderArguments,
) -> Result<Vec<(String, String)>, Failure> {
    let Plan { integrator, size, crop, seed, max_depth, rr_depth, kind, .. } = plan;
    let Plan { techniques, light_paths, clamp, mutations, separate_direct, .. } = plan;
    // Windows that are good enough for one target may not be for another.
    let adaptive = arguments.target_error.filter(|_| arguments.adaptive);
    let counts_samples = |name: &String| scene.sample_parameters.contains(name);
    let parameters: Vec<_> =
        arguments.defines.iter().filter(|(name, _)| !counts_samples(name)).collect();
    let mut settings = vec![
        ("version of the program", env!("CARGO_PKG_VERSION").to_owned()),
        ("size", format!("{}x{}", size.0, size.1)),
        ("crop", format!("{},{}", crop.0, crop.1)),
        ("integrator", integrator.clone()),
        ("seed", seed.to_string()),
        ("sampler", plan.sampler_name().to_owned()),
        ("kind", kind.clone()),
        ("max_depth", max_depth.map_or("-1".to_owned(), |depth| depth.to_string())),
        ("rr_depth", rr_depth.to_string()),
        ("hide_emitters", scene.integrator.hide_emitters.to_string()),
        ("techniques", techniques.to_string()),
        ("light paths", format!("{light_paths:?}")),
        ("clamp", format!("{clamp:?}")),
        ("mutations", format!("{mutations:?}")),
        ("separate direct light", separate_direct.to_string()),
        ("technique images", format!("{:?}", arguments.technique_images)),
        ("adaptive target error", format!("{adaptive:?}")),
        ("parameters", format!("{parameters:?}")),
        ("portals", format!("{:?}", arguments.portals)),
        ("mitsuba3_roughplastic", arguments.mitsuba3_roughplastic.to_string()),
    ]
    .into_iter()
    .map(|(name, value)| (name.to_owned(), value))
    .collect::<Vec<_>>();
    for (number, file) in scene.files.iter().enumerate() {
        let contents = digest(file).map_err(|error| {
            Failure::new(format!("`{}` cannot be read again: {error}", file.display()))
        })?;
        let name = file.file_name().unwrap_or_default().to_string_lossy();
        settings.push((format!("file {}", number + 1), format!("{name}, {contents}")));
    }
    Ok(settings)
}

/// Length and checksum of a file.
fn digest(file: &Path) -> io::Result<String> {
    let mut sum = CrcWriter::new(io::sink());
    io::copy(&mut File::open(file)?, &mut sum)?;
    Ok(format!("{} bytes, checksum {:08x}", sum.crc().amount(), sum.crc().sum()))
}
