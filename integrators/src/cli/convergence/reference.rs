//! The reference, where it is not given.

use std::path::Path;

use super::super::arguments::{RenderArguments, render_arguments};
use super::super::kernel::algorithm_for;
use super::super::plan::Plan;
use super::super::terminal::Terminal;
use super::{Failure, Run, warn};
use crate::algorithm::Algorithm;
use crate::convergence::measure::reference_seed;
use crate::convergence::reference::{Reference, crop_text};
use crate::image::exr::{Attribute, Exr};
use crate::render::{Budget, RenderSettings, render};

impl<'a> Run<'a> {
    /// The integrators that make the reference, unless it is given.
    pub(super) fn makers(&self) -> Result<Vec<(&str, RenderArguments)>, Failure> {
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
    pub(super) fn make_reference(
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
}
