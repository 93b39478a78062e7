//! Sampling the directions of an environment map.

use aether_core::Then;
use aether_core::prelude::*;
use aether_core::tables::{BilinearDirections, PiecewiseLinear2D};

use crate::samplers::{Rotate, rotate};
use crate::scene::envmap::{EnvironmentMap, row_weight};

/// The largest table, in cells each way: pictures that are larger have a coarser one.
const LARGEST: usize = 2048;

/// The density of directions that follows the luminance of an environment map: bilinear between the same
/// nodes as its radiance, so that what remains to be weighted is nearly the colour alone.
#[derive(Clone, Debug)]
pub struct EnvironmentTable {
    table: PiecewiseLinear2D<f32>,
    frame: Frame<f32>,
}

impl EnvironmentTable {
    /// The table of a picture; `None` if it is black.
    pub fn new(map: &EnvironmentMap) -> Option<Self> {
        let (width, height) = map.size();
        let (columns, rows) = (width.min(LARGEST), (height - 1).min(LARGEST));
        let mut values = Vec::with_capacity((columns + 1) * (rows + 1));
        for row in 0..=rows {
            let near = neighbours(row, rows, height - 1);
            let weight = row_weight(row as f64 * (height - 1) as f64 / rows as f64, height);
            for column in 0..=columns {
                let (mut sum, mut count) = (0.0, 0.0);
                for y in near.clone().filter(|y| (0..height as i64).contains(y)) {
                    for x in neighbours(column, columns, width) {
                        sum += map.luminance(x.rem_euclid(width as i64) as usize, y as usize);
                        count += 1.0;
                    }
                }
                values.push((weight * sum / count) as f32);
            }
        }
        let table = PiecewiseLinear2D::new(&values, columns + 1).ok()?;
        let [x, y, z] = map.axes();
        let frame = Frame::try_from_axes(x.into(), y.into(), z.into())?;
        Some(EnvironmentTable { table, frame })
    }

    /// The table, on the unit square, of directions before they are turned.
    pub fn table(&self) -> &PiecewiseLinear2D<f32> {
        &self.table
    }

    /// The random variable.
    pub fn directions(&self) -> Then<BilinearDirections<'_, f32>, Rotate<f32>> {
        self.table.directions().then(rotate(self.frame))
    }
}

/// The nodes of the picture that a node of the table stands for: itself where the table is as fine, otherwise
/// all up to the next node of the table on both sides, so that there is a density wherever there is light.
fn neighbours(node: usize, cells: usize, fine: usize) -> std::ops::RangeInclusive<i64> {
    let at = |node: i64| node as f64 * fine as f64 / cells as f64;
    if cells == fine {
        return node as i64..=node as i64;
    }
    at(node as i64 - 1).ceil() as i64..=at(node as i64 + 1).floor() as i64
}

#[cfg(test)]
mod tests {
    use aether_core::battery::Battery;
    use glam::{DMat4, DVec3};

    use super::*;
    use crate::image::RgbImage;

    fn map(columns: usize, rows: usize) -> EnvironmentMap {
        let texel = |x: usize, y: usize| match (x, y) {
            (2, 1) => [40.0, 30.0, 20.0],
            (_, 0) => [0.0; 3],
            _ => [0.1 + ((3 * x + 5 * y) % 7) as f32, 1.0, 0.0],
        };
        let turn = DMat4::from_rotation_x(0.4) * DMat4::from_scale(DVec3::new(1.0, 1.0, -1.0));
        EnvironmentMap::new(RgbImage::from_fn(columns, rows, texel), 1.0, &turn).unwrap()
    }

    #[test]
    fn directions_pass_the_battery() {
        let table = EnvironmentTable::new(&map(6, 4)).unwrap();
        Battery::new(&table.directions()).run().assert_ok();
    }

    #[test]
    fn the_density_follows_the_radiance() {
        let map = map(32, 17);
        let table = EnvironmentTable::new(&map).unwrap();
        let directions = table.directions();
        let [x, y, z] = map.axes();
        let luminance = |w| map.radiance(w).dot(glam::Vec3::new(0.212_671, 0.715_16, 0.072_169));
        // Within five percent wherever the sine is nearly linear over a row.
        let mut ratios = Vec::new();
        for k in 0..200 {
            let (polar, turn) = (0.6 + 0.0095 * k as f32, 0.37 * k as f32);
            let w = polar.sin() * (turn.cos() * x + turn.sin() * y) + polar.cos() * z;
            ratios.push(directions.pdf(&Direction::from_unit(w.into())).value() / luminance(w));
        }
        let mean = ratios.iter().sum::<f32>() / 200.0;
        let furthest = ratios.iter().map(|r| (r / mean - 1.0).abs()).fold(0.0, f32::max);
        assert!(furthest < 0.05, "{furthest}");
    }

    #[test]
    fn a_coarse_table_covers_all_light() {
        // A single bright texel of a picture that is finer than any table.
        let sun = |x, y| if (x, y) == (1001, 1) { [1.0; 3] } else { [0.0; 3] };
        let image = RgbImage::from_fn(LARGEST + 700, 4, sun);
        let map = EnvironmentMap::new(image, 1.0, &DMat4::IDENTITY).unwrap();
        let table = EnvironmentTable::new(&map).unwrap();
        let [x, y, z] = map.axes();
        let (mut lit, steps) = (0, 4000);
        for k in 0..steps {
            let turn = std::f32::consts::TAU * (1000.0 + 2.0 * k as f32 / steps as f32)
                / (LARGEST + 700) as f32;
            let w = 1.2f32.sin() * (turn.cos() * x + turn.sin() * y) + 1.2f32.cos() * z;
            if map.radiance(w) != glam::Vec3::ZERO {
                lit += 1;
                let density = table.directions().pdf(&Direction::from_unit(w.into()));
                assert!(density.value() > 0.0, "{turn}");
            }
        }
        assert!(lit > steps / 2);
        assert!(
            EnvironmentTable::new(
                &EnvironmentMap::new(RgbImage::filled(4, 4, [0.0; 3]), 1.0, &DMat4::IDENTITY)
                    .unwrap()
            )
            .is_none()
        );
    }
}
