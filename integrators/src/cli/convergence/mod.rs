//! `aether convergence`: errors of integrators against time.
//!
//! - `inputs`: what is given, checked before anything is rendered;
//! - `reference`: what images are compared with, if it is not given;
//! - `seeds`: the renders that are measured;
//! - `others`: images of other programs;
//! - `pictures`: what reports show.

mod inputs;
mod others;
mod pictures;
mod reference;
mod seeds;

use std::path::{Path, PathBuf};
use std::process::ExitCode;

use super::arguments::{ConvergenceArguments, RenderArguments, render_arguments};
use super::kernel::algorithm_for;
use super::plan::{Plan, load};
use super::terminal::Terminal;
use super::{Failure, INTERRUPTED, print, warn};
use crate::convergence::record::{Curve, plain};
use crate::convergence::report::Measurements;
use crate::image::RgbImage;
use crate::render::Observer;
use crate::scene::Scene;

/// Measures, and writes tables, pictures and the report.
pub(super) fn run(arguments: &ConvergenceArguments) -> Result<ExitCode, Failure> {
    let name = arguments.name.clone().unwrap_or_else(|| scene_name(&arguments.scene));
    let usual = || PathBuf::from(format!("convergence-{name}"));
    let output = arguments.output.clone().unwrap_or_else(usual);
    let entries = entries(arguments)?;
    check_seeds(arguments)?;
    let Some((_, first)) = entries.first() else {
        return Err(Failure::new(
            "there is no integrator to measure; give --integrators or --variant",
        ));
    };
    let scene = load(first)?;
    // Only for what can be measured, and before that takes its time.
    std::fs::create_dir_all(&output)
        .map_err(|error| Failure::new(format!("cannot make `{}`: {error}", output.display())))?;
    let run = Run { arguments, scene: &scene, plan: Plan::new(&scene, first), name: plain(&name) };
    let terminal = Terminal::new();
    let outcome = run.measure(&entries, &output, &terminal);
    terminal.finish();
    write(outcome, &output, terminal.cancelled())
}

/// Writes what has been measured; whatever there is of it after Ctrl-C.
fn write(
    outcome: Result<Measurements, Failure>,
    output: &Path,
    cancelled: bool,
) -> Result<ExitCode, Failure> {
    if cancelled && outcome.is_err() {
        warn("interrupted before a seed was complete; nothing is written");
        return Ok(ExitCode::from(INTERRUPTED));
    }
    let measurements = outcome?;
    measurements.write(output).map_err(Failure::new)?;
    print(&measurements.report(output).map_err(Failure::new)?)?;
    print(&format!("{}", output.join("report.html").display()))?;
    if cancelled {
        warn("interrupted; the seeds that were complete are kept");
        return Ok(ExitCode::from(INTERRUPTED));
    }
    Ok(ExitCode::SUCCESS)
}

/// The name of the file, or of its directory if the file is only called `scene`.
fn scene_name(path: &Path) -> String {
    let text = |part: Option<&std::ffi::OsStr>| part.map(|p| p.to_string_lossy().into_owned());
    let stem = text(path.file_stem()).unwrap_or_default();
    let directory = || text(path.parent()?.file_name());
    if stem == "scene" { directory().unwrap_or(stem) } else { stem }
}

/// An error unless there is a seed for each repetition.
fn check_seeds(arguments: &ConvergenceArguments) -> Result<(), Failure> {
    let ConvergenceArguments { seed, repeats, .. } = arguments;
    if seed.checked_add(u64::from(*repeats)).is_some() {
        return Ok(());
    }
    let most = u64::MAX - u64::from(*repeats);
    Err(Failure::new(format!(
        "there are no {repeats} seeds from {seed} on; give a --seed of at most {most}"
    )))
}

/// What is measured: names, and the renders that they stand for.
fn entries(arguments: &ConvergenceArguments) -> Result<Vec<(String, RenderArguments)>, Failure> {
    let named = arguments.integrators.iter().filter(|name| !name.is_empty());
    let named = named.map(|name| (name.clone(), name.clone()));
    let all = named.chain(arguments.variant.iter().cloned());
    let entry = |(label, integrator): (String, String)| {
        Ok((plain(&label), render_arguments(arguments, &integrator).map_err(Failure::new)?))
    };
    let entries: Vec<(String, RenderArguments)> = all.map(entry).collect::<Result<_, Failure>>()?;
    for (k, (label, _)) in entries.iter().enumerate() {
        if entries[..k].iter().any(|(other, _)| other == label) {
            let message = format!("two integrators are called `{label}`; give each its own name");
            return Err(Failure::new(message));
        }
    }
    Ok(entries)
}

/// One scene.
struct Run<'a> {
    arguments: &'a ConvergenceArguments,
    scene: &'a Scene,
    plan: Plan,
    name: String,
}

/// The images of the seeds of a curve.
type Images = Vec<(Curve, Vec<RgbImage>)>;

impl Run<'_> {
    fn measure(
        &self,
        entries: &[(String, RenderArguments)],
        output: &Path,
        terminal: &Terminal,
    ) -> Result<Measurements, Failure> {
        // What cannot work fails before anything is rendered.
        for (_, arguments) in entries {
            algorithm_for(self.scene, &Plan::new(self.scene, arguments))?;
        }
        let makers = self.makers()?;
        let given = self.given()?;
        let mut all = Measurements::default();
        let measured = self.measured(entries, &mut all.notes, terminal)?;
        let reference = match given.reference {
            Some(reference) => reference,
            None => self.make_reference(&makers, &output.join("reference.exr"), terminal)?,
        };
        let doubts = reference.doubts.iter().map(|doubt| format!("{}: {doubt}", self.name));
        all.notes.extend(doubts);
        let mut images = Images::new();
        let repeats = self.seeds(&measured, &reference, (&mut all, &mut images), terminal)?;
        self.take(given.images, &reference, (&mut all, &mut images))?;
        let wanted = self.arguments.repeats;
        if repeats < wanted {
            all.notes
                .push(format!("{}: interrupted after {repeats} of {wanted} seeds.", self.name));
        } else if let Some((_, samples)) = measured.first() {
            self.against(*samples, output, &reference, (&mut all, &mut images));
        }
        all.estimates = seeds::estimates(&images, &all.rows, &reference);
        if repeats < 3 {
            all.notes.push(format!("{}: intervals and biases need three seeds.", self.name));
        }
        self.pictures(&mut all, &images, &reference)?;
        Ok(all)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_of_scenes() {
        assert_eq!(scene_name(Path::new("a/veach-mis/scene.xml")), "veach-mis");
        assert_eq!(scene_name(Path::new("a/box.xml")), "box");
        assert_eq!(scene_name(Path::new("scene.xml")), "scene");
    }
}
