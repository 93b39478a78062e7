//! The stability report: `cargo run --release -p tests --bin stability`.

use std::path::PathBuf;
use std::process::ExitCode;

use tests::leaks::{Leaks, leaks};
use tests::registry::{Item, items};
use tests::stability::report::{FULL, Report, csv, csv_row, json, markdown, rays};
use tests::stability::{Settings, run};

const USAGE: &str = "\
stability [--json] [--markdown FILE] [--csv FILE] [--samples N] [--precise N] [--rays N] [--full]
          [--keep FILE] [NAME...]
  --json           print one object for programs to read
  --markdown FILE  write the report
  --csv FILE       write all figures
  --samples N      random samples of each sampler in f32, against f64 (20000)
  --precise N      random samples of each sampler in f64, against 31 digits (1000)
  --rays N         rays aimed at edges and corners of closed rooms (1000000; none if there are names)
  --full           as many as 10000000, 100000 and 100000000
  --keep FILE      add each sampler's figures to this file when they are there, and take those from it that are
                   there already: a report that was interrupted goes on
  NAME             only samplers with this in their name";

struct Options {
    json: bool,
    markdown: Option<String>,
    csv: Option<String>,
    settings: Settings,
    rays: u64,
    keep: Option<PathBuf>,
    names: Vec<String>,
}

/// What the words of a command line say; the error is what is wrong with them.
fn options(words: impl IntoIterator<Item = String>) -> Result<Options, String> {
    let settings = Settings { single: 20_000, double: 1_000, sweep: true };
    let (markdown, csv, keep, names) = (None, None, None, vec![]);
    let mut options =
        Options { json: false, markdown, csv, settings, rays: 1_000_000, keep, names };
    let mut words = words.into_iter();
    while let Some(word) = words.next() {
        let mut value = || words.next().ok_or(format!("{word} needs a value"));
        let number = |text: String| -> Result<u64, String> {
            text.parse().map_err(|_| format!("{word} needs a whole number, not {text}"))
        };
        match word.as_str() {
            "--json" => options.json = true,
            "--markdown" => options.markdown = Some(value()?),
            "--csv" => options.csv = Some(value()?),
            "--samples" => options.settings.single = number(value()?)?,
            "--precise" => options.settings.double = number(value()?)?,
            "--keep" => options.keep = Some(value()?.into()),
            "--rays" => options.rays = number(value()?)?,
            "--full" => {
                options.settings = FULL;
                options.rays = 100_000_000;
            }
            name if !name.starts_with('-') => {
                if !items().iter().any(|item| item.name.contains(name)) {
                    return Err(format!("no sampler has {name} in its name"));
                }
                options.names.push(name.to_owned());
            }
            _ => return Err(format!("there is no option {word}")),
        }
    }
    Ok(options)
}

fn main() -> ExitCode {
    let options = match options(std::env::args().skip(1)) {
        Ok(options) => options,
        Err(error) => {
            eprintln!("{error}\n\n{USAGE}");
            return ExitCode::from(2);
        }
    };
    // Unoptimised, it would take hours; and nothing is compiled for builds that only test.
    if cfg!(debug_assertions) {
        eprintln!(
            "the report needs an optimised build: cargo run --release -p tests --bin stability"
        );
        return ExitCode::from(2);
    }
    let written = report(&options).map_err(|e| e.to_string()).and_then(|report| {
        if options.json {
            println!("{}", json(&report));
        } else {
            print!("{}", markdown(&report));
        }
        let write = |file: &Option<String>, text: String| match file {
            Some(file) => std::fs::write(file, text).map_err(|e| format!("{file}: {e}")),
            None => Ok(()),
        };
        write(&options.markdown, markdown(&report)).and(write(&options.csv, csv(&report.rows)))
    });
    match written {
        Ok(()) => ExitCode::SUCCESS,
        Err(message) => {
            eprintln!("{message}");
            ExitCode::FAILURE
        }
    }
}

/// Everything, rows in the order of the registry. Each is written to the error stream as soon as it is there.
fn report(options: &Options) -> std::io::Result<Report> {
    let leaks = if options.names.is_empty() { leaks(options.rays) } else { Leaks::default() };
    eprintln!("{}", rays(&leaks));
    let mut items = items();
    let named = |item: &Item| options.names.iter().any(|name| item.name.contains(name.as_str()));
    items.retain(|item| options.names.is_empty() || named(item));
    let rows = run(&items, options.settings, options.keep.as_deref(), &|row, time| {
        eprint!("{:.1} s: {}", time.as_secs_f64(), csv_row(row));
    })?;
    Ok(Report { settings: options.settings, rows, leaks })
}
