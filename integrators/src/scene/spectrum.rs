//! From spectra in scene files to linear Rec. 709, as Mitsuba does in its RGB variants.

use glam::{DMat3, DVec3};

/// Wavelength, CIE 1931 colour matching functions, illuminant D65 (`tests/reference/make_cie.py` writes
/// the table).
const TABLE: &str = include_str!("cie.txt");

/// The linear Rec. 709 colour of a constant emission spectrum of 1 (illuminant E). From Mitsuba 3.9.1.
const ILLUMINANT_E: DVec3 = DVec3::new(1.204_793_9, 0.948_291, 0.908_916_06);

/// From CIE XYZ to linear Rec. 709.
const XYZ_TO_RGB: DMat3 = DMat3::from_cols(
    DVec3::new(3.240_479, -0.969_256, 0.055_648),
    DVec3::new(-1.537_150, 1.875_991, -0.204_043),
    DVec3::new(-0.498_535, 0.041_556, 1.057_311),
);

/// What a colour is for: the same spectrum makes another colour as light than as a surface.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Purpose {
    /// A surface, seen in daylight: a constant spectrum is grey.
    Reflectance,
    /// Light.
    Emission,
}

/// A spectrum: a constant, or values at wavelengths in nanometres with straight lines between and nothing
/// beyond.
#[derive(Clone, Debug, PartialEq)]
pub enum Spectrum {
    /// The same for all wavelengths.
    Constant(f64),
    /// Wavelengths and values.
    Table(Vec<(f64, f64)>),
}

impl Spectrum {
    /// Reads `0.5` or `400:0.2, 500:0.3, …`.
    pub fn parse(text: &str) -> Result<Self, String> {
        if !text.contains(':') {
            return super::values::number(text).map(Spectrum::Constant);
        }
        let mut table: Vec<(f64, f64)> = Vec::new();
        for entry in text.split([',', ' ', '\t', '\n']).filter(|entry| !entry.is_empty()) {
            let Some((wavelength, value)) = entry.split_once(':') else {
                return Err(format!("\"{entry}\" is not of the form wavelength:value"));
            };
            let (wavelength, value) =
                (super::values::number(wavelength)?, super::values::number(value)?);
            if table.last().is_some_and(|(before, _)| wavelength <= *before) {
                return Err("the wavelengths of a spectrum must increase".to_owned());
            }
            table.push((wavelength, value));
        }
        Ok(Spectrum::Table(table))
    }

    /// The colour, never negative for a table.
    pub fn colour(&self, purpose: Purpose) -> DVec3 {
        match (self, purpose) {
            (Spectrum::Constant(value), Purpose::Reflectance) => DVec3::splat(*value),
            (Spectrum::Constant(value), Purpose::Emission) => *value * ILLUMINANT_E,
            (Spectrum::Table(table), _) => integrate(table, purpose).max(DVec3::ZERO),
        }
    }
}

/// The integral over all wavelengths, by steps of one nanometre.
fn integrate(table: &[(f64, f64)], purpose: Purpose) -> DVec3 {
    let rows: Vec<Vec<f64>> = TABLE
        .lines()
        .map(|line| line.split(' ').filter_map(|word| word.parse().ok()).collect())
        .collect();
    let (mut sum, mut white) = (DVec3::ZERO, 0.0);
    for pair in rows.windows(2) {
        let [Some(low), Some(high)] = [&pair[0], &pair[1]].map(|row| row.get(..5)) else {
            continue;
        };
        for step in 0..5 {
            let t = (f64::from(step) + 0.5) / 5.0;
            let at = |k: usize| low[k] + t * (high[k] - low[k]);
            let light = if purpose == Purpose::Reflectance { at(4) } else { 1.0 };
            sum += DVec3::new(at(1), at(2), at(3)) * light * value_at(table, at(0));
            white += at(2) * light;
        }
    }
    XYZ_TO_RGB * sum / white
}

fn value_at(table: &[(f64, f64)], wavelength: f64) -> f64 {
    let above = table.partition_point(|(w, _)| *w <= wavelength);
    if above == 0 || above == table.len() {
        return 0.0;
    }
    let ((w0, v0), (w1, v1)) = (table[above - 1], table[above]);
    v0 + (wavelength - w0) / (w1 - w0) * (v1 - v0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn colours_are_mitsubas() {
        // `mi.load_string` of a diffuse bsdf and of a constant emitter in Mitsuba 3.9.1, scalar_rgb.
        for (text, purpose, expected) in [
            ("400:0, 500:8, 600:15.6, 700:18.4", Purpose::Emission, [20.7108, 10.8546, 2.77115]),
            (
                "400:0.78, 500:0.78, 600:0.78, 700:0.78",
                Purpose::Reflectance,
                [0.776367, 0.77981, 0.776029],
            ),
            (
                "400:0.343,500:0.7,600:0.2,700:0.9",
                Purpose::Reflectance,
                [0.215478, 0.499073, 0.545467],
            ),
            (
                "400:0.343,500:0.7,600:0.2,700:0.9",
                Purpose::Emission,
                [0.301659, 0.467864, 0.491979],
            ),
            ("1", Purpose::Emission, ILLUMINANT_E.to_array()),
        ] {
            let found = Spectrum::parse(text).unwrap().colour(purpose);
            let off = (found / DVec3::from_array(expected) - 1.0).abs().max_element();
            // Mitsuba integrates more coarsely.
            assert!(off < 2e-3, "{found} {expected:?}");
        }
        for bad in ["400:1, 300:2", "400:x", "a", "400:1, 5"] {
            assert!(Spectrum::parse(bad).is_err(), "{bad}");
        }
    }
}
