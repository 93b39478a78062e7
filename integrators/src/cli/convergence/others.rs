//! Images of other programs: those that are given, and those that they render now.

use std::path::Path;

use super::inputs::{Written, read_images};
use super::seeds::keep;
use super::{Failure, Images, Run, warn};
use crate::convergence::adapter::{self, Request};
use crate::convergence::measure::{ladder, row};
use crate::convergence::record::{Curve, plain};
use crate::convergence::reference::Reference;
use crate::convergence::report::Measurements;

impl Run<'_> {
    /// Renders with other programs and compares their images. What has been measured is not lost if one of them fails.
    pub(super) fn against(
        &self,
        samples: u32,
        output: &Path,
        reference: &Reference,
        (all, images): (&mut Measurements, &mut Images),
    ) {
        for program in &self.arguments.against {
            let outcome = self
                .render_with(program, output, samples)
                .and_then(|list| self.take(read_images(list)?, reference, (all, images)));
            if let Err(failure) = outcome {
                warn(&format!("warning: {failure}"));
                let line = failure.to_string().replace('\n', " ");
                all.notes.push(format!("{}: {program} is not measured: {line}", self.name));
            }
        }
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
    pub(super) fn take(
        &self,
        list: Written,
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
}
