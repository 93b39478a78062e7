//! Images of other renderers.
//!
//! An *adapter* is a program that renders a scene with another renderer, called with the options of [`Request`]. It
//! writes images and a list of them: a table `images.csv` in the directory given, with the columns of
//! [`LIST_COLUMNS`], files relative to it, seconds those of rendering alone. The one for Mitsuba is a Python script
//! ([`MITSUBA`]), which shows how to write another.

use std::path::{Path, PathBuf};
use std::process::Command;

use super::record::Fields;

/// The script that renders with Mitsuba 3.
pub const MITSUBA: &str = include_str!("mitsuba_adapter.py");
/// The columns of a list of images.
pub const LIST_COLUMNS: &str = "renderer,integrator,seed,spp,seconds,file";

/// What an adapter is asked to render.
#[derive(Clone, Debug)]
pub struct Request<'a> {
    /// The scene file: `--scene FILE`.
    pub scene: &'a Path,
    /// Its parameters: `-D NAME=VALUE` for each.
    pub defines: &'a [(String, String)],
    /// The ids of shapes that are openings and no surfaces: `--portal ID` for each.
    pub portals: &'a [String],
    /// `--size WxH`.
    pub size: (u32, u32),
    /// `--max-depth N`, as Mitsuba counts, -1 for no limit.
    pub max_depth: Option<u32>,
    /// `--rr-depth N`.
    pub rr_depth: u32,
    /// `--threads N`, left out for as many as there are.
    pub threads: Option<usize>,
    /// `--budget SECONDS`: a render that is expected to take much longer is left out.
    pub budget: f64,
    /// `--spp N,N,..`, growing.
    pub samples: &'a [u32],
    /// `--seeds N,N,..`.
    pub seeds: std::ops::Range<u64>,
}

impl Request<'_> {
    fn words(&self, output: &Path) -> Vec<std::ffi::OsString> {
        let list = |numbers: Vec<String>| numbers.join(",");
        let depth = self.max_depth.map_or("-1".to_owned(), |depth| depth.to_string());
        let mut words: Vec<std::ffi::OsString> = vec!["--scene".into(), self.scene.into()];
        let mut option = |name: &str, value: String| {
            words.push(format!("{name}={value}").into());
        };
        option("--size", format!("{}x{}", self.size.0, self.size.1));
        option("--max-depth", depth);
        option("--rr-depth", self.rr_depth.to_string());
        option("--budget", self.budget.to_string());
        option("--spp", list(self.samples.iter().map(u32::to_string).collect()));
        option("--seeds", list(self.seeds.clone().map(|seed| seed.to_string()).collect()));
        if let Some(threads) = self.threads {
            option("--threads", threads.to_string());
        }
        for (name, value) in self.defines {
            option("-D", format!("{name}={value}"));
        }
        for id in self.portals {
            option("--portal", id.clone());
        }
        words.extend(["--output".into(), output.into()]);
        words
    }
}

/// Runs an adapter, `mitsuba` or a program, and returns the list that it has written.
///
/// # Errors
/// If it cannot be started or fails, with what it says.
pub fn run(
    adapter: &str,
    python: &Path,
    request: &Request<'_>,
    directory: &Path,
) -> Result<PathBuf, String> {
    let name: String = (Path::new(adapter).file_stem().unwrap_or_default().to_string_lossy())
        .chars()
        .filter(|c| c.is_ascii_alphanumeric())
        .collect();
    let output = directory.join(format!("other-{name}"));
    std::fs::create_dir_all(&output)
        .map_err(|error| format!("cannot make `{}`: {error}", output.display()))?;
    let mut command = if adapter == "mitsuba" {
        let script = output.join("mitsuba_adapter.py");
        std::fs::write(&script, MITSUBA)
            .map_err(|error| format!("cannot write `{}`: {error}", script.display()))?;
        let mut command = Command::new(python);
        command.arg(script);
        command
    } else {
        Command::new(adapter)
    };
    let program = command.get_program().to_string_lossy().into_owned();
    let outcome = command
        .args(request.words(&output))
        .output()
        .map_err(|error| format!("cannot run `{program}`: {error}; is it installed?"))?;
    if !outcome.status.success() {
        let said = String::from_utf8_lossy(&outcome.stderr);
        let last: Vec<&str> = said.trim().lines().rev().take(6).collect();
        let last: Vec<&str> = last.into_iter().rev().collect();
        let hint = if adapter == "mitsuba" {
            "; name a Python that can import mitsuba 3 with --python"
        } else {
            ""
        };
        return Err(format!("`{adapter}` failed ({}){hint}: {}", outcome.status, last.join("\n")));
    }
    Ok(output.join("images.csv"))
}

/// An image of another renderer.
#[derive(Clone, Debug, PartialEq)]
pub struct Entry {
    /// The renderer.
    pub renderer: String,
    /// Its integrator.
    pub integrator: String,
    /// The seed.
    pub seed: u64,
    /// Samples per pixel.
    pub spp: u32,
    /// Seconds of rendering.
    pub seconds: f64,
    /// The EXR file.
    pub file: PathBuf,
}

/// Reads a list of images.
///
/// # Errors
/// If it cannot be read, or a line says no image, with the line.
pub fn read_list(path: &Path) -> Result<Vec<Entry>, String> {
    let text = std::fs::read_to_string(path)
        .map_err(|error| format!("cannot read the list of images `{}`: {error}", path.display()))?;
    let directory = path.parent().unwrap_or(Path::new("."));
    let entry = |fields: &Fields<'_>| {
        Ok(Entry {
            renderer: fields.get("renderer")?,
            integrator: fields.get("integrator")?,
            seed: fields.get("seed")?,
            spp: fields.get("spp")?,
            seconds: fields.number("seconds", 0.0)?,
            file: directory.join(fields.get::<String>("file")?),
        })
    };
    let entries: Result<_, String> =
        Fields::rows(&text, LIST_COLUMNS).and_then(|rows| rows.iter().map(entry).collect());
    entries.map_err(|error| format!("`{}`, {error}", path.display()))
}
