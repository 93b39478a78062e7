//! What images are compared with: a given image, or one made by several integrators together.

use std::path::Path;

use crate::image::block_test::{BlockTestOptions, block_z_test};
use crate::image::compare::RELATIVE_OFFSET;
use crate::image::exr::{Attribute, Exr};
use crate::image::{ImageError, RgbImage};

/// An image that is taken as the truth, and what is known of its error.
#[derive(Clone, Debug, PartialEq)]
pub struct Reference {
    /// The image.
    pub image: RgbImage,
    /// The variance of the mean of its pixels, if it is known.
    pub variance: Option<RgbImage>,
    /// How it was made.
    pub made_by: String,
    /// What is strange about it.
    pub doubts: Vec<String>,
}

impl Reference {
    /// Reads a reference for images of a size, and of a part of the film that begins at `crop`.
    ///
    /// # Errors
    /// If the file is no image, has another size, shows another part of the film, or has pixels that are NaN,
    /// infinite or all black.
    pub fn read(path: &Path, size: (u32, u32), crop: (u32, u32)) -> Result<Self, String> {
        let exr = Exr::read(path).map_err(|error| error.to_string())?;
        let name = path.display();
        let found = (exr.rgb.width() as u32, exr.rgb.height() as u32);
        if found != size {
            return Err(format!(
                "the reference `{name}` has {}x{} pixels, the render {}x{}; give --size {}x{} or render \
                 the reference again",
                found.0, found.1, size.0, size.1, found.0, found.1
            ));
        }
        if let Some(Attribute::Text(text)) = exr.attributes.get("crop")
            && *text != crop_text(crop)
        {
            return Err(format!(
                "the reference `{name}` shows the part of the film that begins at pixel {text}, the render \
                 that at {}; render the reference again with this scene file",
                crop_text(crop)
            ));
        }
        let made_by = match exr.attributes.get("integrator") {
            Some(Attribute::Text(integrator)) => format!("{integrator} (given)"),
            _ => "given".to_owned(),
        };
        let reference =
            Reference { image: exr.rgb, variance: exr.variance, made_by, doubts: vec![] };
        reference.check().map_err(|error| format!("the reference `{name}` {error}"))
    }

    fn check(mut self) -> Result<Self, String> {
        match self.image.non_finite_pixels() {
            0 => {}
            n => return Err(format!("has {n} pixels that are NaN or infinite; render it again")),
        }
        if self.image.pixels().iter().flatten().all(|v| *v == 0.0) {
            return Err("is black".to_owned());
        }
        if self.variance.as_ref().is_some_and(|variance| variance.non_finite_pixels() > 0) {
            self.variance = None;
            self.doubts.push("The variance of the reference is NaN somewhere and not used.".into());
        }
        if self.variance.is_none() {
            let doubt = "The reference does not carry its variance: its own error is not known, and \
                         counts as error of what is measured.";
            self.doubts.push(doubt.to_owned());
        }
        Ok(self)
    }

    /// The union of renders by several integrators, each with its variance: their mean with weights
    /// 1 / variance. A weight is one number for the whole image, so that a pixel which has missed what is rare, and
    /// seems to be certain, does not get the more weight for it.
    ///
    /// # Errors
    /// If the images differ in size or there is none.
    pub fn union(parts: &[(String, RgbImage, RgbImage)]) -> Result<Self, ImageError> {
        let (_, first, _) = parts.first().ok_or(ImageError::Empty)?;
        for (_, image, variance) in parts {
            image.check_same_size(first)?;
            variance.check_same_size(first)?;
        }
        let noise = |variance: &RgbImage| relative(variance, first).max(1e-30);
        let weights: Vec<f64> =
            parts.iter().map(|(_, _, variance)| 1.0 / noise(variance)).collect();
        let total: f64 = weights.iter().sum();
        let mean = |of: fn(&(String, RgbImage, RgbImage)) -> &RgbImage, power: i32| {
            RgbImage::from_fn(first.width(), first.height(), |x, y| {
                [0, 1, 2].map(|c| {
                    let pairs = parts.iter().zip(&weights);
                    pairs
                        .map(|(part, w)| {
                            f64::from(of(part).pixel(x, y)[c]) * (w / total).powi(power)
                        })
                        .sum::<f64>() as f32
                })
            })
        };
        let share = |((name, ..), weight): (&(String, _, _), &f64)| {
            format!("{name} ({:.0} %)", 100.0 * weight / total)
        };
        let names: Vec<String> = parts.iter().zip(&weights).map(share).collect();
        let mut reference = Reference {
            image: mean(|part| &part.1, 1),
            variance: Some(mean(|part| &part.2, 2)),
            made_by: names.join(" + "),
            doubts: Vec::new(),
        };
        for (k, a) in parts.iter().enumerate() {
            for b in &parts[k + 1..] {
                let test = block_z_test(&a.1, &a.2, &b.1, &b.2, &BlockTestOptions::default())?;
                if !test.passed() {
                    reference.doubts.push(format!(
                        "The parts of the reference disagree: {} and {} differ in {} of {} blocks (|z| up \
                         to {:.1}): one is biased, or has missed what is rare.",
                        a.0,
                        b.0,
                        test.failing_blocks,
                        test.blocks,
                        test.max_z()
                    ));
                }
            }
        }
        Ok(reference)
    }

    /// The expected relMSE of the reference itself, if its variance is known: below this, the error of nothing else
    /// can be seen.
    pub fn floor(&self) -> Option<f64> {
        self.variance.as_ref().map(|variance| relative(variance, &self.image))
    }
}

/// How a file says which part of the film it shows.
pub fn crop_text(crop: (u32, u32)) -> String {
    format!("{},{}", crop.0, crop.1)
}

/// The mean over pixels and channels of a variance over squared image plus 0.01.
fn relative(variance: &RgbImage, image: &RgbImage) -> f64 {
    let pairs = variance.pixels().iter().flatten().zip(image.pixels().iter().flatten());
    let sum: f64 =
        pairs.map(|(v, r)| f64::from(*v) / (f64::from(*r) * f64::from(*r) + RELATIVE_OFFSET)).sum();
    sum / (3 * image.pixels().len()) as f64
}
