//! Numbers, colours and transforms as attribute values write them.
//!
//! Every function returns the complaint as text; the caller knows the place.

use glam::{DMat4, DVec3};

use crate::image::srgb_decode;

/// The separators of a list: commas and blanks.
fn tokens(text: &str) -> impl Iterator<Item = &str> {
    text.split(|c: char| c == ',' || c.is_whitespace()).filter(|token| !token.is_empty())
}

/// A text between quotation marks, cut if it is long.
fn quoted(text: &str) -> String {
    match text.char_indices().nth(40) {
        Some((end, _)) => format!("\"{}…\"", &text[..end]),
        None => format!("\"{text}\""),
    }
}

/// A finite number.
pub fn number(text: &str) -> Result<f64, String> {
    match text.trim().parse::<f64>() {
        Ok(x) if x.is_finite() => Ok(x),
        Ok(_) => Err(format!("{} is not a finite number", quoted(text))),
        Err(_) => Err(format!("{} is not a number", quoted(text))),
    }
}

/// At most 16 finite numbers, separated by commas or blanks.
pub fn numbers(text: &str) -> Result<Vec<f64>, String> {
    let list: Vec<&str> = tokens(text).take(17).collect();
    if list.len() > 16 {
        return Err("more than 16 numbers".to_owned());
    }
    list.into_iter().map(number).collect()
}

/// An integer.
pub fn integer(text: &str) -> Result<i64, String> {
    text.trim().parse().map_err(|_| format!("{} is not an integer", quoted(text)))
}

/// `true` or `false`, in either case.
pub fn boolean(text: &str) -> Result<bool, String> {
    match text.trim().to_ascii_lowercase().as_str() {
        "true" => Ok(true),
        "false" => Ok(false),
        _ => Err(format!("{} is neither true nor false", quoted(text))),
    }
}

/// One number for all axes, or three.
pub fn vector(text: &str) -> Result<DVec3, String> {
    match numbers(text)?[..] {
        [x] => Ok(DVec3::splat(x)),
        [x, y, z] => Ok(DVec3::new(x, y, z)),
        ref other => Err(format!("one or three numbers are needed, found {}", other.len())),
    }
}

/// A linear Rec. 709 colour: one or three numbers, or `#rrggbb` in sRGB.
pub fn rgb(text: &str) -> Result<DVec3, String> {
    let Some(hex) = text.trim().strip_prefix('#') else {
        return vector(text);
    };
    let digits = (hex.len() == 6 && hex.bytes().all(|b| b.is_ascii_hexdigit()))
        .then(|| u32::from_str_radix(hex, 16).ok())
        .flatten()
        .ok_or_else(|| format!("{} is not of the form #rrggbb", quoted(text)))?;
    let channel = |shift: u32| srgb_decode(f64::from((digits >> shift) & 0xff) / 255.0);
    Ok(DVec3::new(channel(16), channel(8), channel(0)))
}

/// A colour in sRGB: `#rrggbb`, or one or three numbers.
pub fn srgb(text: &str) -> Result<DVec3, String> {
    if text.trim().starts_with('#') { rgb(text) } else { vector(text).map(|c| c.map(srgb_decode)) }
}

/// A matrix of 16 numbers, or 9 for its linear part, row by row.
pub fn matrix(text: &str) -> Result<DMat4, String> {
    let m = numbers(text)?;
    let n = match m.len() {
        16 => 4,
        9 => 3,
        other => return Err(format!("9 or 16 numbers are needed, found {other}")),
    };
    let mut columns = DMat4::IDENTITY.to_cols_array_2d();
    for row in 0..n {
        for column in 0..n {
            columns[column][row] = m[row * n + column];
        }
    }
    if columns.map(|c| c[3]) != [0.0, 0.0, 0.0, 1.0] {
        return Err("the last row must be 0 0 0 1".to_owned());
    }
    Ok(DMat4::from_cols_array_2d(&columns))
}

/// A rotation by an angle in degrees. The axis may have any length but zero.
///
/// (Mitsuba 3.9 scales the scene when the axis is not of unit length; here it never does.)
pub fn rotate(axis: DVec3, degrees: f64) -> Result<DMat4, String> {
    let axis = axis.try_normalize().ok_or("the axis must not be zero")?;
    Ok(DMat4::from_axis_angle(axis, degrees.to_radians()))
}

/// A camera's placement: z towards the target, x to the left, y upwards.
pub fn look_at(origin: DVec3, target: DVec3, up: DVec3) -> Result<DMat4, String> {
    let forward = (target - origin).try_normalize().ok_or("origin and target must differ")?;
    let left =
        up.cross(forward).try_normalize().ok_or("up must not be parallel to the view direction")?;
    let up = forward.cross(left);
    Ok(DMat4::from_cols(left.extend(0.0), up.extend(0.0), forward.extend(0.0), origin.extend(1.0)))
}

/// The determinant of the linear part relative to the lengths of its columns: 1 if they are
/// orthogonal, 0 if the transform flattens space.
pub fn relative_determinant(m: &DMat4) -> f64 {
    let lengths = [m.x_axis, m.y_axis, m.z_axis].map(|c| c.truncate().length());
    if lengths.iter().any(|l| !(*l > 0.0 && l.is_finite())) {
        return 0.0;
    }
    let [x, y, z] = [m.x_axis, m.y_axis, m.z_axis].map(|c| c.truncate().normalize());
    x.cross(y).dot(z)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn colours() {
        assert_eq!(rgb("0.5"), Ok(DVec3::splat(0.5)));
        assert_eq!(rgb("0.5, .25 1e-1"), Ok(DVec3::new(0.5, 0.25, 0.1)));
        let c = rgb("#ff8000").unwrap();
        assert_eq!(c.x, 1.0);
        assert!((c.y - 0.215_860_500_113_899_26).abs() < 1e-15);
        assert_eq!(c.z, 0.0);
        for bad in ["", "1 2", "#ff80", "#gg0000", "nan", "1 2 inf", "1 2 3 4", "#é000"] {
            assert!(rgb(bad).is_err(), "{bad}");
        }
    }

    #[test]
    fn matrices_are_read_by_rows() {
        let m = matrix("1 2 3 4  5 6 7 8  9 10 11 12  0 0 0 1").unwrap();
        assert_eq!(m.transform_point3(DVec3::ZERO), DVec3::new(4.0, 8.0, 12.0));
        let m = matrix("1 2 3 5 6 7 9 10 11").unwrap();
        assert_eq!(m.transform_vector3(DVec3::X), DVec3::new(1.0, 5.0, 9.0));
        assert!(matrix("1 0 0 0 0 1 0 0 0 0 1 0 0 0 1 1").is_err());
        assert!(matrix("1 2 3").is_err());
    }

    #[test]
    fn look_at_has_x_to_the_left() {
        let m = look_at(DVec3::new(0.0, 0.0, 5.0), DVec3::ZERO, DVec3::Y).unwrap();
        assert_eq!(m.x_axis.truncate(), -DVec3::X);
        assert_eq!(m.y_axis.truncate(), DVec3::Y);
        assert_eq!(m.z_axis.truncate(), -DVec3::Z);
        assert!(look_at(DVec3::X, DVec3::X, DVec3::Y).is_err());
        assert!(look_at(DVec3::ZERO, DVec3::Y, DVec3::Y).is_err());
    }

    #[test]
    fn rotations_follow_the_right_hand() {
        let m = rotate(DVec3::new(0.0, 0.0, 2.0), 90.0).unwrap();
        assert!((m.transform_vector3(DVec3::X) - DVec3::Y).length() < 1e-15);
        assert!(rotate(DVec3::ZERO, 90.0).is_err());
    }
}
