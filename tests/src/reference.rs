//! The reference values of the catalogue, `reference/catalogue-e.json` and `catalogue-mh.json`.
//!
//! Made in high precision by `reference/make_conditions.py` and `make_rows.py`; `reference/README.md` says what each
//! field means. Every entry is read in two versions, one in each precision.

use serde_json::Value;

/// What was computed for a sampler: its parameters, exact.
#[derive(Clone, Debug)]
pub struct Inputs {
    /// Number of the row of the catalogue.
    pub row: u64,
    /// The sampler's name.
    pub name: String,
    params: Value,
}

impl Inputs {
    /// The scalar parameter called `name`.
    ///
    /// # Panics
    /// If the entry has no such parameter.
    pub fn scalar(&self, name: &str) -> f64 {
        self.params[name].as_f64().unwrap_or_else(|| panic!("{self:?} has no {name}"))
    }

    /// All parameters as a list of numbers, vectors by coordinates: their order is that of the item.
    pub fn numbers(&self) -> Vec<f64> {
        let number = |v: &Value| v.as_f64().unwrap_or(f64::NAN);
        let parameters = self.params.as_object().into_iter().flatten();
        parameters
            .flat_map(|(_, v)| {
                v.as_array()
                    .map_or_else(|| vec![number(v)], |list| list.iter().map(number).collect())
            })
            .collect()
    }
}

/// A uniform vector, the sample that it maps to, and the density there.
#[derive(Clone, Debug)]
pub struct PointEntry {
    /// The sampler.
    pub inputs: Inputs,
    /// The uniforms, exact.
    pub u: Vec<f64>,
    /// The sample, exact to double precision.
    pub x: Vec<f64>,
    /// The sample rounded to the precision of the entry.
    pub rounded: Vec<f64>,
    /// The density at the exact sample.
    pub pdf: f64,
    /// The closed form at the rounded sample.
    pub pdf_at_rounded: f64,
    /// The density at the point of the manifold next to the rounded sample, if there is one.
    pub pdf_at_projected: Option<f64>,
    /// Condition of the density; infinite where it has no meaning.
    pub condition_pdf: f64,
    /// Condition of the sample; infinite where it has no meaning.
    pub condition_sample: f64,
}

/// A point, and the density that it must have.
#[derive(Clone, Debug)]
pub struct Query {
    /// The sampler.
    pub inputs: Inputs,
    /// The coordinates; perhaps NaN, infinite, or off the manifold.
    pub x: Vec<f64>,
    /// The density.
    pub pdf: f64,
}

/// All of the file.
#[derive(Clone, Debug, Default)]
pub struct Reference {
    /// Samples in double precision.
    pub points: Vec<PointEntry>,
    /// The same with everything rounded to single precision, where that can hold it.
    pub points32: Vec<PointEntry>,
    /// Queries.
    pub queries: Vec<Query>,
}

impl Reference {
    /// Reads the file that lies beside this crate.
    ///
    /// # Panics
    /// If the file is damaged.
    pub fn load() -> Self {
        Self::parse(include_str!("../reference/catalogue-e.json"))
    }

    /// Reads the file of the samplers with branches, roots and several preimages; it holds double
    /// precision only.
    ///
    /// # Panics
    /// If the file is damaged.
    pub fn load_branched() -> Self {
        Self::parse(include_str!("../reference/catalogue-mh.json"))
    }

    fn parse(text: &str) -> Self {
        let entries: Vec<Value> = serde_json::from_str(text).expect("the file is JSON");
        let mut all = Reference::default();
        for entry in &entries {
            if entry["kind"] == "query" {
                let (inputs, x) = (inputs(entry, ""), hexadecimals(&entry["x_hex"]));
                all.queries.push(Query { inputs, x, pdf: decimal(&entry["pdf"]) });
            } else {
                all.points.push(point(entry, ""));
                if !entry["u32"].is_null() {
                    all.points32.push(point(entry, "32"));
                }
            }
        }
        all
    }
}

fn inputs(entry: &Value, suffix: &str) -> Inputs {
    Inputs {
        row: entry["row"].as_u64().expect("a row is a number"),
        name: entry["name"].as_str().expect("a name is a string").to_owned(),
        params: entry[format!("params{suffix}")].clone(),
    }
}

fn point(entry: &Value, suffix: &str) -> PointEntry {
    let field = |name: &str| &entry[format!("{name}{suffix}")];
    let projected = field("pdf_at_projected_x");
    PointEntry {
        inputs: inputs(entry, suffix),
        u: hexadecimals(field("u_hex")),
        x: list(field("x")).iter().map(decimal).collect(),
        rounded: hexadecimals(field("x_hex")),
        pdf: decimal(field("pdf")),
        pdf_at_rounded: decimal(field("pdf_at_rounded_x")),
        pdf_at_projected: (!projected.is_null()).then(|| decimal(projected)),
        condition_pdf: field("condition_pdf").as_f64().unwrap_or(f64::INFINITY),
        condition_sample: field("condition_sample").as_f64().unwrap_or(f64::INFINITY),
    }
}

fn list(value: &Value) -> &[Value] {
    value.as_array().map_or(&[], Vec::as_slice)
}

fn decimal(value: &Value) -> f64 {
    let text = value.as_str().unwrap_or_else(|| panic!("{value} is not a decimal string"));
    text.parse().unwrap_or_else(|_| panic!("{text} is not a number"))
}

fn hexadecimals(value: &Value) -> Vec<f64> {
    list(value).iter().map(|v| hexadecimal(v.as_str().unwrap_or("?"))).collect()
}

/// Reads a hexadecimal floating-point number as C99 prints it, such as `-0x1.8p-3`.
///
/// # Panics
/// If it is none.
pub fn hexadecimal(text: &str) -> f64 {
    let (sign, digits) = text.strip_prefix('-').map_or((1.0, text), |rest| (-1.0, rest));
    let Some((mantissa, exponent)) = digits.strip_prefix("0x").and_then(|d| d.split_once('p'))
    else {
        return text.parse().unwrap_or_else(|_| panic!("{text} is not a hexadecimal number"));
    };
    let (whole, fraction) = mantissa.split_once('.').unwrap_or((mantissa, ""));
    let bits = u64::from_str_radix(&format!("{whole}{fraction}"), 16).expect("hexadecimal digits");
    let exponent: i32 = exponent.parse().expect("a binary exponent");
    let mut scale = exponent - 4 * fraction.len() as i32;
    let mut value = bits as f64;
    // Two steps, because a power of two alone may leave the range that the number stays in.
    while scale < 0 {
        let step = scale.max(-1000);
        value *= 2.0_f64.powi(step);
        scale -= step;
    }
    sign * value * 2.0_f64.powi(scale)
}
