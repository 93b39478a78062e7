//! A picture of all directions, by latitude and longitude. Conventions are Mitsuba's.

use std::f32::consts::{PI, TAU};

use glam::{DMat3, DMat4, DVec3, Vec3};

use crate::image::RgbImage;

/// Light from infinitely far away, its radiance given by a picture.
///
/// The top row is seen in the direction +y of the emitter's own coordinates, the bottom row in -y, both
/// ends of a row in +z, and its middle in -z. Between the centres of texels the radiance is
/// interpolated bilinearly, in a row across its ends; the centres of the first and of the last row lie
/// at the poles.
#[derive(Clone, Debug, PartialEq)]
pub struct EnvironmentMap {
    image: RgbImage,
    scale: f32,
    /// In the world: the directions at the equator in which the first column has its centres, and a
    /// quarter of a turn further in the order of columns; third the pole of the first row.
    axes: [Vec3; 3],
}

impl EnvironmentMap {
    /// The light that a picture shows, times `scale`, turned or mirrored by `to_world`.
    ///
    /// # Errors
    /// Says what is wrong: a transform that distorts, a picture of less than 2 x 3 texels, radiance that
    /// is negative, not finite or beyond 1e18.
    pub fn new(image: RgbImage, scale: f64, to_world: &DMat4) -> Result<Self, String> {
        let (width, height) = (image.width(), image.height());
        if width < 2 || height < 3 {
            return Err(format!("{width} x {height} texels; a sky needs at least 2 x 3"));
        }
        let wrong = |v: f32| !(0.0..=1e18).contains(&(f64::from(v) * scale));
        if let Some(at) = image.pixels().iter().position(|pixel| pixel.iter().any(|v| wrong(*v))) {
            let (x, y) = (at % width, at / width);
            let value = image.pixels()[at];
            return Err(format!(
                "the radiance at column {x}, row {y} is {value:?} times {scale}; it must lie in [0, 1e18]"
            ));
        }
        let turn = turned(to_world).ok_or("a sky can be turned and mirrored, but not distorted")?;
        let first = std::f64::consts::PI / width as f64;
        let (sine, cosine) = first.sin_cos();
        let axes = [DVec3::new(sine, 0.0, -cosine), DVec3::new(cosine, 0.0, sine), DVec3::Y];
        let axes = axes.map(|axis| (turn * axis).normalize().as_vec3());
        Ok(EnvironmentMap { image, scale: scale as f32, axes })
    }

    /// Columns and rows.
    pub fn size(&self) -> (usize, usize) {
        (self.image.width(), self.image.height())
    }

    /// In the world: the direction at the equator of the centres of the first column, the one a quarter of
    /// a turn further in the order of columns, and the pole of the first row. They are orthonormal, and
    /// left-handed if the picture is not mirrored.
    pub fn axes(&self) -> [Vec3; 3] {
        self.axes
    }

    /// The radiance that comes from a direction of unit length, in linear Rec. 709.
    pub fn radiance(&self, w: Vec3) -> Vec3 {
        let (width, height) = self.size();
        let [x, y, z] = self.axes.map(|axis| axis.dot(w));
        let column = (y.atan2(x) / TAU).rem_euclid(1.0) * width as f32;
        let row = x.hypot(y).atan2(z) / PI * (height - 1) as f32;
        let left = (column as usize).min(width - 1);
        let top = (row as usize).min(height - 2);
        let (right, low) = ((left + 1) % width, top + 1);
        let texel = |x, y| Vec3::from(self.image.pixel(x, y));
        let t = column - left as f32;
        let upper = texel(left, top).lerp(texel(right, top), t);
        let lower = texel(left, low).lerp(texel(right, low), t);
        upper.lerp(lower, row - top as f32) * self.scale
    }

    /// The luminance (Rec. 709) of a texel; columns go on from the beginning.
    pub fn luminance(&self, column: usize, row: usize) -> f64 {
        let [r, g, b] = self.image.pixel(column % self.image.width(), row).map(f64::from);
        f64::from(self.scale) * (0.212_671 * r + 0.715_16 * g + 0.072_169 * b)
    }

    /// The mean radiance over all directions, but for the interpolation between rows.
    pub fn mean(&self) -> Vec3 {
        let (width, height) = self.size();
        let (mut sum, mut total) = (DVec3::ZERO, 0.0);
        for row in 0..height {
            let weight = row_weight(row as f64, height);
            for column in 0..width {
                sum += weight * Vec3::from(self.image.pixel(column, row)).as_dvec3();
            }
            total += weight * width as f64;
        }
        (sum / total * f64::from(self.scale)).as_vec3()
    }
}

/// How much a node of a row counts: the sine of its polar angle. At the poles, where it vanishes and
/// light does not, that of a third of the distance to the next row: then the mass of a cell whose only
/// light is at the pole is right.
pub fn row_weight(row: f64, height: usize) -> f64 {
    let last = (height - 1) as f64;
    (row.clamp(1.0 / 3.0, last - 1.0 / 3.0) / last * std::f64::consts::PI).sin()
}

/// The rotation or reflection that a transform is up to its scale; `None` if it is neither.
fn turned(m: &DMat4) -> Option<DMat3> {
    let columns = [m.x_axis, m.y_axis, m.z_axis].map(|column| column.truncate());
    let lengths = columns.map(DVec3::length);
    let even = |l: f64| l > 0.0 && l.is_finite() && (l / lengths[0] - 1.0).abs() < 1e-3;
    let [x, y, z] = columns.map(DVec3::normalize_or_zero);
    let square = [x.dot(y), y.dot(z), z.dot(x)].iter().all(|dot| dot.abs() < 1e-3);
    if !(lengths.into_iter().all(even) && square) {
        return None;
    }
    // Exactly orthonormal.
    let y = (y - y.dot(x) * x).normalize();
    let handed = x.cross(y).dot(z).signum();
    Some(DMat3::from_cols(x, y, handed * x.cross(y)))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn map(to_world: &DMat4) -> EnvironmentMap {
        let image = RgbImage::from_fn(8, 5, |x, y| [x as f32, y as f32, 1.0]);
        EnvironmentMap::new(image, 2.0, to_world).unwrap()
    }

    /// The direction of a texel in the emitter's coordinates.
    fn towards(column: f64, row: f64) -> Vec3 {
        let (phi, theta) =
            ((column + 0.5) / 8.0 * std::f64::consts::TAU, row / 4.0 * std::f64::consts::PI);
        DVec3::new(phi.sin() * theta.sin(), theta.cos(), -phi.cos() * theta.sin()).as_vec3()
    }

    #[test]
    fn texels_are_where_they_should_be() {
        let plain = map(&DMat4::IDENTITY);
        for (column, row) in [(0.0, 1.0), (3.0, 2.0), (5.5, 2.5), (6.25, 1.0)] {
            let expected = 2.0 * Vec3::new(column as f32, row as f32, 1.0);
            let found = plain.radiance(towards(column, row));
            assert!((found - expected).abs().max_element() < 1e-4, "{found} {expected}");
        }
        // Across the ends of a row, and at the poles.
        let seam = plain.radiance(towards(7.5, 2.0));
        assert!((seam - Vec3::new(7.0, 4.0, 2.0)).abs().max_element() < 1e-4, "{seam}");
        assert_eq!(plain.radiance(Vec3::Y).y, 0.0);
        assert!((plain.radiance(Vec3::NEG_Y).y - 8.0).abs() < 1e-5);
        let turn = DMat4::from_rotation_y(0.7) * DMat4::from_scale(DVec3::new(-3.0, 3.0, 3.0));
        let turned = map(&turn);
        for (column, row) in [(0.0, 1.0), (3.25, 2.75)] {
            let w = turn.as_mat4().transform_vector3(towards(column, row)).normalize();
            let expected = plain.radiance(towards(column, row));
            assert!((turned.radiance(w) - expected).abs().max_element() < 1e-4);
        }
    }

    #[test]
    fn what_is_no_sky_is_refused() {
        let image = |v| RgbImage::filled(2, 3, [v; 3]);
        let squeezed = DMat4::from_scale(DVec3::new(1.0, 2.0, 1.0));
        assert!(EnvironmentMap::new(image(1.0), 1.0, &squeezed).is_err());
        assert!(EnvironmentMap::new(image(-1.0), 1.0, &DMat4::IDENTITY).is_err());
        assert!(EnvironmentMap::new(image(f32::NAN), 1.0, &DMat4::IDENTITY).is_err());
        assert!(
            EnvironmentMap::new(RgbImage::filled(2, 2, [1.0; 3]), 1.0, &DMat4::IDENTITY).is_err()
        );
        let one = EnvironmentMap::new(image(1.0), 0.5, &DMat4::IDENTITY).unwrap();
        assert!((one.mean() - 0.5).abs().max_element() < 1e-6);
    }
}
