//! The renders that are measured: how many samples each has, its seeds, and what these say together.

use super::super::arguments::RenderArguments;
use super::super::kernel::kernel_for;
use super::super::plan::Plan;
use super::super::terminal::Terminal;
use super::{Failure, Images, Run, warn};
use crate::convergence::bias::{Spread, spread};
use crate::convergence::measure::{Effort, Subject, measure, samples_within};
use crate::convergence::record::{Curve, Estimate, Row, plain};
use crate::convergence::reference::Reference;
use crate::convergence::report::Measurements;
use crate::convergence::statistics::Interval;
use crate::image::RgbImage;
use crate::render::Observer;

/// An integrator, and how many samples per pixel it has.
pub(super) type Measured<'a> = (Subject<'a>, u32);

impl<'a> Run<'a> {
    pub(super) fn subject(&self, label: &str, arguments: &RenderArguments) -> Subject<'a> {
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

    /// What is measured, each with as many samples as the budget has room for.
    pub(super) fn measured(
        &self,
        entries: &[(String, RenderArguments)],
        notes: &mut Vec<String>,
        terminal: &Terminal,
    ) -> Result<Vec<Measured<'a>>, Failure> {
        let effort = self.effort();
        let mut measured = Vec::new();
        for (label, arguments) in entries {
            let subject = self.subject(label, arguments);
            let (samples, seconds) =
                samples_within(&subject, &effort, terminal).map_err(Failure::new)?;
            warn(&format!("{label}: {samples} samples per pixel in {seconds:.1} s"));
            if seconds > 1.5 * effort.budget {
                notes.push(format!(
                    "{}, {label}: the budget of {} s is too small for it; one sample per pixel takes {seconds:.0} s.",
                    self.name, effort.budget
                ));
            }
            measured.push((subject, samples));
        }
        Ok(measured)
    }

    /// Renders seed by seed, so that a machine that is busy for a while disturbs all integrators alike. Returns how many seeds
    /// are complete.
    pub(super) fn seeds(
        &self,
        measured: &[Measured<'a>],
        reference: &Reference,
        (all, images): (&mut Measurements, &mut Images),
        terminal: &Terminal,
    ) -> Result<u16, Failure> {
        let effort = self.effort();
        let mut repeats = 0;
        while repeats < self.arguments.repeats {
            let seed = self.arguments.seed + u64::from(repeats);
            let of_seed = |(subject, samples): &Measured<'_>| {
                measure(subject, (seed, *samples), &effort, reference, terminal)
            };
            let of_seed: Result<Vec<_>, String> = measured.iter().map(of_seed).collect();
            // Seeds that are complete are not lost if the next one is interrupted.
            if of_seed.is_err() && repeats > 0 && terminal.cancelled() {
                break;
            }
            repeats += 1;
            for (rows, image) in of_seed.map_err(Failure::new)? {
                note_broken(&mut all.notes, &image, &rows);
                keep(images, &rows, image);
                all.rows.extend(rows);
            }
        }
        let place = |row: &Row| measured.iter().position(|(s, _)| s.name == row.curve.integrator);
        all.rows.sort_by_key(place);
        Ok(repeats)
    }
}

/// Keeps the image of a seed with those of its curve.
pub(super) fn keep(images: &mut Images, rows: &[Row], image: RgbImage) {
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

/// What the images of all seeds of each curve say together.
pub(super) fn estimates(images: &Images, rows: &[Row], reference: &Reference) -> Vec<Estimate> {
    let of = |(curve, images): &(Curve, Vec<RgbImage>)| estimate(curve, images, rows, reference);
    images.iter().filter_map(of).collect()
}

/// [`estimates`] of a curve.
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
