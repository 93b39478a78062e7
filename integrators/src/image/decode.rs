//! Pictures of any common format, as textures need them.

use std::path::Path;

use zune_core::bytestream::ZCursor;
use zune_core::colorspace::ColorSpace;
use zune_core::options::DecoderOptions;

use super::exr::Exr;
use super::{ImageError, Picture, Texels, srgb_decode};

/// Larger pictures are refused: columns or rows.
const LARGEST: usize = 1 << 14;
/// The most channels of an EXR file, over all its parts.
const MOST_CHANNELS: usize = 64;

/// Reads an EXR, PNG, JPEG or Radiance HDR file, told apart by its first bytes. Pictures with 8 or 16 bits
/// a channel are decoded from sRGB to linear Rec. 709, unless they are `raw` numbers.
///
/// # Errors
/// If the file cannot be read, is none of these, is broken or too large.
pub fn read(path: &Path, raw: bool) -> Result<Picture, ImageError> {
    let fail = |message: String| ImageError::format(path, message);
    let is_file = std::fs::metadata(path).map(|metadata| metadata.is_file());
    if !is_file.map_err(|error| ImageError::io("read", path, error))? {
        return Err(fail("is no regular file".to_owned()));
    }
    let bytes = std::fs::read(path).map_err(|error| ImageError::io("read", path, error))?;
    match bytes.get(..4) {
        Some([0x76, 0x2f, 0x31, 0x01]) => {
            exr_size(&bytes).and_then(|size| plausible(size, &bytes)).map_err(fail)?;
            Exr::read(path).map(|exr| exr.rgb.into())
        }
        Some([0x89, b'P', b'N', b'G']) => png(&bytes, raw).map_err(fail),
        Some([0xff, 0xd8, 0xff, _]) => jpeg(&bytes, raw).map_err(fail),
        Some([b'#', b'?', _, _]) => hdr(&bytes).map_err(fail),
        _ => Err(fail("is no EXR, PNG, JPEG or Radiance HDR file".to_owned())),
    }
}

/// Refuses pictures that are too large, and small files that claim to be large ones: nothing is reserved
/// for those. No format packs more pixels into a byte than this.
fn plausible((width, height): (usize, usize), bytes: &[u8]) -> Result<(), String> {
    const PIXELS_PER_BYTE: usize = 4096;
    if width == 0 || height == 0 || width > LARGEST || height > LARGEST {
        return Err(format!(
            "{width} x {height} pixels; from 1 to {LARGEST} each way are supported"
        ));
    }
    if width * height > PIXELS_PER_BYTE * bytes.len() {
        return Err(format!("{} bytes cannot hold {width} x {height} pixels", bytes.len()));
    }
    Ok(())
}

/// Columns and rows of the largest part of an EXR file.
fn exr_size(bytes: &[u8]) -> Result<(usize, usize), String> {
    let meta = ::exr::meta::MetaData::read_from_buffered(std::io::Cursor::new(bytes), false);
    let meta = meta.map_err(|error| error.to_string())?;
    let sizes = meta.headers.iter().map(|h| (h.layer_size.width(), h.layer_size.height()));
    let largest = sizes.fold((0, 0), |a, b| (b.0.max(a.0), b.1.max(a.1)));
    let channels: usize = meta.headers.iter().map(|h| h.channels.list.len()).sum();
    if channels > MOST_CHANNELS {
        return Err(format!("{channels} channels; at most {MOST_CHANNELS} are supported"));
    }
    Ok(largest)
}

/// The linear value of a code in [0, 1].
fn linear(code: f32, raw: bool) -> f32 {
    if raw { code } else { srgb_decode(f64::from(code)) as f32 }
}

/// A picture of what its texels are made to be.
fn picture(size: (usize, usize), texels: Texels) -> Result<Picture, String> {
    Picture::new(size, texels).ok_or_else(|| "ends before its last pixel".to_owned())
}

/// The colours of as many pixels as there are at most, from numbers of which each pixel has `channels`: grey, grey and
/// alpha, RGB or RGBA.
fn colours<T: Copy>(most: (usize, usize), channels: usize, numbers: &[T]) -> Vec<[T; 3]> {
    let pixels = numbers.chunks_exact(channels.max(1)).take(most.0 * most.1);
    pixels.map(|pixel| [0, 1, 2].map(|c| pixel[if channels < 3 { 0 } else { c }])).collect()
}

/// Codes with eight bits.
fn codes(size: (usize, usize), channels: usize, bytes: &[u8], raw: bool) -> Texels {
    let values = std::array::from_fn(|code| linear(code as f32 / 255.0, raw));
    Texels::Codes(colours(size, channels, bytes), Box::new(values))
}

fn png(bytes: &[u8], raw: bool) -> Result<Picture, String> {
    let mut decoder = ::png::Decoder::new(std::io::Cursor::new(bytes));
    decoder.set_transformations(::png::Transformations::EXPAND);
    let mut reader = decoder.read_info().map_err(|error| error.to_string())?;
    let info = reader.info();
    let size = (info.width as usize, info.height as usize);
    plausible(size, bytes)?;
    let length = reader.output_buffer_size().ok_or("its size is not representable")?;
    let mut data = vec![0; length];
    let frame = reader.next_frame(&mut data).map_err(|error| error.to_string())?;
    let channels = frame.color_type.samples();
    let texels = match frame.bit_depth {
        ::png::BitDepth::Sixteen => {
            let code = |pair: &[u8]| f32::from(u16::from_be_bytes([pair[0], pair[1]])) / 65535.0;
            let values = data.chunks_exact(2).map(|pair| linear(code(pair), raw));
            Texels::Numbers(colours(size, channels, &values.collect::<Vec<_>>()))
        }
        _ => codes(size, channels, &data, raw),
    };
    picture(size, texels)
}

/// Whether a JPEG file ends before its end marker: a decoder makes a picture of what there is.
fn is_cut_short(bytes: &[u8]) -> bool {
    let mut at = 2;
    loop {
        match bytes.get(at..at + 2) {
            None => return true,
            Some([0xff, 0xd9]) => return false,
            // Segments say how long they are: with tables, comments, perhaps a small picture with an end of its own.
            Some([0xff, 0xc0..=0xcf | 0xda..=0xdf | 0xe0..=0xef | 0xfe]) => {
                let Some(&[high, low]) = bytes.get(at + 2..at + 4) else { return true };
                at += 2 + usize::from(u16::from_be_bytes([high, low]));
            }
            // The data of a scan, and markers without anything.
            Some(_) => at += 1,
        }
    }
}

fn jpeg(bytes: &[u8], raw: bool) -> Result<Picture, String> {
    if is_cut_short(bytes) {
        return Err("is cut short: the end of the picture is missing".to_owned());
    }
    let options = DecoderOptions::default()
        .set_max_width(LARGEST)
        .set_max_height(LARGEST)
        .jpeg_set_out_colorspace(ColorSpace::RGB);
    let mut decoder = zune_jpeg::JpegDecoder::new_with_options(ZCursor::new(bytes), options);
    decoder.decode_headers().map_err(|error| error.to_string())?;
    let info = decoder.info().ok_or("has no size")?;
    let size = (usize::from(info.width), usize::from(info.height));
    plausible(size, bytes)?;
    let data = decoder.decode().map_err(|error| error.to_string())?;
    let channels = data.len() / (size.0 * size.1).max(1);
    picture(size, codes(size, channels, &data, raw))
}

fn hdr(bytes: &[u8]) -> Result<Picture, String> {
    let options = DecoderOptions::default().set_max_width(LARGEST).set_max_height(LARGEST);
    let mut decoder = zune_hdr::HdrDecoder::new_with_options(ZCursor::new(bytes), options);
    decoder.decode_headers().map_err(|error| format!("{error:?}"))?;
    let (width, height) = decoder.dimensions().ok_or("has no size")?;
    plausible((width, height), bytes)?;
    let data = decoder.decode().map_err(|error| format!("{error:?}"))?;
    let size = (width, height);
    picture(size, Texels::Numbers(colours(size, 3, &data)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::image::RgbImage;

    fn temporary(name: &str, bytes: &[u8]) -> std::path::PathBuf {
        let path = std::env::temp_dir().join(format!("aether-{}-{name}", std::process::id()));
        std::fs::write(&path, bytes).unwrap();
        path
    }

    #[test]
    fn pngs_come_back() {
        let image = RgbImage::from_fn(3, 2, |x, y| [x as f32 / 2.0, y as f32, 0.25]);
        let path = std::env::temp_dir().join(format!("aether-{}-back.png", std::process::id()));
        super::super::png::write(&image, &path).unwrap();
        let back = read(&path, false).unwrap().into_image();
        let codes = read(&path, true).unwrap();
        std::fs::remove_file(&path).unwrap();
        assert_eq!((back.width(), back.height()), (3, 2));
        for (a, b) in back.pixels().iter().flatten().zip(image.pixels().iter().flatten()) {
            assert!((a - b).abs() < 5e-3, "{a} {b}");
        }
        assert!((codes.texel(1, 0)[0] - 188.0 / 255.0).abs() < 1e-6);
    }

    #[test]
    fn a_jpeg_ends_with_its_end_marker() {
        // A segment with an end marker in it, a scan with an escaped byte, the end, and what is none of it.
        let file = [
            &b"\xff\xd8\xff\xe1\0\x06\xff\xd9\0\0\xff\xda\0\x03\x01"[..],
            b"\x12\xff\0\x34\xff\xd0\x56\xff\xd9\xff\xda\0\x03",
        ]
        .concat();
        assert!(!is_cut_short(&file));
        let end = file.len() - 4;
        for length in 2..end {
            assert!(is_cut_short(&file[..length]), "{length}");
        }
        assert!(!is_cut_short(&file[..end]));
    }

    #[test]
    fn broken_files_are_errors() {
        for (name, bytes) in [
            ("a.png", &b"\x89PNG\r\n\x1a\n\0\0"[..]),
            ("b.jpg", &b"\xff\xd8\xff\xe0\0\x10JFIF"[..]),
            ("c.hdr", &b"#?RADIANCE\n\n-Y 9999999 +X 9999999\n"[..]),
            ("d.xyz", &b"hello"[..]),
            ("e.exr", &b"\x76\x2f\x31\x01"[..]),
        ] {
            let path = temporary(name, bytes);
            let result = read(&path, false);
            std::fs::remove_file(&path).unwrap();
            assert!(result.is_err(), "{name}");
        }
        assert!(read(Path::new("/no/such.png"), false).is_err());
    }
}
