//! `aether convergence`: errors of integrators against time.

use std::path::{Path, PathBuf};
use std::process::ExitCode;

use super::arguments::{ConvergenceArguments, RenderArguments, render_arguments};
use super::kernel::{Plan, algorithm_for, kernel_for, load};
use super::terminal::Terminal;
use super::{Failure, INTERRUPTED, print, warn};
use crate::algorithm::Algorithm;
use crate::convergence::adapter::{self, Request};
use crate::convergence::bias::{Spread, spread};
use crate::convergence::measure::{
    Effort, Subject, ladder, measure, reference_seed, row, samples_within,
};
use crate::convergence::page::reference_curve;
use crate::convergence::picture::{Crop, cut, error_picture, mean, telling_crop};
use crate::convergence::record::{Curve, Estimate, Row, plain};
use crate::convergence::reference::{Reference, crop_text};
use crate::convergence::report::Measurements;
use crate::convergence::statistics::Interval;
use crate::convergence::summary::summarise;
use crate::image::exr::{Attribute, Exr};
use crate::image::{RgbImage, png};
use crate::render::{Budget, Observer, RenderSettings, render};
use crate::scene::Scene;

/// Measures, and writes tables, pictures and the report.
pub(super) fn run(arguments: &ConvergenceArguments) -> Result<ExitCode, Failure> {
    let name = arguments.name.clone().unwrap_or_else(|| scene_name(&arguments.scene));
    let output = match &arguments.output {
        Some(output) => output.clone(),
        None => PathBuf::from(format!("convergence-{name}")),
    };
    let entries = entries(arguments)?;
    if arguments.seed.checked_add(arguments.repeats.into()).is_none() {
        let most = u64::MAX - u64::from(arguments.repeats);
        return Err(Failure::new(format!(
            "there are no {} seeds from {} on; give a --seed of at most {most}",
            arguments.repeats, arguments.seed
        )));
    }
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
    let cancelled = terminal.cancelled();
    if cancelled && outcome.is_err() {
        warn("interrupted before a seed was complete; nothing is written");
        return Ok(ExitCode::from(INTERRUPTED));
    }
    let measurements = outcome?;
    measurements.write(&output).map_err(Failure::new)?;
    print(&measurements.report(&output).map_err(Failure::new)?)?;
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

impl<'a> Run<'a> {
    fn subject(&self, label: &str, arguments: &RenderArguments) -> Subject<'a> {
        let (plan, scene) = (Plan::new(self.scene, arguments), self.scene);
        let reconstruction = plan.reconstruction;
        let kernel = move |seed| {
            let plan = Plan { seed, ..plan.clone() };
            kernel_for(scene, &plan).map_err(|error| error.to_string())
        };
        Subject { name: label.to_owned(), kernel: Box::new(kernel), reconstruction }
    }

    fn effort(&self) -> Effort {
        Effort {
            scene: self.name.clone(),
            size: self.plan.size,
            threads: self.arguments.threads,
            budget: self.arguments.budget,
        }
    }

    fn measure(
        &self,
        entries: &[(String, RenderArguments)],
        output: &Path,
        terminal: &Terminal,
    ) -> Result<Measurements, Failure> {
        let effort = self.effort();
        // What cannot work fails before anything is rendered.
        for (_, arguments) in entries {
            algorithm_for(self.scene, &Plan::new(self.scene, arguments))?;
        }
        let makers = self.makers()?;
        let (columns, rows) = self.plan.size;
        let size = (columns as usize, rows as usize);
        if let Some(crop) = self.arguments.crop {
            check_crop(crop, size)?;
        }
        let given = self.given_reference()?;
        let list = self.arguments.images.as_ref().map(|path| adapter::read_list(path));
        let list = list.transpose().map_err(Failure::new)?.unwrap_or_default();
        let list = read_images(list)?;
        for (entry, image) in &list {
            check_size(&entry.file, image, size)?;
        }
        let (mut measured, mut slow) = (Vec::new(), Vec::new());
        for (label, arguments) in entries {
            let subject = self.subject(label, arguments);
            let (samples, seconds) =
                samples_within(&subject, &effort, terminal).map_err(Failure::new)?;
            warn(&format!("{label}: {samples} samples per pixel in {seconds:.1} s"));
            if seconds > 1.5 * effort.budget {
                slow.push(format!(
                    "{}, {label}: the budget of {} s is too small for it; one sample per pixel takes {seconds:.0} s.",
                    self.name, effort.budget
                ));
            }
            measured.push((subject, samples));
        }
        let reference = match given {
            Some(reference) => reference,
            None => self.make_reference(&makers, &output.join("reference.exr"), terminal)?,
        };
        slow.extend(reference.doubts.iter().map(|doubt| format!("{}: {doubt}", self.name)));
        let mut all = Measurements { notes: slow, ..Measurements::default() };
        let mut images: Images = Vec::new();
        // Seed by seed, so that a machine that is busy for a while disturbs all integrators alike.
        let (mut repeats, wanted) = (0, self.arguments.repeats);
        while repeats < wanted {
            let seed = self.arguments.seed + u64::from(repeats);
            let of_seed = |(subject, samples): &(Subject<'_>, u32)| {
                measure(subject, (seed, *samples), &effort, &reference, terminal)
            };
            let of_seed: Result<Vec<_>, String> = measured.iter().map(of_seed).collect();
            // Seeds that are complete are not lost if the next one is interrupted.
            if of_seed.is_err() && repeats > 0 && terminal.cancelled() {
                break;
            }
            repeats += 1;
            for (rows, image) in of_seed.map_err(Failure::new)? {
                note_broken(&mut all.notes, &image, &rows);
                keep(&mut images, &rows, image);
                all.rows.extend(rows);
            }
        }
        all.rows
            .sort_by_key(|row| measured.iter().position(|(s, _)| s.name == row.curve.integrator));
        self.take(list, &reference, (&mut all, &mut images))?;
        if repeats < wanted {
            all.notes
                .push(format!("{}: interrupted after {repeats} of {wanted} seeds.", self.name));
        }
        for program in self.arguments.against.iter().filter(|_| repeats == wanted) {
            // What has been measured is not lost if another program fails.
            let outcome = self.render_with(program, output, measured[0].1).and_then(|list| {
                self.take(read_images(list)?, &reference, (&mut all, &mut images))
            });
            if let Err(failure) = outcome {
                warn(&format!("warning: {failure}"));
                let line = failure.to_string().replace('\n', " ");
                all.notes.push(format!("{}: {program} is not measured: {line}", self.name));
            }
        }
        all.estimates = images
            .iter()
            .filter_map(|(curve, images)| estimate(curve, images, &all.rows, &reference))
            .collect();
        if repeats < 3 {
            all.notes.push(format!("{}: intervals and biases need three seeds.", self.name));
        }
        self.pictures(&mut all, &images, &reference)?;
        Ok(all)
    }

    fn given_reference(&self) -> Result<Option<Reference>, Failure> {
        let read = |path: &PathBuf| Reference::read(path, self.plan.size, self.plan.crop);
        self.arguments.reference.as_ref().map(read).transpose().map_err(Failure::new)
    }

    /// The integrators that make the reference, unless it is given.
    fn makers(&self) -> Result<Vec<(&str, RenderArguments)>, Failure> {
        let is_made = self.arguments.reference.is_none();
        let names = self.arguments.reference_by.iter().filter(|_| is_made);
        let maker = |name: &'a String| {
            let arguments = render_arguments(self.arguments, name).map_err(Failure::new)?;
            let algorithm = algorithm_for(self.scene, &Plan::new(self.scene, &arguments))?;
            if matches!(algorithm, Algorithm::Metropolis(_) | Algorithm::PrimarySample(_)) {
                return Err(Failure::new(format!(
                    "the reference cannot be made by `{name}`, whose samples depend on each other, so that its variance \
                     is not known; give other integrators with --reference-by, or --reference"
                )));
            }
            Ok((name.as_str(), arguments))
        };
        names.map(maker).collect()
    }

    /// Renders the reference by several integrators.
    fn make_reference(
        &self,
        makers: &[(&str, RenderArguments)],
        path: &Path,
        terminal: &Terminal,
    ) -> Result<Reference, Failure> {
        let seconds = self.arguments.reference_time.unwrap_or(16.0 * self.arguments.budget);
        let mut parts = Vec::new();
        for (k, (name, arguments)) in makers.iter().enumerate() {
            let subject = self.subject(name, arguments);
            let kernel = (subject.kernel)(reference_seed(k)).map_err(Failure::new)?;
            let settings = RenderSettings {
                threads: self.arguments.threads,
                ..RenderSettings::new(self.plan.size, Budget::Seconds(seconds))
            };
            warn(&format!("reference: {name} for {seconds} s"));
            let rendered = render(kernel.as_ref(), &settings, terminal);
            let Some(variance) = rendered.film.variance().filter(|_| !rendered.cancelled) else {
                return Err(Failure::new(format!(
                    "the reference cannot be made by `{name}`, whose variance is not known after {seconds} s; give \
                     other integrators with --reference-by, more seconds with --reference-time, or --reference"
                )));
            };
            parts.push(((*name).to_owned(), rendered.film.image(), variance));
        }
        let mut reference = Reference::union(&parts)?;
        if let [(name, ..)] = &parts[..]
            && self.arguments.integrators.contains(name)
        {
            reference.doubts.push(format!(
                "The reference is made by {name} alone, so that a bias of {name} does not show."
            ));
        }
        let text = |text: &str| Attribute::Text(text.to_owned());
        let attributes = [
            ("integrator".to_owned(), text(&reference.made_by)),
            ("crop".to_owned(), text(&crop_text(self.plan.crop))),
        ];
        let (rgb, variance) = (reference.image.clone(), reference.variance.clone());
        Exr { rgb, variance, layers: Default::default(), attributes: attributes.into() }
            .write(path)?;
        Ok(reference)
    }

    /// Renders with another program.
    fn render_with(
        &self,
        program: &str,
        output: &Path,
        samples: u32,
    ) -> Result<Vec<adapter::Entry>, Failure> {
        warn(&format!("{program} renders"));
        let request = Request {
            scene: &self.arguments.scene,
            defines: &self.arguments.defines,
            portals: &self.scene.integrator.portals,
            size: self.plan.size,
            max_depth: self.plan.max_depth,
            rr_depth: self.plan.rr_depth,
            threads: self.arguments.threads,
            budget: self.arguments.budget,
            samples: &ladder(samples),
            seeds: self.arguments.seed..self.arguments.seed + u64::from(self.arguments.repeats),
        };
        let list = adapter::run(program, &self.arguments.python, &request, output);
        list.and_then(|list| adapter::read_list(&list)).map_err(Failure::new)
    }

    /// Compares images that other programs have written; of each curve, those with most samples are kept.
    fn take(
        &self,
        list: Vec<(adapter::Entry, RgbImage)>,
        reference: &Reference,
        (all, images): (&mut Measurements, &mut Images),
    ) -> Result<(), Failure> {
        for (entry, image) in list {
            let (renderer, integrator) = (plain(&entry.renderer), plain(&entry.integrator));
            let curve = Curve { scene: self.name.clone(), renderer, integrator };
            let row = row(&curve, entry.seed, (entry.spp, entry.seconds), &image, reference)
                .map_err(|error| Failure::new(format!("`{}`: {error}", entry.file.display())))?;
            let largest = all.rows.iter().filter(|r| r.curve == curve).map(|r| r.spp).max();
            if largest.is_some_and(|largest| row.spp > largest) {
                images.retain(|(other, _)| *other != curve);
            }
            if largest.is_none_or(|largest| row.spp >= largest) {
                keep(images, std::slice::from_ref(&row), image);
            }
            all.rows.push(row);
        }
        Ok(())
    }

    /// Pictures of the reference and of one seed of each curve, and the parts of them for strips.
    fn pictures(
        &self,
        all: &mut Measurements,
        images: &Images,
        reference: &Reference,
    ) -> Result<(), Failure> {
        let firsts: Vec<&RgbImage> = images.iter().filter_map(|(_, seeds)| seeds.first()).collect();
        let crop = self.arguments.crop.unwrap_or_else(|| telling_crop(&firsts, &reference.image));
        let mut add = |name: String, image: &RgbImage| {
            let bytes = png::encode(image).map_err(|error| Failure::new(error.to_string()))?;
            all.pictures.push((name, bytes));
            Ok::<(), Failure>(())
        };
        let scene = summarise(&all.rows, &[]);
        let slug = scene.first().map(|scene| reference_curve(scene).slug()).unwrap_or_default();
        add(slug.clone(), &reference.image)?;
        add(format!("{slug}-crop"), &cut(&reference.image, crop))?;
        for (curve, seeds) in images {
            let Some(first) = seeds.first() else { continue };
            let slug = curve.slug();
            let error = error_picture(first, &reference.image);
            add(format!("{slug}-crop"), &cut(first, crop))?;
            add(format!("{slug}-crop-error"), &cut(&error, crop))?;
            add(format!("{slug}-error"), &error)?;
            add(slug.clone(), first)?;
            let all_seeds: Vec<&RgbImage> = seeds.iter().collect();
            if let Some(mean) = mean(&all_seeds).filter(|_| seeds.len() > 1) {
                add(format!("{slug}-mean-error"), &error_picture(&mean, &reference.image))?;
            }
        }
        Ok(())
    }
}

/// Images that other programs have written, with what is known of them.
fn read_images(list: Vec<adapter::Entry>) -> Result<Vec<(adapter::Entry, RgbImage)>, Failure> {
    let read = |entry: adapter::Entry| {
        let image = Exr::read(&entry.file)?.rgb;
        Ok((entry, image))
    };
    list.into_iter().map(read).collect()
}

/// An error unless an image has the columns and rows of those that are measured.
fn check_size(file: &Path, image: &RgbImage, size: (usize, usize)) -> Result<(), Failure> {
    let found = (image.width(), image.height());
    if found == size {
        return Ok(());
    }
    Err(Failure::new(format!(
        "`{}` has {}x{} pixels, and what is measured {}x{}",
        file.display(),
        found.0,
        found.1,
        size.0,
        size.1
    )))
}

/// An error unless a part of an image with so many columns and rows lies in it.
fn check_crop((x, y, width, height): Crop, (columns, rows): (usize, usize)) -> Result<(), Failure> {
    let within = |begin: usize, length: usize, side: usize| begin < side && length <= side - begin;
    if within(x, width, columns) && within(y, height, rows) {
        return Ok(());
    }
    Err(Failure::new(format!(
        "--crop {x},{y},{width},{height} does not lie in the image of {columns}x{rows} pixels"
    )))
}

fn keep(images: &mut Images, rows: &[Row], image: RgbImage) {
    let Some(row) = rows.last() else { return };
    match images.iter_mut().find(|(curve, _)| *curve == row.curve) {
        Some((_, seeds)) => seeds.push(image),
        None => images.push((row.curve.clone(), vec![image])),
    }
}

fn note_broken(notes: &mut Vec<String>, image: &RgbImage, rows: &[Row]) {
    if let (Some(row), count @ 1..) = (rows.last(), image.non_finite_pixels()) {
        let (label, seed) = (row.curve.label(), row.seed);
        notes.push(format!("{label}, seed {seed}: {count} pixels are NaN or infinite."));
    }
}

/// What the images of all seeds say together.
fn estimate(
    curve: &Curve,
    images: &[RgbImage],
    rows: &[Row],
    reference: &Reference,
) -> Option<Estimate> {
    let spp = rows.iter().filter(|row| row.curve == *curve).map(|row| row.spp).max()?;
    let spread = spread(&images.iter().collect::<Vec<_>>(), reference);
    let three = |of: fn(&Spread) -> Interval| {
        spread.as_ref().map_or([f64::NAN; 3], |spread| {
            let Interval { value, low, high } = of(spread);
            [value, low, high]
        })
    };
    Some(Estimate {
        curve: curve.clone(),
        seeds: images.len(),
        spp,
        variance: three(|spread| spread.variance).map(|value| value * f64::from(spp)),
        bias: three(|spread| spread.bias),
        biased: spread.is_some_and(|spread| spread.biased),
        floor: reference.floor(),
        reference: plain(&reference.made_by),
    })
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

    #[test]
    fn parts_lie_in_the_image() {
        let size = (8, 6);
        assert!(check_crop((0, 0, 8, 6), size).is_ok());
        for wrong in [(8, 0, 1, 1), (0, 0, 9, 1), (4, 4, 2, 3), (usize::MAX, 0, 2, 2)] {
            assert!(check_crop(wrong, size).is_err(), "{wrong:?}");
        }
    }
}
