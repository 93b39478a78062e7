//! What a render that goes on from a checkpoint has to have in common with the one before.

use std::fs::File;
use std::io;
use std::path::{Path, PathBuf};

use flate2::CrcWriter;

use super::Failure;
use super::arguments::RenderArguments;
use super::plan::Plan;
use super::settings::{of_samples, settings};
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
            return Ok(Checkpoint::new(file, identity(scene, plan, arguments)?));
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
fn identity(
    scene: &Scene,
    plan: &Plan,
    arguments: &RenderArguments,
) -> Result<Vec<(String, String)>, Failure> {
    let mut settings = of_samples(settings(plan, arguments));
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
