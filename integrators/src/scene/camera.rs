//! The cameras of Mitsuba's `perspective`, `thinlens` and `orthographic` sensors.

use glam::{DMat4, DVec3, Vec2, Vec3, vec2};

/// How a camera projects.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Projection {
    /// Through a pinhole: Mitsuba's `perspective`.
    Pinhole,
    /// Through a lens in the plane of the pinhole: `thinlens`.
    ThinLens {
        /// The radius of the lens, positive.
        aperture_radius: f32,
        /// The distance of the plane that is in focus, along the axis, positive.
        focus_distance: f32,
    },
    /// Along parallel lines, from a film in the plane through the origin: `orthographic`.
    Orthographic {
        /// One pixel to the right, in the world.
        across: Vec3,
        /// One pixel down, in the world.
        down: Vec3,
    },
}

impl Projection {
    /// The plugin type.
    pub fn name(self) -> &'static str {
        match self {
            Self::Pinhole => "perspective",
            Self::ThinLens { .. } => "thinlens",
            Self::Orthographic { .. } => "orthographic",
        }
    }
}

/// A camera. The image is a window of the film, normally all of it.
///
/// With image coordinates `(x, y)` in pixels, y downwards, and `s = (x + crop.x) / width + principal.x`,
/// `t = (y + crop.y) / height + principal.y`, the direction seen through a pinhole is
///
/// ```text
/// normalize(forward + (2s - 1) tan_x right + (1 - 2t) tan_y up)
/// ```
///
/// In Mitsuba's camera space x points to the *left* of the image, y upwards and z into the scene:
/// `right` is the image of `-x`. If `to_world` is a mirror image, so is the picture.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Camera {
    /// The pinhole, the centre of the lens, or the centre of a film that projects along parallel lines.
    pub origin: Vec3,
    /// Unit vector to the right of the image.
    pub right: Vec3,
    /// Unit vector to the top of the image.
    pub up: Vec3,
    /// Unit vector into the scene.
    pub forward: Vec3,
    /// Tangent of half the horizontal field of view.
    pub tan_x: f32,
    /// Tangent of half the vertical field of view: `tan_x · height / width`.
    pub tan_y: f32,
    /// Pixels per row of the whole film.
    pub width: u32,
    /// Rows of the whole film.
    pub height: u32,
    /// Offset of the image centre as a fraction of width and height, normally 0.
    pub principal: Vec2,
    /// The corner of the image on the film, in pixels, normally 0.
    pub crop: Vec2,
    /// How it projects.
    pub projection: Projection,
}

impl Camera {
    /// The unit direction in which the image point `(x, y)`, in pixels, looks from the origin.
    pub fn direction(&self, film: Vec2) -> Vec3 {
        let size = vec2(self.width as f32, self.height as f32);
        if let Projection::Orthographic { .. } = self.projection {
            return self.forward;
        }
        let centered = 2.0 * ((film + self.crop) / size + self.principal) - 1.0;
        (self.forward + centered.x * self.tan_x * self.right - centered.y * self.tan_y * self.up)
            .normalize()
    }
}

impl Camera {
    /// A bound of the coordinates at which rays start.
    pub fn reach(&self) -> f32 {
        let around = match self.projection {
            Projection::Pinhole => 0.0,
            Projection::ThinLens { aperture_radius, .. } => aperture_radius,
            // Filters reach over the border.
            Projection::Orthographic { across, down } => {
                self.width as f32 * across.length() + self.height as f32 * down.length()
            }
        };
        self.origin.abs().max_element() + around
    }
}

/// The least field of view along x, in degrees.
const LEAST_FOV: f64 = 1e-12;

/// The horizontal field of view in degrees, from one along `axis`, as Mitsuba's `parse_fov` does.
pub fn horizontal_fov(fov: f64, axis: &str, aspect: f64) -> Result<f64, String> {
    let half = (0.5 * fov).to_radians().tan();
    let tangent = match axis.to_ascii_lowercase().as_str() {
        "x" => half,
        "y" => half * aspect,
        "smaller" if aspect > 1.0 => half * aspect,
        "smaller" => half,
        "larger" if aspect > 1.0 => half,
        "larger" => half * aspect,
        "diagonal" => half / (1.0 + 1.0 / (aspect * aspect)).sqrt(),
        other => {
            return Err(format!(
                "\"{other}\" is no axis; supported: x, y, diagonal, smaller, larger"
            ));
        }
    };
    let result = 2.0 * tangent.atan().to_degrees();
    if !(fov > 0.0 && fov < 180.0 && result > 0.0 && result < 180.0) {
        return Err("the field of view must be between 0 and 180 degrees".to_owned());
    }
    if result < LEAST_FOV {
        return Err(format!(
            "the field of view must be at least {LEAST_FOV:e} degrees: squares of smaller ones are no numbers of single precision"
        ));
    }
    Ok(result)
}

/// The field of view along the diagonal, in degrees, of a 35 mm camera (36 mm x 24 mm) with a
/// focal length such as `50mm`.
pub fn diagonal_fov(focal_length: &str) -> Result<f64, String> {
    let text = focal_length.trim();
    let value = super::values::number(text.strip_suffix("mm").unwrap_or(text))?;
    if value <= 0.0 {
        return Err("the focal length must be positive".to_owned());
    }
    let diagonal = f64::hypot(36.0, 24.0);
    Ok(2.0 * (diagonal / (2.0 * value)).atan().to_degrees())
}

/// The columns `x, y, z` of a camera's placement made exactly orthonormal, or a complaint if they
/// are not so within 1e-3, as in Mitsuba.
pub fn orthonormal_axes(to_world: &DMat4) -> Result<[DVec3; 3], String> {
    let [x, y, z] = [to_world.x_axis, to_world.y_axis, to_world.z_axis].map(|c| c.truncate());
    let products = [x.dot(x) - 1., y.dot(y) - 1., z.dot(z) - 1., x.dot(y), y.dot(z), z.dot(x)];
    if !products.iter().all(|p| p.abs() <= 1e-3) {
        return Err("a camera's to_world may not scale or shear".to_owned());
    }
    let z = z.normalize();
    let y = (y - z * z.dot(y)).normalize();
    let side = y.cross(z);
    Ok([side * side.dot(x).signum(), y, z])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn fields_of_view() {
        // `mi.load_dict({'type': 'perspective', …}).x_fov` for the default film of 768 x 576.
        let aspect = 768.0 / 576.0;
        let fov = horizontal_fov(diagonal_fov("50mm").unwrap(), "diagonal", aspect).unwrap();
        assert!((fov - 38.1848).abs() < 1e-4);
        assert_eq!(horizontal_fov(40.0, "x", aspect).map(f64::round), Ok(40.0));
        let y = horizontal_fov(40.0, "y", aspect).unwrap();
        assert!((y - 51.774).abs() < 1e-3);
        assert_eq!(horizontal_fov(40.0, "smaller", aspect), Ok(y));
        assert_eq!(horizontal_fov(40.0, "larger", 1.0 / aspect), horizontal_fov(40.0, "y", 0.75));
        assert!(horizontal_fov(180.0, "x", 1.0).is_err());
        assert!(horizontal_fov(-1.0, "x", 1.0).is_err());
        assert!(horizontal_fov(30.0, "z", 1.0).is_err());
        assert!(diagonal_fov("0mm").is_err());
    }

    #[test]
    fn axes() {
        let mirror = DMat4::from_scale(DVec3::new(-1.0, 1.0, 1.0));
        assert_eq!(orthonormal_axes(&mirror), Ok([-DVec3::X, DVec3::Y, DVec3::Z]));
        assert!(orthonormal_axes(&DMat4::from_scale(DVec3::splat(1.01))).is_err());
    }
}
