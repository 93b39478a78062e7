//! Directories of measurements, and the pages made of them.
//!
//! A directory holds `errors.csv`, `estimates.csv`, `notes.txt` (remarks of the run, one a line) and `images/`, with
//! pictures of each curve by its name for files.

use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};

use super::record::{Estimate, Row, read_estimates, read_rows, write_estimates, write_rows};
use super::summary::summarise;
use super::{chart, page, table};

/// What was measured, of one directory or of several.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Measurements {
    /// The errors.
    pub rows: Vec<Row>,
    /// What several seeds say together.
    pub estimates: Vec<Estimate>,
    /// Remarks of the runs.
    pub notes: Vec<String>,
    /// PNG files by their names without extension, in order.
    pub pictures: Vec<(String, Vec<u8>)>,
}

impl Measurements {
    /// Reads directories.
    ///
    /// # Errors
    /// If one has no `errors.csv`, or a table cannot be read, with the file and line.
    pub fn read(directories: &[PathBuf]) -> Result<Self, String> {
        let mut all = Measurements::default();
        for directory in directories {
            let path = directory.join("errors.csv");
            let text = fs::read_to_string(&path).map_err(|error| {
                format!(
                    "cannot read `{}`: {error}; give a directory that `aether convergence` has written",
                    path.display()
                )
            })?;
            let within = |path: &Path, error| format!("`{}`, {error}", path.display());
            all.rows.extend(read_rows(&text).map_err(|error| within(&path, error))?);
            let path = directory.join("estimates.csv");
            if let Ok(text) = fs::read_to_string(&path) {
                all.estimates.extend(read_estimates(&text).map_err(|error| within(&path, error))?);
            }
            if let Ok(text) = fs::read_to_string(directory.join("notes.txt")) {
                all.notes.extend(text.lines().map(str::to_owned));
            }
            all.pictures.extend(pictures(&directory.join("images")));
        }
        if all.rows.is_empty() {
            return Err("there are no measurements to report".to_owned());
        }
        match twice(&all.rows) {
            Some(row) => Err(format!(
                "{}, {}, seed {} with {} samples is measured twice; give one of the scenes another --name",
                row.curve.scene,
                row.curve.label(),
                row.seed,
                row.spp
            )),
            None => Ok(all),
        }
    }

    /// The picture with a name.
    pub fn picture(&self, name: &str) -> Option<&[u8]> {
        self.pictures.iter().find(|(other, _)| other == name).map(|(_, bytes)| &bytes[..])
    }

    /// Writes the tables and pictures to a directory.
    ///
    /// # Errors
    /// If a file cannot be written.
    pub fn write(&self, directory: &Path) -> Result<(), String> {
        let images = directory.join("images");
        fs::create_dir_all(&images)
            .map_err(|error| format!("cannot make `{}`: {error}", images.display()))?;
        put(&directory.join("errors.csv"), write_rows(&self.rows).as_bytes())?;
        put(&directory.join("estimates.csv"), write_estimates(&self.estimates).as_bytes())?;
        let notes: String = self.notes.iter().map(|note| format!("{note}\n")).collect();
        put(&directory.join("notes.txt"), notes.as_bytes())?;
        for (name, bytes) in &self.pictures {
            put(&images.join(format!("{name}.png")), bytes)?;
        }
        Ok(())
    }

    /// Writes what is made of the measurements to a directory: a chart and a strip of pictures for each scene,
    /// `report.html` and `report.md`. Returns the Markdown.
    ///
    /// # Errors
    /// If a file cannot be written.
    pub fn report(&self, directory: &Path) -> Result<String, String> {
        let scenes = summarise(&self.rows, &self.estimates);
        fs::create_dir_all(directory)
            .map_err(|error| format!("cannot make `{}`: {error}", directory.display()))?;
        for scene in &scenes {
            let name = page::file_name(&scene.scene);
            put(&directory.join(format!("{name}.svg")), chart::chart(scene).as_bytes())?;
            if let Some(strip) = page::strip(scene, self) {
                put(&directory.join(format!("{name}-strip.svg")), strip.as_bytes())?;
            }
        }
        put(&directory.join("report.html"), page::page(&scenes, self).as_bytes())?;
        let remarks = table::remarks(&scenes, &self.notes);
        let text = format!("{}\n{}\n{remarks}", table::table(&scenes), table::legend(&scenes));
        put(&directory.join("report.md"), text.as_bytes())?;
        Ok(text)
    }
}

/// A measurement that there is already.
fn twice(rows: &[Row]) -> Option<&Row> {
    let mut seen = BTreeSet::new();
    rows.iter().find(|row| !seen.insert((&row.curve, row.seed, row.spp)))
}

fn put(path: &Path, bytes: &[u8]) -> Result<(), String> {
    fs::write(path, bytes).map_err(|error| format!("cannot write `{}`: {error}", path.display()))
}

/// All PNG files of a directory, in the order of their names.
fn pictures(directory: &Path) -> Vec<(String, Vec<u8>)> {
    let Ok(entries) = fs::read_dir(directory) else { return Vec::new() };
    let picture = |path: PathBuf| {
        let is_png = path.extension().is_some_and(|extension| extension == "png");
        let name = path.file_stem()?.to_str()?.to_owned();
        if is_png { Some((name, fs::read(&path).ok()?)) } else { None }
    };
    let mut pictures: Vec<(String, Vec<u8>)> =
        entries.flatten().filter_map(|entry| picture(entry.path())).collect();
    pictures.sort();
    pictures
}
