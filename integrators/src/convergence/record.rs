//! What was measured, as text: `errors.csv` has one row for each image, `estimates.csv` one for each integrator.

use std::fmt::Write;

/// The columns of `errors.csv`.
pub const COLUMNS: &str =
    "scene,renderer,integrator,seed,spp,seconds,rays,densities,rmse,relmse,smape,flip";
/// The columns of `estimates.csv`.
pub const ESTIMATE_COLUMNS: &str = "scene,renderer,integrator,seeds,spp,variance,variance_low,\
     variance_high,bias,bias_low,bias_high,biased,floor,reference";

/// Whose curve it is.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct Curve {
    /// The scene.
    pub scene: String,
    /// The program, such as `aether` or `mitsuba-llvm`.
    pub renderer: String,
    /// The integrator, or the name given to it with its options.
    pub integrator: String,
}

impl Curve {
    /// How a report names it: the integrator, with the renderer where that is not this program.
    pub fn label(&self) -> String {
        match self.renderer.as_str() {
            "aether" => self.integrator.clone(),
            renderer => format!("{renderer} {}", self.integrator),
        }
    }

    /// A name for files.
    pub fn slug(&self) -> String {
        let text = format!("{}-{}-{}", self.scene, self.renderer, self.integrator);
        let plain = |c: char| if c.is_ascii_alphanumeric() { c.to_ascii_lowercase() } else { '-' };
        text.chars().map(plain).collect()
    }
}

/// The error of one image.
#[derive(Clone, Debug, PartialEq)]
pub struct Row {
    /// Whose image.
    pub curve: Curve,
    /// The seed of its random numbers.
    pub seed: u64,
    /// Samples per pixel.
    pub spp: u32,
    /// Seconds of rendering, without loading.
    pub seconds: f64,
    /// Rays of both kinds, if they were counted.
    pub rays: Option<u64>,
    /// Conditional densities evaluated, if they were counted.
    pub densities: Option<u64>,
    /// The measures of [`compare`](mod@crate::image::compare).
    pub rmse: f64,
    /// Mean squared error over squared reference plus 0.01.
    pub relmse: f64,
    /// Symmetric relative error.
    pub smape: f64,
    /// Perceived difference.
    pub flip: f64,
}

/// What the images of several seeds say together, all with the same number of samples.
#[derive(Clone, Debug, PartialEq)]
pub struct Estimate {
    /// Whose images.
    pub curve: Curve,
    /// How many seeds.
    pub seeds: usize,
    /// Samples per pixel.
    pub spp: u32,
    /// Relative variance of one sample (in the units of relMSE) with its interval of 99 %; NaN with fewer than three
    /// seeds, like the bias.
    pub variance: [f64; 3],
    /// Relative squared bias, the error of the reference not yet taken off, with its interval of 99 %.
    pub bias: [f64; 3],
    /// Whether the bias exceeds what the error of the reference explains.
    pub biased: bool,
    /// relMSE of the reference itself, if it is known.
    pub floor: Option<f64>,
    /// How the reference was made.
    pub reference: String,
}

/// A name as it can stand in a table: without what separates columns and lines.
pub fn plain(name: &str) -> String {
    name.chars().map(|c| if matches!(c, ',' | '"' | '\n' | '\r') { ' ' } else { c }).collect()
}

/// The text of `errors.csv`.
pub fn write_rows(rows: &[Row]) -> String {
    let mut text = format!("{COLUMNS}\n");
    let count = |n: Option<u64>| n.map(|n| n.to_string()).unwrap_or_default();
    for row in rows {
        let Curve { scene, renderer, integrator } = &row.curve;
        let _ = writeln!(
            text,
            "{},{},{},{},{},{:.6},{},{},{:.6e},{:.6e},{:.6e},{:.6}",
            plain(scene),
            plain(renderer),
            plain(integrator),
            row.seed,
            row.spp,
            row.seconds,
            count(row.rays),
            count(row.densities),
            row.rmse,
            row.relmse,
            row.smape,
            row.flip
        );
    }
    text
}

/// The text of `estimates.csv`.
pub fn write_estimates(estimates: &[Estimate]) -> String {
    let mut text = format!("{ESTIMATE_COLUMNS}\n");
    for e in estimates {
        let Curve { scene, renderer, integrator } = &e.curve;
        let numbers = e.variance.iter().chain(&e.bias).map(|x| format!("{x:.6e}"));
        let floor = e.floor.map(|f| format!("{f:.6e}")).unwrap_or_default();
        let _ = writeln!(
            text,
            "{},{},{},{},{},{},{},{},{}",
            plain(scene),
            plain(renderer),
            plain(integrator),
            e.seeds,
            e.spp,
            numbers.collect::<Vec<_>>().join(","),
            e.biased,
            floor,
            plain(&e.reference)
        );
    }
    text
}

/// The fields of a row of a table, with errors that say where.
pub(super) struct Fields<'a> {
    fields: Vec<&'a str>,
    columns: Vec<&'a str>,
    line: usize,
}

impl<'a> Fields<'a> {
    /// All rows of a table that has these columns.
    pub fn rows(text: &'a str, columns: &'a str) -> Result<Vec<Self>, String> {
        let mut lines = text.lines().enumerate().filter(|(_, line)| !line.trim().is_empty());
        let first = lines.next().map_or("", |(_, line)| line.trim());
        if first != columns {
            return Err(format!("line 1: expected the columns `{columns}`, found `{first}`"));
        }
        let columns: Vec<&str> = columns.split(',').collect();
        let row = |(index, line): (usize, &'a str)| {
            let fields: Vec<&str> = line.trim_end_matches('\r').split(',').collect();
            let (line, found, wanted) = (index + 1, fields.len(), columns.len());
            if found != wanted {
                return Err(format!("line {line}: {found} fields in place of {wanted}"));
            }
            Ok(Fields { fields, columns: columns.clone(), line })
        };
        lines.map(row).collect()
    }

    /// The text of a column.
    pub fn text(&self, column: &str) -> &'a str {
        let at = self.columns.iter().position(|name| *name == column);
        at.map_or("", |at| self.fields[at])
    }

    /// What a column says, or nothing if it is empty.
    pub fn optional<T: std::str::FromStr>(&self, column: &str) -> Result<Option<T>, String> {
        match self.text(column) {
            "" => Ok(None),
            text => text
                .parse()
                .map(Some)
                .map_err(|_| format!("line {}: `{text}` is no value for `{column}`", self.line)),
        }
    }

    /// What a column says.
    pub fn get<T: std::str::FromStr>(&self, column: &str) -> Result<T, String> {
        self.optional(column)?.ok_or(format!("line {}: `{column}` is empty", self.line))
    }

    /// A number above zero, or at least zero.
    pub fn number(&self, column: &str, least: f64) -> Result<f64, String> {
        let value: f64 = self.get(column)?;
        if value.is_finite() && value >= least {
            return Ok(value);
        }
        Err(format!("line {}: `{column}` is {value}, which is no measurement", self.line))
    }

    fn curve(&self) -> Result<Curve, String> {
        let text = |column| self.get::<String>(column);
        Ok(Curve {
            scene: text("scene")?,
            renderer: text("renderer")?,
            integrator: text("integrator")?,
        })
    }
}

/// Reads `errors.csv`.
///
/// # Errors
/// If columns are missing or a value is none, with the line.
pub fn read_rows(text: &str) -> Result<Vec<Row>, String> {
    let row = |fields: &Fields<'_>| {
        Ok(Row {
            curve: fields.curve()?,
            seed: fields.get("seed")?,
            spp: fields.get("spp")?,
            seconds: fields.number("seconds", 0.0)?,
            rays: fields.optional("rays")?,
            densities: fields.optional("densities")?,
            rmse: fields.number("rmse", 0.0)?,
            relmse: fields.number("relmse", 0.0)?,
            smape: fields.number("smape", 0.0)?,
            flip: fields.number("flip", 0.0)?,
        })
    };
    Fields::rows(text, COLUMNS)?.iter().map(row).collect()
}

/// Reads `estimates.csv`.
///
/// # Errors
/// If columns are missing or a value is none, with the line.
pub fn read_estimates(text: &str) -> Result<Vec<Estimate>, String> {
    let row = |fields: &Fields<'_>| {
        let three = |names: [&str; 3]| -> Result<[f64; 3], String> {
            Ok([fields.get(names[0])?, fields.get(names[1])?, fields.get(names[2])?])
        };
        Ok(Estimate {
            curve: fields.curve()?,
            seeds: fields.get("seeds")?,
            spp: fields.get("spp")?,
            variance: three(["variance", "variance_low", "variance_high"])?,
            bias: three(["bias", "bias_low", "bias_high"])?,
            biased: fields.get("biased")?,
            floor: fields.optional("floor")?,
            reference: fields.text("reference").to_owned(),
        })
    };
    Fields::rows(text, ESTIMATE_COLUMNS)?.iter().map(row).collect()
}
