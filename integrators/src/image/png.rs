//! A tone-mapped picture for looking at: 8 bits, sRGB, exposure 1, clamped.

use std::path::Path;

use super::atomic_write::write_file;
use super::{ImageError, RgbImage};

/// Writes the image as an 8-bit sRGB PNG: values are clamped to [0, 1] and encoded with the sRGB
/// transfer function, without exposure. The file appears complete or not at all.
///
/// # Errors
/// If the file cannot be written or the image has no pixels.
pub fn write(image: &RgbImage, path: &Path) -> Result<(), ImageError> {
    if image.pixels().is_empty() {
        return Err(ImageError::Empty);
    }
    let bytes = encode(image)
        .map_err(|error| ImageError::format(path, format!("cannot be encoded: {error}")))?;
    write_file(path, &bytes).map_err(|error| ImageError::io("write", path, error))
}

/// The bytes of the file that [`write()`] writes.
pub(crate) fn encode(image: &RgbImage) -> Result<Vec<u8>, ::png::EncodingError> {
    let mut bytes = Vec::new();
    // Sizes beyond u32 cannot be allocated, so the conversion is exact.
    let mut encoder = ::png::Encoder::new(&mut bytes, image.width() as u32, image.height() as u32);
    encoder.set_color(::png::ColorType::Rgb);
    encoder.set_depth(::png::BitDepth::Eight);
    encoder.set_source_srgb(::png::SrgbRenderingIntent::Perceptual);
    let mut writer = encoder.write_header()?;
    let data: Vec<u8> = image.pixels().iter().flatten().map(|&value| srgb_byte(value)).collect();
    writer.write_image_data(&data)?;
    writer.finish()?;
    Ok(bytes)
}

/// The 8-bit sRGB code of a linear value; NaN becomes 0.
fn srgb_byte(linear: f32) -> u8 {
    // `as` cuts off the fraction and turns NaN into 0.
    (srgb_encode(linear.clamp(0.0, 1.0)) * 255.0 + 0.5) as u8
}

/// The sRGB transfer function (IEC 61966-2-1) of a linear value in [0, 1].
pub fn srgb_encode(linear: f32) -> f32 {
    if linear <= 0.003_130_8 { 12.92 * linear } else { 1.055 * linear.powf(1.0 / 2.4) - 0.055 }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn known_codes() {
        let codes = [-1.0, 0.0, 0.002, 0.214_041_14, 0.5, 1.0, 7.0, f32::NAN, f32::INFINITY];
        let expected = [0, 0, 7, 128, 188, 255, 255, 0, 255];
        assert_eq!(codes.map(srgb_byte), expected);
    }

    #[test]
    fn the_file_decodes_to_the_same_codes() {
        let image = RgbImage::from_fn(3, 2, |x, y| [x as f32, y as f32, 0.5]);
        let bytes = encode(&image).unwrap();
        let mut reader = ::png::Decoder::new(std::io::Cursor::new(bytes)).read_info().unwrap();
        let mut data = vec![0; reader.output_buffer_size().unwrap()];
        reader.next_frame(&mut data).unwrap();
        assert_eq!(reader.info().size(), (3, 2));
        assert_eq!(&data[..6], &[0, 0, 188, 255, 0, 188]);
        assert!(write(&RgbImage::filled(0, 0, [0.0; 3]), Path::new("x.png")).is_err());
    }
}
