//! Images: what a render produces and what a comparison reads.
//!
//! - [`RgbImage`]: linear Rec. 709 pixels in memory.
//! - [`Picture`]: what a texture shows, in as few bits as its file has.
//! - [`exr`](mod@exr): OpenEXR files, with the variance of each pixel beside its value.
//! - [`png`](mod@png): a tone-mapped picture for looking at.
//! - [`compare`]: error measures between an image and a reference.
//! - [`flip`](mod@flip): the perceptual one of these.
//! - [`block_test`]: do two images with known variances have the same expected value?

pub mod block_test;
pub mod compare;
pub mod decode;
pub mod exr;
mod exr_header;
pub mod flip;
mod picture;
pub mod png;

pub(crate) mod atomic_write;

use std::fmt;
use std::path::{Path, PathBuf};

pub use picture::{Picture, Texels};

/// An image of linear Rec. 709 RGB pixels, row by row from the top left corner.
#[derive(Clone, Debug, PartialEq)]
pub struct RgbImage {
    width: usize,
    height: usize,
    pixels: Vec<[f32; 3]>,
}

impl RgbImage {
    /// An image of `width` times `height` pixels, all equal to `value`.
    pub fn filled(width: usize, height: usize, value: [f32; 3]) -> Self {
        let pixels = vec![value; width * height];
        Self { width, height, pixels }
    }

    /// An image whose pixel in column `x` and row `y` is `pixel(x, y)`.
    pub fn from_fn(
        width: usize,
        height: usize,
        mut pixel: impl FnMut(usize, usize) -> [f32; 3],
    ) -> Self {
        let pixels = (0..height)
            .flat_map(|y| (0..width).map(move |x| (x, y)))
            .map(|(x, y)| pixel(x, y))
            .collect();
        Self { width, height, pixels }
    }

    /// Number of columns.
    pub fn width(&self) -> usize {
        self.width
    }

    /// Number of rows.
    pub fn height(&self) -> usize {
        self.height
    }

    /// All pixels, row by row from the top.
    pub fn pixels(&self) -> &[[f32; 3]] {
        &self.pixels
    }

    /// All pixels, to be changed in place.
    pub fn pixels_mut(&mut self) -> &mut [[f32; 3]] {
        &mut self.pixels
    }

    /// The pixel in column `x` and row `y`.
    ///
    /// # Panics
    /// If the position is outside the image.
    pub fn pixel(&self, x: usize, y: usize) -> [f32; 3] {
        assert!(x < self.width, "column {x} of an image {} pixels wide", self.width);
        self.pixels[y * self.width + x]
    }

    /// The number of pixels with a channel that is NaN or infinite.
    pub fn non_finite_pixels(&self) -> usize {
        self.pixels.iter().filter(|pixel| !is_finite(pixel)).count()
    }

    /// An error unless `other` has the same size.
    pub fn check_same_size(&self, other: &Self) -> Result<(), ImageError> {
        if (self.width, self.height) == (other.width, other.height) {
            return Ok(());
        }
        Err(ImageError::SizeMismatch {
            image: (self.width, self.height),
            reference: (other.width, other.height),
        })
    }
}

/// The linear value of an sRGB code in [0, 1] (IEC 61966-2-1).
pub fn srgb_decode(code: f64) -> f64 {
    if code <= 0.04045 { code / 12.92 } else { ((code + 0.055) / 1.055).powf(2.4) }
}

/// An error unless an image can be written to `path`: ask before rendering for hours.
pub fn check_writable(path: &Path) -> Result<(), ImageError> {
    atomic_write::check(path).map_err(|error| ImageError::io("write", path, error))
}

/// Whether no channel of the pixel is NaN or infinite.
pub(crate) fn is_finite(pixel: &[f32; 3]) -> bool {
    pixel.iter().all(|value| value.is_finite())
}

/// Why an image could not be read, written or compared.
#[derive(Debug)]
pub enum ImageError {
    /// The file could not be opened, read or written.
    Io {
        /// What was attempted: "read" or "write".
        action: &'static str,
        /// The file in question.
        path: PathBuf,
        /// The reason given by the operating system.
        source: std::io::Error,
    },
    /// The file is not an image that this program understands.
    Format {
        /// The file in question.
        path: PathBuf,
        /// What is wrong with its contents.
        reason: String,
    },
    /// Two images that belong together differ in size (width, height).
    SizeMismatch {
        /// The size of the image under test.
        image: (usize, usize),
        /// The size of what it is compared with.
        reference: (usize, usize),
    },
    /// The image has no pixels.
    Empty,
    /// Each pixel is NaN or infinite in one of the two images.
    NothingFinite,
}

impl ImageError {
    fn io(action: &'static str, path: &Path, source: std::io::Error) -> Self {
        Self::Io { action, path: path.to_owned(), source }
    }

    fn format(path: &Path, reason: impl Into<String>) -> Self {
        Self::Format { path: path.to_owned(), reason: reason.into() }
    }
}

impl fmt::Display for ImageError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Io { action, path, source } => {
                write!(f, "cannot {action} `{}`: {source}", path.display())
            }
            Self::Format { path, reason } => write!(f, "`{}` {reason}", path.display()),
            Self::SizeMismatch { image, reference } => write!(
                f,
                "the images differ in size: {}x{} against {}x{} pixels; \
                 render both at the same size",
                image.0, image.1, reference.0, reference.1
            ),
            Self::Empty => write!(f, "the image has no pixels"),
            Self::NothingFinite => {
                write!(f, "nothing to compare: each pixel is NaN or infinite in one of the images")
            }
        }
    }
}

impl std::error::Error for ImageError {
    fn source(&self) -> Option<&(dyn std::error::Error + 'static)> {
        match self {
            Self::Io { source, .. } => Some(source),
            _ => None,
        }
    }
}
