//! OpenEXR files.
//!
//! A render is written as one scan-line part with `R`, `G`, `B` (linear Rec. 709, 32-bit float)
//! and, where it is known, the variance *of the pixel mean* as `variance.R`, `variance.G` and
//! `variance.B`, which is how most readers expect several images in one part. The reader takes
//! files of any program: several parts, half or float channels, any compression.

use std::collections::BTreeMap;
use std::io::{BufRead, BufReader, Cursor};
use std::path::Path;

use ::exr::prelude as openexr;
use openexr::{AnyChannel, AnyChannels, AttributeValue, FlatSamples, Text};
use openexr::{ReadChannels, ReadLayers, WritableImage};

use super::atomic_write::write_file;
use super::exr_header::sort_attributes;
use super::{ImageError, RgbImage};

/// The first bytes of every EXR file.
const MAGIC_NUMBER: [u8; 4] = [0x76, 0x2f, 0x31, 0x01];

/// The value of a header attribute.
#[derive(Clone, Debug, PartialEq)]
pub enum Attribute {
    /// A text. Characters outside Latin-1 are written as `?`.
    Text(String),
    /// A whole number.
    Integer(i32),
    /// A real number.
    Number(f64),
}

/// An image to be written: the picture, what is known about its error, and how it was made.
#[derive(Clone, Debug, PartialEq)]
pub struct Exr {
    /// The linear Rec. 709 picture.
    pub rgb: RgbImage,
    /// The variance of the mean of each pixel and channel, if it is known.
    pub variance: Option<RgbImage>,
    /// Further images by the names of their groups of channels: those called `x` have the channels `x.R`, `x.G`
    /// and `x.B`.
    pub layers: BTreeMap<String, RgbImage>,
    /// Header attributes by name: scene, seed, samples, seconds and so on.
    pub attributes: BTreeMap<String, Attribute>,
}

/// The attribute that tells by what the variance of the mean of many pixels is larger than that of pixels that know nothing of
/// each other.
pub const CORRELATION: &str = "correlation";

impl Exr {
    /// The variance of each pixel as it is for the mean of many of them.
    pub fn variance_in_means(&self) -> Option<RgbImage> {
        let factor = match self.attributes.get(CORRELATION) {
            Some(Attribute::Number(factor)) => *factor as f32,
            _ => 1.0,
        };
        let mut variance = self.variance.clone()?;
        variance.pixels_mut().iter_mut().for_each(|pixel| *pixel = pixel.map(|v| v * factor));
        Some(variance)
    }

    /// Writes the file at once or not at all: a crash never leaves a broken file.
    ///
    /// # Errors
    /// If the file cannot be written, has no pixels, or the variance or a layer differs in size.
    pub fn write(&self, path: &Path) -> Result<(), ImageError> {
        if self.rgb.pixels().is_empty() {
            return Err(ImageError::Empty);
        }
        let mut channels = channels_of("", &self.rgb);
        if let Some(variance) = &self.variance {
            self.rgb.check_same_size(variance)?;
            channels.extend(channels_of("variance.", variance));
        }
        for (name, layer) in &self.layers {
            self.rgb.check_same_size(layer)?;
            channels.extend(channels_of(&format!("{name}."), layer));
        }
        let encoding = openexr::Encoding {
            compression: openexr::Compression::ZIP16,
            blocks: openexr::Blocks::ScanLines,
            line_order: openexr::LineOrder::Increasing,
        };
        let layer = openexr::Layer::new(
            (self.rgb.width(), self.rgb.height()),
            openexr::LayerAttributes::default(),
            encoding,
            AnyChannels::sort(channels.into_iter().collect()),
        );
        let mut image = openexr::Image::from_layer(layer);
        for (name, value) in &self.attributes {
            image.attributes.other.insert(latin1(name), attribute_value(value));
        }
        let mut bytes = Cursor::new(Vec::new());
        image
            .write()
            .to_buffered(&mut bytes)
            .map_err(|error| ImageError::format(path, format!("cannot be encoded: {error}")))?;
        sort_attributes(bytes.get_mut());
        write_file(path, bytes.get_ref()).map_err(|error| ImageError::io("write", path, error))
    }

    /// Reads the picture, its variance if there is one, other images of its size, and the attributes of any EXR
    /// file.
    ///
    /// The picture is the group of channels `R`, `G`, `B` without a prefix, or else the first
    /// group with these three that is not a variance. Its variance has the prefix `variance`,
    /// after that of the picture if it has one.
    ///
    /// # Errors
    /// If the file is missing, is no EXR file, is of an unsupported kind or has no RGB channels.
    pub fn read(path: &Path) -> Result<Self, ImageError> {
        let file = ExrGroups::read(path)?;
        let Some(picture) = file.picture_name() else {
            let names = file.channels.join(", ");
            let reason = format!("has no channels R, G and B; its channels are: {names}");
            return Err(ImageError::format(path, reason));
        };
        let variance_name = file.variance_name(&picture);
        let ExrGroups { mut groups, attributes, .. } = file;
        let variance = variance_name.and_then(|name| groups.remove(&name));
        let rgb = groups.remove(&picture).ok_or(ImageError::Empty)?;
        if let Some(variance) = &variance {
            rgb.check_same_size(variance)?;
        }
        groups.retain(|_, image| rgb.check_same_size(image).is_ok());
        Ok(Self { rgb, variance, layers: groups, attributes })
    }
}

/// All that an EXR file contains, by the names of its groups of channels.
#[derive(Clone, Debug, PartialEq)]
pub struct ExrGroups {
    /// Each complete group of channels R, G and B by its prefix: the part's name, if it has one
    /// and there are several parts, then what precedes the last dot in the channel names. The
    /// prefix of plain `R`, `G`, `B` is empty.
    pub groups: BTreeMap<String, RgbImage>,
    /// The full names of all channels in the file, whether they belong to a group or not.
    pub channels: Vec<String>,
    /// The text and number attributes of the file; those of its parts where names are repeated
    /// are taken from the first part.
    pub attributes: BTreeMap<String, Attribute>,
}

impl ExrGroups {
    /// Reads every RGB group of the file.
    ///
    /// # Errors
    /// If the file is missing, is no EXR file or is of an unsupported kind (deep data).
    pub fn read(path: &Path) -> Result<Self, ImageError> {
        let file = std::fs::File::open(path).map_err(|e| ImageError::io("read", path, e))?;
        let metadata = file.metadata().map_err(|e| ImageError::io("read", path, e))?;
        if metadata.is_dir() {
            return Err(ImageError::format(path, "is a directory, not an EXR file"));
        }
        let mut file = BufReader::new(file);
        let start = file.fill_buf().map_err(|e| ImageError::io("read", path, e))?;
        if !start.starts_with(&MAGIC_NUMBER) {
            return Err(ImageError::format(path, "is not an EXR file"));
        }
        let image: openexr::FlatImage = openexr::read()
            .no_deep_data()
            .largest_resolution_level()
            .all_channels()
            .all_layers()
            .all_attributes()
            .from_buffered(file)
            .map_err(|error| ImageError::format(path, read_failure(&error)))?;

        let mut result =
            Self { groups: BTreeMap::new(), channels: Vec::new(), attributes: BTreeMap::new() };
        let several = image.layer_data.len() > 1;
        for layer in &image.layer_data {
            let part = layer.attributes.layer_name.as_ref().filter(|_| several);
            result.add_layer(part.map(Text::to_string).unwrap_or_default(), layer);
        }
        for (name, value) in &image.attributes.other {
            result.add_attribute(name, value);
        }
        Ok(result)
    }

    fn add_layer(&mut self, part: String, layer: &openexr::Layer<AnyChannels<FlatSamples>>) {
        let mut colours: BTreeMap<String, [Option<&FlatSamples>; 3]> = BTreeMap::new();
        for channel in &layer.channel_data.list {
            let channel_name = channel.name.to_string();
            let name = join(&part, &channel_name);
            let (prefix, colour) = name.rsplit_once('.').unwrap_or(("", &name));
            if let Some(index) = ["R", "G", "B"].iter().position(|c| *c == colour) {
                let samples = colours.entry(prefix.to_owned()).or_default();
                samples[index] = Some(&channel.sample_data);
            }
            self.channels.push(name);
        }
        for (prefix, samples) in colours {
            if let [Some(r), Some(g), Some(b)] = samples {
                let (width, height) = (layer.size.0, layer.size.1);
                let pixels = r.values_as_f32().zip(g.values_as_f32()).zip(b.values_as_f32());
                let pixels = pixels.map(|((r, g), b)| [r, g, b]).collect();
                let image = RgbImage { width, height, pixels };
                self.groups.entry(prefix).or_insert(image);
            }
        }
        for (name, value) in &layer.attributes.other {
            self.add_attribute(name, value);
        }
    }

    fn add_attribute(&mut self, name: &Text, value: &AttributeValue) {
        let value = match value {
            AttributeValue::Text(text) => Attribute::Text(text.to_string()),
            AttributeValue::I32(number) => Attribute::Integer(*number),
            AttributeValue::F32(number) => Attribute::Number(f64::from(*number)),
            AttributeValue::F64(number) => Attribute::Number(*number),
            _ => return,
        };
        self.attributes.entry(name.to_string()).or_insert(value);
    }

    /// The prefix of the group that is the picture.
    fn picture_name(&self) -> Option<String> {
        let mut names = self.groups.keys();
        names.find(|name| name.rsplit('.').next() != Some("variance")).cloned()
    }

    /// The prefix of the variance of the picture called `picture`, if there is one.
    fn variance_name(&self, picture: &str) -> Option<String> {
        let own = join(picture, "variance");
        [own, "variance".to_owned()].into_iter().find(|name| self.groups.contains_key(name))
    }
}

/// The dotted name of `name` inside the group called `prefix`.
fn join(prefix: &str, name: &str) -> String {
    if prefix.is_empty() { name.to_owned() } else { format!("{prefix}.{name}") }
}

/// The three channels of an image as float samples.
fn channels_of(prefix: &str, image: &RgbImage) -> Vec<AnyChannel<FlatSamples>> {
    let samples = |c: usize| image.pixels().iter().map(|pixel| pixel[c]).collect();
    ["R", "G", "B"]
        .iter()
        .enumerate()
        .map(|(c, name)| {
            AnyChannel::new(latin1(&format!("{prefix}{name}")), FlatSamples::F32(samples(c)))
        })
        .collect()
}

fn attribute_value(value: &Attribute) -> AttributeValue {
    match value {
        Attribute::Text(text) => AttributeValue::Text(latin1(text)),
        Attribute::Integer(number) => AttributeValue::I32(*number),
        Attribute::Number(number) => AttributeValue::F64(*number),
    }
}

/// The text in the one-byte encoding of EXR headers, with `?` for what it cannot express.
fn latin1(text: &str) -> Text {
    let bytes = text.chars().map(|c| u8::try_from(c).unwrap_or(b'?'));
    Text::from_bytes_unchecked(bytes.collect())
}

fn read_failure(error: &::exr::error::Error) -> String {
    use ::exr::error::Error;
    match error {
        Error::NotSupported(what) => format!("is an EXR file of an unsupported kind: {what}"),
        Error::Invalid(what) => format!("is a broken EXR file: {what}"),
        other => format!("is a broken EXR file: {other}"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::path::PathBuf;

    fn temporary(name: &str) -> PathBuf {
        std::env::temp_dir().join(format!("aether-exr-{}-{name}", std::process::id()))
    }

    fn sample() -> Exr {
        let rgb = RgbImage::from_fn(5, 3, |x, y| [x as f32, y as f32 + 0.25, 1e-7]);
        let variance = Some(RgbImage::from_fn(5, 3, |x, _| [x as f32 * 1e-9, 2.0, 3.0]));
        let attributes = [
            ("scene".to_owned(), Attribute::Text("caf\u{e9} \u{4e16}.xml".to_owned())),
            ("samples".to_owned(), Attribute::Integer(64)),
            ("seconds".to_owned(), Attribute::Number(0.1)),
        ];
        let layers = BTreeMap::from([("one.two".to_owned(), RgbImage::filled(5, 3, [7.0; 3]))]);
        Exr { rgb, variance, layers, attributes: attributes.into() }
    }

    #[test]
    fn what_is_written_is_read() {
        let path = temporary("round.exr");
        let image = sample();
        image.write(&path).unwrap();
        let read = Exr::read(&path).unwrap();
        std::fs::remove_file(&path).unwrap();
        assert_eq!((&read.rgb, &read.variance), (&image.rgb, &image.variance));
        assert_eq!(read.layers, image.layers);
        assert_eq!(read.attributes["samples"], Attribute::Integer(64));
        assert_eq!(read.attributes["seconds"], Attribute::Number(0.1));
        assert_eq!(read.attributes["scene"], Attribute::Text("caf\u{e9} ?.xml".to_owned()));
    }

    #[test]
    fn parts_of_other_programs_are_found() {
        let path = temporary("parts.exr");
        let half = |v: f32| FlatSamples::F16(vec![::exr::prelude::f16::from_f32(v); 4]);
        let layer = |name: &str, names: &[&str], value: f32, compression| {
            let list = names.iter().map(|n| AnyChannel::new(*n, half(value))).collect();
            let mut encoding = openexr::Encoding::FAST_LOSSLESS;
            encoding.compression = compression;
            let attributes = openexr::LayerAttributes::named(name);
            openexr::Layer::new((2, 2), attributes, encoding, AnyChannels::sort(list))
        };
        use openexr::Compression::{PIZ, Uncompressed};
        let layers: openexr::Layers<_> = [
            layer("variance", &["R", "G", "B"], 0.5, Uncompressed),
            layer("beauty", &["R", "G", "B", "A", "Z"], 2.0, PIZ),
        ]
        .into_iter()
        .collect();
        let window = openexr::ImageAttributes::with_size((2, 2));
        openexr::Image::from_layers(window, layers).write().to_file(&path).unwrap();
        let read = Exr::read(&path).unwrap();
        std::fs::remove_file(&path).unwrap();
        assert_eq!(read.rgb, RgbImage::filled(2, 2, [2.0; 3]));
        assert_eq!(read.variance, Some(RgbImage::filled(2, 2, [0.5; 3])));
    }

    #[test]
    fn errors_say_what_is_wrong() {
        let message = |path: &Path| Exr::read(path).unwrap_err().to_string();
        assert!(message(&temporary("missing.exr")).contains("cannot read"));
        assert!(message(&std::env::temp_dir()).contains("is a directory"));

        let text = temporary("text.exr");
        std::fs::write(&text, "this is not an image").unwrap();
        assert!(message(&text).contains("is not an EXR file"), "{}", message(&text));

        sample().write(&text).unwrap();
        let bytes = std::fs::read(&text).unwrap();
        std::fs::write(&text, &bytes[..bytes.len() - 30]).unwrap();
        assert!(message(&text).contains("broken EXR"), "{}", message(&text));

        let list = std::iter::once(AnyChannel::new("Y", FlatSamples::F32(vec![0.0; 4]))).collect();
        let grey = openexr::Image::from_channels((2, 2), AnyChannels::sort(list));
        grey.write().to_file(&text).unwrap();
        assert!(message(&text).contains("no channels R, G and B; its channels are: Y"));
        std::fs::remove_file(&text).unwrap();

        let mut wrong = sample();
        wrong.variance = Some(RgbImage::filled(1, 1, [0.0; 3]));
        assert!(matches!(wrong.write(&text), Err(ImageError::SizeMismatch { .. })));
    }
}
