//! What each technique of an integrator contributes, as images of their own.

use std::collections::BTreeMap;

use super::{Layer, Technique};
use crate::image::RgbImage;

/// The images beside an image, each with the variance of its pixels.
pub type Layers = BTreeMap<Layer, [RgbImage; 2]>;

/// What techniques contribute, on one sheet: a row for the paths of each length, first with weights, then alone;
/// in a row the techniques by the number of vertices that come from the light. Longer paths carry less light:
/// each row is 1.5 times as bright as it is for each vertex beyond the second. `None` if no technique has a layer.
pub fn contact_sheet(layers: &Layers) -> Option<RgbImage> {
    let mut rows: BTreeMap<_, Vec<(Technique, &RgbImage)>> = BTreeMap::new();
    for (layer, [image, _]) in layers {
        if let Layer::Technique { weighted, technique } = *layer {
            rows.entry((!weighted, technique.vertices)).or_default().push((technique, image));
        }
    }
    let (_, first) = *rows.values().next()?.first()?;
    let (width, height) = (first.width(), first.height());
    let columns = rows.values().map(Vec::len).max()?;
    let mut sheet = RgbImage::filled(columns * (width + 1), rows.len() * (height + 1), [0.02; 3]);
    for (y, row) in rows.values_mut().enumerate() {
        row.sort_by_key(|(technique, _)| (technique.joint, technique.light));
        for (x, (technique, image)) in row.iter().enumerate() {
            let factor = 1.5f32.powi(technique.vertices as i32 - 2);
            for (from, pixel) in image.pixels().iter().enumerate() {
                let (column, line) = (from % width, from / width);
                let at = (y * (height + 1) + line) * sheet.width() + x * (width + 1) + column;
                sheet.pixels_mut()[at] = pixel.map(|v| v * factor);
            }
        }
    }
    Some(sheet)
}
