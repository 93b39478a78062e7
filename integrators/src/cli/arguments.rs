//! The command line and the limits of its values.

use std::path::PathBuf;

use crate::metropolis::MutationSet;
use crate::poisson::Reconstruction;
use crate::selection::Selection;
use clap::{Args, Parser, Subcommand};

/// The most columns or rows of an image, and the most pixels (7.5 GB of accumulators).
const LARGEST_SIDE: u32 = 1 << 15;
const MOST_PIXELS: u64 = 1 << 27;
/// The longest render: ten years.
const MOST_SECONDS: f64 = 3.2e8;
/// The most threads that may be asked for.
const MOST_THREADS: usize = 1024;

/// Renders Mitsuba 3 scenes, and compares renders.
#[derive(Debug, Parser)]
#[command(name = "aether", version)]
pub(super) struct Arguments {
    #[command(subcommand)]
    pub command: Command,
}

#[derive(Debug, Subcommand)]
pub(super) enum Command {
    /// Render a scene to an EXR and a PNG file
    Render(Box<RenderArguments>),
    /// Compare an image with a reference: RMSE, relMSE, PSNR, FLIP, mean ratio, block z-test
    Compare(CompareArguments),
    /// List what is in a scene and what a render will use
    Inspect(InspectArguments),
}

#[derive(Debug, Args)]
pub(super) struct RenderArguments {
    /// Scene file in Mitsuba 3 format
    #[arg(value_name = "SCENE.xml")]
    pub scene: PathBuf,
    /// Output file; a PNG is written beside it [default: the scene's name in this directory]
    #[arg(short, long, value_name = "OUT.exr")]
    pub output: Option<PathBuf>,
    /// Value of a scene parameter, written $name in the scene; may be repeated
    #[arg(short = 'D', value_name = "NAME=VALUE", value_parser = define)]
    pub defines: Vec<(String, String)>,
    /// Integrator to use instead of the scene's
    #[arg(long, value_name = "NAME")]
    pub integrator: Option<String>,
    /// Samples per pixel, instead of the scene's
    #[arg(long, value_name = "N", value_parser = samples, allow_negative_numbers = true)]
    #[arg(conflicts_with = "time")]
    pub spp: Option<u32>,
    /// Seconds to render for, instead of a number of samples
    #[arg(long, value_name = "SECONDS", value_parser = seconds, allow_negative_numbers = true)]
    pub time: Option<f64>,
    /// Seed of the random numbers: the same seed gives the same image [default: the scene's, or 0]
    #[arg(long, value_name = "N", allow_negative_numbers = true)]
    pub seed: Option<u64>,
    /// Number of threads, which does not change the image [default: one for each core]
    #[arg(long, value_name = "N", value_parser = threads, allow_negative_numbers = true)]
    pub threads: Option<usize>,
    /// Longest path, counted as in Mitsuba: 1 is emission only, 2 adds direct light, -1 is no limit
    #[arg(long, value_name = "N", value_parser = max_depth, allow_negative_numbers = true)]
    pub max_depth: Option<i32>,
    /// What the renderer is compiled for, instead of the smallest kind that covers the scene
    #[arg(long, value_name = "NAME", value_parser = crate::kind::KINDS)]
    pub kind: Option<String>,

    /// Which techniques to use where there are several: pairs of numbers of vertices from the light and
    /// from the camera, such as `0:*,1:*`
    #[arg(long, value_name = "S:T,..")]
    pub techniques: Option<Selection>,
    /// How many light paths the pixels share: virtual lights (256 by default), photons (one a pixel)
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=1 << 24))]
    pub light_paths: Option<u32>,

    /// The largest geometry term of a connection to a virtual light: biased, but without spikes
    #[arg(long, value_name = "LIMIT", value_parser = positive)]
    pub clamp: Option<f32>,

    /// Which mutations mlt uses, instead of all: bidirectional, lens, multi-chain, caustic
    #[arg(long, value_name = "NAME,..")]
    pub mutations: Option<MutationSet>,
    /// Print what has been counted: how often mutations were accepted
    #[arg(long)]
    pub stats: bool,

    /// How gdpt makes an image of its gradients: l1 (least noise, the default), l2 (unbiased) or none
    #[arg(long, value_name = "NORM")]
    pub reconstruction: Option<Reconstruction>,

    /// The id of a shape that is an opening which light has to pass, and no surface; may be repeated
    #[arg(long = "portal", value_name = "ID")]
    pub portals: Vec<String>,

    /// Have roughplastic lose light as in Mitsuba 3.9, to compare images
    #[arg(long)]
    pub mitsuba3_roughplastic: bool,
    /// Columns and rows of the image, instead of the scene's
    #[arg(long, value_name = "WxH", value_parser = size, allow_negative_numbers = true)]
    pub size: Option<(u32, u32)>,
}

#[derive(Debug, Args)]
pub(super) struct CompareArguments {
    /// Image under test
    #[arg(value_name = "IMAGE.exr")]
    pub image: PathBuf,
    /// Image taken as the truth
    #[arg(value_name = "REFERENCE.exr")]
    pub reference: PathBuf,
    /// Print JSON; infinite values become null
    #[arg(long)]
    pub json: bool,
}

#[derive(Debug, Args)]
pub(super) struct InspectArguments {
    /// Scene file in Mitsuba 3 format
    #[arg(value_name = "SCENE.xml")]
    pub scene: PathBuf,
    /// Value of a scene parameter, written $name in the scene; may be repeated
    #[arg(short = 'D', value_name = "NAME=VALUE", value_parser = define)]
    pub defines: Vec<(String, String)>,
    /// Print JSON
    #[arg(long)]
    pub json: bool,
}

fn define(text: &str) -> Result<(String, String), String> {
    match text.split_once('=') {
        Some((name, value)) if !name.is_empty() => Ok((name.to_owned(), value.to_owned())),
        _ => Err("expected NAME=VALUE".to_owned()),
    }
}

fn samples(text: &str) -> Result<u32, String> {
    in_range(text.parse().ok(), 1..=i32::MAX as u32)
}

fn threads(text: &str) -> Result<usize, String> {
    in_range(text.parse().ok(), 1..=MOST_THREADS)
}

fn max_depth(text: &str) -> Result<i32, String> {
    in_range(text.parse().ok(), -1..=i32::MAX)
        .map_err(|_| "expected a whole number, or -1 for no limit".to_owned())
}

fn in_range<T: PartialOrd + std::fmt::Display>(
    value: Option<T>,
    range: std::ops::RangeInclusive<T>,
) -> Result<T, String> {
    let message = format!("expected a whole number from {} to {}", range.start(), range.end());
    value.filter(|value| range.contains(value)).ok_or(message)
}

fn positive(text: &str) -> Result<f32, String> {
    let value: f32 = text.parse().map_err(|_| "is not a number".to_owned())?;
    if value > 0.0 { Ok(value) } else { Err("must be positive".to_owned()) }
}

fn seconds(text: &str) -> Result<f64, String> {
    let allowed = |seconds: &f64| *seconds > 0.0 && *seconds <= MOST_SECONDS;
    let message = format!("expected a number of seconds above 0, at most {MOST_SECONDS:e}");
    text.parse().ok().filter(allowed).ok_or(message)
}

fn size(text: &str) -> Result<(u32, u32), String> {
    let sides = text.split_once(['x', 'X']);
    let sides = sides.and_then(|(w, h)| Some((w.parse().ok()?, h.parse().ok()?)));
    let (width, height): (u32, u32) = sides.ok_or("expected WIDTHxHEIGHT, such as 640x480")?;
    check_size((width, height))?;
    Ok((width, height))
}

/// An error unless the image has pixels and fits into memory.
pub(super) fn check_size((width, height): (u32, u32)) -> Result<(), String> {
    let sides = 1..=LARGEST_SIDE;
    let pixels = u64::from(width) * u64::from(height);
    if sides.contains(&width) && sides.contains(&height) && pixels <= MOST_PIXELS {
        return Ok(());
    }
    Err(format!(
        "{width}x{height} is not possible: width and height must be from 1 to {LARGEST_SIDE}, \
         and their product at most {MOST_PIXELS}"
    ))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sizes() {
        assert_eq!(size("640x480"), Ok((640, 480)));
        assert_eq!(size("1X1"), Ok((1, 1)));
        for wrong in ["", "640", "x", "0x0", "8x0", "-1x2", "99999x1", "32768x32768", "4x4x4"] {
            assert!(size(wrong).is_err(), "{wrong}");
        }
    }

    #[test]
    fn numbers() {
        assert_eq!(samples("2147483647"), Ok(2_147_483_647));
        assert_eq!(seconds("0.5"), Ok(0.5));
        assert_eq!((max_depth("-1"), max_depth("0")), (Ok(-1), Ok(0)));
        for wrong in ["0", "-1", "2147483648", "1.5", "x", ""] {
            assert!(samples(wrong).is_err(), "{wrong}");
        }
        for wrong in ["0", "-1", "nan", "inf", "1e300", ""] {
            assert!(seconds(wrong).is_err(), "{wrong}");
        }
        assert!(max_depth("-2").is_err() && threads("0").is_err() && threads("1025").is_err());
    }

    #[test]
    fn defines() {
        assert_eq!(define("a=b=c"), Ok(("a".to_owned(), "b=c".to_owned())));
        assert_eq!(define("a="), Ok(("a".to_owned(), String::new())));
        assert!(define("a").is_err() && define("=b").is_err());
    }

    #[test]
    fn the_command_line_is_consistent() {
        use clap::CommandFactory;
        Arguments::command().debug_assert();
    }
}
