//! What is given: a reference, images of other programs, a part of the image.

use std::path::{Path, PathBuf};

use super::{Failure, Run};
use crate::convergence::adapter;
use crate::convergence::picture::Crop;
use crate::convergence::reference::Reference;
use crate::image::RgbImage;
use crate::image::exr::Exr;

/// Images that other programs have written, with what is known of them.
pub(super) type Written = Vec<(adapter::Entry, RgbImage)>;

/// What is given, as far as it is.
pub(super) struct Given {
    pub reference: Option<Reference>,
    pub images: Written,
}

impl Run<'_> {
    /// Reads what is given, all of which has the size of the image.
    pub(super) fn given(&self) -> Result<Given, Failure> {
        let (columns, rows) = self.plan.size;
        let size = (columns as usize, rows as usize);
        if let Some(crop) = self.arguments.crop {
            check_crop(crop, size)?;
        }
        let read = |path: &PathBuf| Reference::read(path, self.plan.size, self.plan.crop);
        let reference = self.arguments.reference.as_ref().map(read).transpose();
        let reference = reference.map_err(Failure::new)?;
        let list = self.arguments.images.as_ref().map(|path| adapter::read_list(path));
        let list = list.transpose().map_err(Failure::new)?.unwrap_or_default();
        let images = read_images(list)?;
        for (entry, image) in &images {
            check_size(&entry.file, image, size)?;
        }
        Ok(Given { reference, images })
    }
}

/// Images that other programs have written, with what is known of them.
pub(super) fn read_images(list: Vec<adapter::Entry>) -> Result<Written, Failure> {
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn parts_lie_in_the_image() {
        let size = (8, 6);
        assert!(check_crop((0, 0, 8, 6), size).is_ok());
        for wrong in [(8, 0, 1, 1), (0, 0, 9, 1), (4, 4, 2, 3), (usize::MAX, 0, 2, 2)] {
            assert!(check_crop(wrong, size).is_err(), "{wrong:?}");
        }
    }
}
