//! The image and the images beside it, of what samples have added up to.

use std::collections::BTreeMap;
use std::sync::Mutex;

use super::tile::Tile;
use super::{Job, lock};
use crate::image::RgbImage;
use crate::render::Layers;
use crate::render::film::Film;

impl Job<'_> {
    /// The mean number of samples of a pixel. Light paths do not depend on the pixel that they were sampled
    /// with: in a pass that was cut short, what counts is how many there were.
    fn samples(&self) -> f64 {
        let of = |tile: &Mutex<Tile<'_>>| {
            lock(tile).pixels.iter().map(|p| u64::from(p.count())).sum::<u64>()
        };
        let pixels = f64::from(self.size.0) * f64::from(self.size.1);
        self.tiles.iter().map(of).sum::<u64>() as f64 / pixels
    }

    /// The images beside the image.
    pub(super) fn layers(&self) -> Layers {
        let Some(sums) = &self.splats else { return BTreeMap::new() };
        let (width, height) = (self.size.0 as usize, self.size.1 as usize);
        let image = |pixels: &[[[f64; 3]; 2]], part: usize| {
            RgbImage::from_fn(width, height, |x, y| pixels[y * width + x][part].map(single))
        };
        let layers = lock(sums).layers(self.samples());
        let images = |pixels: Vec<_>| [image(&pixels, 0), image(&pixels, 1)];
        layers.into_iter().map(|(layer, pixels)| (layer, images(pixels))).collect()
    }

    /// The image so far.
    pub(super) fn film(&self) -> Film {
        let mut film = Film::new(self.size);
        for tile in &self.tiles {
            let tile = lock(tile);
            for ((x, y), pixel) in tile.positions().zip(&tile.pixels) {
                *film.pixel_mut(x, y) = *pixel;
            }
        }
        let Some(sums) = &self.splats else { return film };
        let (samples, sums) = (self.samples(), lock(sums));
        let mut own = Vec::new();
        if let Some(filter) = self.filter {
            (film, own) = film.shared(filter);
            film.limit_variance(|pixel| sums.shared_at_most(pixel, own[pixel]));
        }
        film.set_splats(|pixel| {
            let [mut mean, variance] = sums.estimate(pixel, samples);
            let shared = own.get(pixel).map_or([0.0; 3], |samples| sums.shared(pixel, *samples));
            mean.iter_mut().zip(shared).for_each(|(mean, shared)| *mean += shared);
            [mean, variance]
        });
        film
    }
}

/// A number in single precision, where what is beyond its range is its end.
fn single(v: f64) -> f32 {
    v.min(f64::from(f32::MAX)) as f32
}
