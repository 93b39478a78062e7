//! Renders with growing numbers of samples.

use std::sync::{Mutex, PoisonError};
use std::time::Instant;

use super::record::{Curve, Row};
use super::reference::Reference;
use crate::gradient_domain::{reconstructed, with_gradients};
use crate::image::RgbImage;
use crate::image::compare::compare_pixels;
use crate::poisson::Reconstruction;
use crate::render::{AnyKernel, Budget, Film, Layers, Observer, Progress, RenderSettings, render};
use crate::work::Work;

/// An integrator with a scene, for a seed, or why there is none.
pub type MakeKernel<'a> = dyn Fn(u64) -> Result<Box<dyn AnyKernel + 'a>, String> + 'a;

/// An integrator to be measured.
pub struct Subject<'a> {
    /// Its name in reports.
    pub name: String,
    /// The integrator for a seed.
    pub kernel: Box<MakeKernel<'a>>,
    /// How an image is made of gradients, if it renders any.
    pub reconstruction: Reconstruction,
}

/// What all renders have in common.
#[derive(Clone, Debug)]
pub struct Effort {
    /// The name of the scene in reports.
    pub scene: String,
    /// Columns and rows.
    pub size: (u32, u32),
    /// Threads, or `None` for one on each core.
    pub threads: Option<usize>,
    /// Seconds of the longest render.
    pub budget: f64,
}

/// The numbers of samples at which errors are measured up to a largest one: powers of two, and the largest.
pub fn ladder(most: u32) -> Vec<u32> {
    let powers = (0..31).map(|k| 1u32 << k);
    let mut steps: Vec<u32> =
        powers.take_while(|n| f64::from(*n) * 1.4 <= f64::from(most)).collect();
    steps.push(most.max(1));
    steps
}

/// How many samples per pixel fit into the budget, and the seconds that they are expected to take: more than the budget
/// if it is too small for one. By the speed of a render of an eighth of the budget.
///
/// # Errors
/// If the integrator cannot render the scene, or the observer cancels.
pub fn samples_within(
    subject: &Subject<'_>,
    effort: &Effort,
    observer: &dyn Observer,
) -> Result<(u32, f64), String> {
    let kernel = (subject.kernel)(CALIBRATION_SEED)?;
    let budget = Budget::Seconds(effort.budget / 8.0 + kernel.preparation().seconds);
    let settings =
        RenderSettings { threads: effort.threads, ..RenderSettings::new(effort.size, budget) };
    let rendered = render(kernel.as_ref(), &settings, observer);
    if rendered.cancelled {
        return Err("interrupted".to_owned());
    }
    let prepared = kernel.preparation().seconds;
    let speed = f64::from(rendered.film.samples().0) / (rendered.seconds - prepared).max(1e-9);
    // A float outside the range of u32 becomes its nearest end.
    let samples = ((effort.budget - prepared) * speed).clamp(1.0, f64::from(i32::MAX)) as u32;
    Ok((samples, prepared + f64::from(samples) / speed))
}

/// Seeds of renders that are not measured, far from those that are.
const CALIBRATION_SEED: u64 = 0x9e37_79b9_7f4a_7c15;

/// The seed of part `k` of a reference.
pub fn reference_seed(k: usize) -> u64 {
    CALIBRATION_SEED ^ (k as u64 + 1)
}

/// The errors of one render at the steps of its [`ladder`], and its last image. The images at smaller numbers of
/// samples are the beginnings of one render. Measuring is not counted as rendering, what makes an image of gradients is.
///
/// # Errors
/// If the integrator cannot render the scene, an image cannot be compared, or the observer cancels.
pub fn measure(
    subject: &Subject<'_>,
    (seed, samples): (u64, u32),
    effort: &Effort,
    reference: &Reference,
    observer: &dyn Observer,
) -> Result<(Vec<Row>, RgbImage), String> {
    let kernel = (subject.kernel)(seed)?;
    let budget = Budget::Samples(samples);
    let settings =
        RenderSettings { threads: effort.threads, ..RenderSettings::new(effort.size, budget) };
    let curve = Curve {
        scene: effort.scene.clone(),
        renderer: "aether".to_owned(),
        integrator: subject.name.clone(),
    };
    let reconstruction = subject.reconstruction;
    let ladder = ladder(samples);
    let watch = Watch { ladder, observer, reconstruction, looks: Mutex::default() };
    let rendered = render(kernel.as_ref(), &settings, &watch);
    if rendered.cancelled {
        return Err("interrupted".to_owned());
    }
    let looks = watch.looks.into_inner().unwrap_or_else(PoisonError::into_inner);
    let row = |(spp, seconds, work, image): &(u32, f64, Work, RgbImage)| {
        let row = row(&curve, seed, (*spp, *seconds), image, reference)?;
        Ok(Row { rays: Some(work.rays()), densities: Some(work.densities), ..row })
    };
    let rows = looks.iter().map(row).collect::<Result<_, String>>()?;
    let last = looks.into_iter().next_back().map(|(.., image)| image);
    Ok((rows, last.unwrap_or_else(|| reconstructed(&rendered, reconstruction))))
}

/// The row of an image.
///
/// # Errors
/// If it cannot be compared with the reference.
pub fn row(
    curve: &Curve,
    seed: u64,
    (spp, seconds): (u32, f64),
    image: &RgbImage,
    reference: &Reference,
) -> Result<Row, String> {
    let errors = compare_pixels(image, &reference.image).map_err(|error| error.to_string())?;
    Ok(Row {
        curve: curve.clone(),
        seed,
        spp,
        seconds,
        rays: None,
        densities: None,
        rmse: errors.rmse,
        relmse: errors.rel_mse,
        smape: errors.smape,
        flip: errors.flip,
    })
}

/// Keeps the image at each step.
struct Watch<'o> {
    ladder: Vec<u32>,
    observer: &'o dyn Observer,
    reconstruction: Reconstruction,
    /// Samples, seconds, work and image.
    looks: Mutex<Vec<(u32, f64, Work, RgbImage)>>,
}

impl Observer for Watch<'_> {
    fn progress(&self, progress: &Progress) {
        self.observer.progress(progress);
    }

    fn cancelled(&self) -> bool {
        self.observer.cancelled()
    }

    fn look(&self, film: &Film, progress: &Progress, layers: &dyn Fn() -> Layers) {
        if self.ladder.contains(&progress.samples) {
            let (image, layers) = (film.image(), layers());
            let begin = Instant::now();
            let image = with_gradients(image, &layers, self.reconstruction);
            let seconds = progress.seconds + begin.elapsed().as_secs_f64();
            let look = (progress.samples, seconds, progress.work, image);
            self.looks.lock().unwrap_or_else(PoisonError::into_inner).push(look);
        }
    }

    fn next_look(&self, progress: &Progress) -> Option<u32> {
        self.ladder.iter().copied().find(|step| *step > progress.samples)
    }
}
