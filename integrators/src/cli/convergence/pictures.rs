//! What reports show.

use super::{Failure, Images, Run};
use crate::convergence::page::reference_curve;
use crate::convergence::picture::{cut, error_picture, mean, telling_crop};
use crate::convergence::reference::Reference;
use crate::convergence::report::Measurements;
use crate::convergence::summary::summarise;
use crate::image::{RgbImage, png};

impl Run<'_> {
    /// Pictures of the reference and of one seed of each curve, and the parts of them for strips.
    pub(super) fn pictures(
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
