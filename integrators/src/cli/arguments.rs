//! The command line and the limits of its values.

use std::path::PathBuf;

use crate::metropolis::MutationSet;
use crate::poisson::Reconstruction;
use crate::scene::SamplerKind;
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
    /// Measure the errors of integrators against time: tables, charts and a page, with what stands out in words
    Convergence(Box<ConvergenceArguments>),
    /// Join what `convergence` has measured of several scenes into one page
    Report(ReportArguments),
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
    /// Stop when the estimated relative error of each window of 16x16 pixels is below this; --spp or --time
    /// then are the most that is spent
    #[arg(long, value_name = "ERROR", value_parser = positive_number, allow_negative_numbers = true)]
    pub target_error: Option<f64>,
    /// With --target-error, give no more samples to windows that are good enough: faster, and more biased
    #[arg(long, requires = "target_error")]
    pub adaptive: bool,
    /// Print rays, densities and their rates; of Markov chains also how often their steps were accepted
    #[arg(long)]
    pub stats: bool,
    /// Show the picture in the terminal as it grows
    #[arg(long)]
    pub live: bool,
    /// Write the output file every so many seconds, for viewers that reload it
    #[arg(long, value_name = "SECONDS", value_parser = seconds, allow_negative_numbers = true)]
    pub live_exr: Option<f64>,
    /// Keep the state of the render in this file every minute, on Ctrl-C and at the end, and go on from it if it
    /// exists: the image is that of a render without a break, bit by bit
    #[arg(long, value_name = "FILE")]
    pub checkpoint: Option<PathBuf>,
    /// Seconds between two states that --checkpoint keeps
    #[arg(long, value_name = "SECONDS", value_parser = seconds, allow_negative_numbers = true)]
    #[arg(default_value = "60", requires = "checkpoint")]
    pub checkpoint_every: f64,
    /// Seed of the random numbers: the same seed gives the same image [default: the scene's, or 0]
    #[arg(long, value_name = "N", value_parser = seed, allow_negative_numbers = true)]
    pub seed: Option<u64>,
    /// Where random numbers come from, instead of what the scene asks for: `independent`, or Owen-scrambled Sobol points
    /// by any other name that Mitsuba has for a sampler (`ldsampler`): mostly less noise. mlt, pssmlt, ppm and vcm
    /// have uniforms of their own
    #[arg(long, value_name = "NAME", value_parser = sampler)]
    pub sampler: Option<SamplerKind>,
    /// Number of threads, which does not change the image [default: one for each core]
    #[arg(long, value_name = "N", value_parser = threads, allow_negative_numbers = true)]
    pub threads: Option<usize>,
    /// Longest path, counted as in Mitsuba: 1 is emission only, 2 adds direct light, -1 is no limit
    #[arg(long, value_name = "N", value_parser = max_depth, allow_negative_numbers = true)]
    pub max_depth: Option<i32>,
    /// What the renderer is compiled for, instead of the smallest kind that covers the scene
    #[arg(long, value_name = "NAME", value_parser = crate::kind::KINDS)]
    pub kind: Option<String>,

    /// Which techniques to use, by the numbers of vertices from the light and from the camera: `0:*,1:*` is
    /// scattering and next-event estimation, `merge` merges, `portal-1:2` one through a portal
    #[arg(long, value_name = "S:T,..")]
    pub techniques: Option<Selection>,
    /// Write what each technique contributes, with its weight and alone, for paths of up to so many vertices (6
    /// by default): as layers of the EXR file, and as a sheet of pictures
    #[arg(long, value_name = "VERTICES", num_args = 0..=1, default_missing_value = "6",
          value_parser = clap::value_parser!(u32).range(2..=16))]
    pub technique_images: Option<u32>,
    /// Write albedo, normal and depth of what is seen as layers of the EXR file
    #[arg(long)]
    pub aovs: bool,
    /// How many light paths the pixels share: virtual lights (256 by default), photons (one a pixel); of bdpt, how many
    /// light paths a sample takes (one)
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=1 << 24))]
    pub light_paths: Option<u32>,

    /// The largest geometry term of a connection to a virtual light: biased, but without spikes
    #[arg(long, value_name = "LIMIT", value_parser = positive, allow_negative_numbers = true)]
    pub clamp: Option<f32>,

    /// Which mutations mlt uses, instead of all: bidirectional, lens, multi-chain, caustic
    #[arg(long, value_name = "NAME,..")]
    pub mutations: Option<MutationSet>,

    /// Have the chains of mlt and pssmlt carry direct light too, which is path traced otherwise
    #[arg(long)]
    pub chained_direct: bool,

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
    #[arg(long, value_name = "WxH", value_parser = size, allow_hyphen_values = true)]
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

#[derive(Debug, Args)]
pub(super) struct ConvergenceArguments {
    /// Scene file in Mitsuba 3 format
    #[arg(value_name = "SCENE.xml")]
    pub scene: PathBuf,
    /// Integrators to measure, by their names
    #[arg(long, value_name = "NAME,..", value_delimiter = ',', default_value = "path,bdpt")]
    pub integrators: Vec<String>,
    /// An integrator with those options of `render` that are its own, under a name of its own, such as
    /// `bsdf only=bdpt --techniques 0:*`; may be repeated
    #[arg(long, value_name = "LABEL=NAME OPTIONS", value_parser = define)]
    pub variant: Vec<(String, String)>,
    /// Seconds of the longest render of each integrator and seed
    #[arg(long, value_name = "SECONDS", value_parser = seconds, allow_negative_numbers = true)]
    pub budget: f64,
    /// Seeds for each integrator; intervals need three
    #[arg(long, value_name = "N", default_value = "5", value_parser = clap::value_parser!(u16).range(1..=1000))]
    pub repeats: u16,
    /// The first seed
    #[arg(long, value_name = "N", default_value = "0")]
    pub seed: u64,
    /// The image taken as the truth; it is made if there is none
    #[arg(long, value_name = "REF.exr", conflicts_with_all = ["reference_by", "reference_time"])]
    pub reference: Option<PathBuf>,
    /// Unbiased integrators whose union is the reference
    #[arg(long, value_name = "NAME,..", value_delimiter = ',', default_value = "path,bdpt")]
    pub reference_by: Vec<String>,
    /// Seconds for each part of the reference [default: 16 budgets]
    #[arg(long, value_name = "SECONDS", value_parser = seconds, allow_negative_numbers = true)]
    pub reference_time: Option<f64>,
    /// Another renderer: `mitsuba`, or a program that takes the options of the script for Mitsuba; may be repeated
    #[arg(long, value_name = "RENDERER")]
    pub against: Vec<String>,
    /// The Python that can import mitsuba
    #[arg(long, value_name = "PYTHON", default_value = "python3")]
    pub python: PathBuf,
    /// Images that other renderers wrote: a table with the columns renderer,integrator,seed,spp,seconds,file
    #[arg(long, value_name = "IMAGES.csv")]
    pub images: Option<PathBuf>,
    /// Directory for tables, charts, pictures and the page [default: convergence-SCENE]
    #[arg(short, long, value_name = "DIR")]
    pub output: Option<PathBuf>,
    /// Name of the scene in reports [default: that of the file, or of its directory for `scene.xml`]
    #[arg(long, value_name = "NAME")]
    pub name: Option<String>,
    /// Part of the image for strips [default: where the integrators differ most]
    #[arg(long, value_name = "X,Y,W,H", value_parser = crop)]
    pub crop: Option<(usize, usize, usize, usize)>,
    /// Value of a scene parameter, written $name in the scene; may be repeated
    #[arg(short = 'D', value_name = "NAME=VALUE", value_parser = define)]
    pub defines: Vec<(String, String)>,
    /// Columns and rows of the image, instead of the scene's
    #[arg(long, value_name = "WxH", value_parser = size, allow_hyphen_values = true)]
    pub size: Option<(u32, u32)>,
    /// Longest path, as for `render`
    #[arg(long, value_name = "N", value_parser = max_depth, allow_negative_numbers = true)]
    pub max_depth: Option<i32>,
    /// Number of threads [default: one for each core]
    #[arg(long, value_name = "N", value_parser = threads, allow_negative_numbers = true)]
    pub threads: Option<usize>,
    /// The id of a shape that is an opening which light has to pass, and no surface; may be repeated
    #[arg(long = "portal", value_name = "ID")]
    pub portals: Vec<String>,
    /// Have roughplastic lose light as in Mitsuba 3.9, to compare images
    #[arg(long)]
    pub mitsuba3_roughplastic: bool,
}

#[derive(Debug, Args)]
pub(super) struct ReportArguments {
    /// Directories that `convergence` has written
    #[arg(value_name = "DIR", required = true)]
    pub directories: Vec<PathBuf>,
    /// Directory for the report
    #[arg(short, long, value_name = "DIR", default_value = "report")]
    pub output: PathBuf,
}

/// The options of `render` that one integrator of a measurement may have and another not: the scene is read once for all, and how
/// long each renders is the budget's.
const OF_AN_INTEGRATOR: [&str; 9] = [
    "--techniques",
    "--light-paths",
    "--clamp",
    "--mutations",
    "--chained-direct",
    "--reconstruction",
    "--sampler",
    "--kind",
    "--max-depth",
];

/// The render that a convergence measurement does of an integrator with options.
pub(super) fn render_arguments(
    shared: &ConvergenceArguments,
    integrator: &str,
) -> Result<RenderArguments, String> {
    let is_option = |word: &&str| ["--", "-D", "-o"].iter().any(|start| word.starts_with(start));
    for word in integrator.split_whitespace().skip(1).filter(is_option) {
        let name = word.split('=').next().unwrap_or_default();
        if !OF_AN_INTEGRATOR.contains(&name) {
            let options = OF_AN_INTEGRATOR.join(", ");
            return Err(format!(
                "integrator `{integrator}`: {name} is no option of a single integrator here; those are {options}"
            ));
        }
    }
    let mut words: Vec<String> = ["aether", "render", "--integrator"].map(str::to_owned).to_vec();
    words.extend(integrator.split_whitespace().map(str::to_owned));
    words.extend(shared.defines.iter().map(|(name, value)| format!("-D{name}={value}")));
    words.extend(shared.size.map(|(width, height)| format!("--size={width}x{height}")));
    words.extend(shared.max_depth.map(|depth| format!("--max-depth={depth}")));
    words.extend(shared.threads.map(|threads| format!("--threads={threads}")));
    words.extend(shared.portals.iter().map(|id| format!("--portal={id}")));
    words.extend(shared.mitsuba3_roughplastic.then(|| "--mitsuba3-roughplastic".to_owned()));
    // Paths need not be text.
    let mut words: Vec<std::ffi::OsString> = words.into_iter().map(Into::into).collect();
    words.extend(["--".into(), shared.scene.clone().into_os_string()]);
    match Arguments::try_parse_from(words).map(|arguments| arguments.command) {
        Ok(Command::Render(arguments)) => Ok(*arguments),
        Ok(_) => Err(format!("`{integrator}` is no integrator")),
        Err(error) => Err(format!("integrator `{integrator}`: {error}")),
    }
}

fn crop(text: &str) -> Result<(usize, usize, usize, usize), String> {
    let numbers: Option<Vec<usize>> = text.split(',').map(|n| n.trim().parse().ok()).collect();
    match numbers.as_deref() {
        Some(&[x, y, width, height]) if width > 0 && height > 0 => Ok((x, y, width, height)),
        _ => Err("expected column, row, width and height, such as 10,20,64,48".to_owned()),
    }
}

fn positive_number(text: &str) -> Result<f64, String> {
    let allowed = |value: &f64| *value > 0.0 && value.is_finite();
    text.parse().ok().filter(allowed).ok_or("expected a number above 0".to_owned())
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

fn seed(text: &str) -> Result<u64, String> {
    in_range(text.parse().ok(), 0..=u64::MAX)
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

fn sampler(text: &str) -> Result<SamplerKind, String> {
    text.parse().map_err(|kinds| format!("expected one of {kinds}"))
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
