//! Rows as lines of a file: a long report that was interrupted goes on where it was.

use std::path::Path;

use serde_json::{Value, json};

use super::measure::Row;
use super::tally::Tally;

/// A row, and of how many random points it is, on one line.
pub fn line(row: &Row, points: u64) -> String {
    let tallies: Vec<Value> = row.tallies().into_iter().map(Tally::as_json).collect();
    let Row { false_zeros, nan, infinite, excused, unjudged, samples, .. } = row;
    let counts = [false_zeros, nan, infinite, excused, unjudged, samples];
    json!({
        "name": row.name, "precision": row.precision, "points": points, "tallies": tallies,
        "counts": counts, "dropped": row.dropped, "examples": row.examples,
    })
    .to_string()
        + "\n"
}

/// The rows of a file with so many random points in `f64` and in `f32`; none if there is no such file. A line that is
/// no row, as one that was cut short, is left out.
pub fn read(path: &Path, points: [u64; 2]) -> Vec<Row> {
    let text = std::fs::read_to_string(path).unwrap_or_default();
    text.lines().filter_map(|line| row(&serde_json::from_str(line).ok()?, points)).collect()
}

fn row(value: &Value, points: [u64; 2]) -> Option<Row> {
    let precision = ["f64", "f32"].into_iter().position(|p| value["precision"] == p)?;
    if value["points"].as_u64()? != points[precision] {
        return None;
    }
    let texts = |name: &str| -> Option<Vec<String>> {
        value[name].as_array()?.iter().map(|text| Some(text.as_str()?.to_owned())).collect()
    };
    let counts = value["counts"].as_array()?.iter().map(Value::as_u64);
    let counts: Vec<u64> = counts.collect::<Option<_>>()?;
    let [false_zeros, nan, infinite, excused, unjudged, samples] = counts[..] else { return None };
    let mut row = Row {
        name: value["name"].as_str()?.to_owned(),
        precision: ["f64", "f32"][precision],
        dropped: texts("dropped")?,
        examples: texts("examples")?,
        false_zeros,
        nan,
        infinite,
        excused,
        unjudged,
        samples,
        ..Row::default()
    };
    let stored = value["tallies"].as_array()?;
    let tallies = row.tallies_mut();
    if tallies.len() != stored.len() {
        return None;
    }
    for (tally, value) in tallies.into_iter().zip(stored) {
        *tally = Tally::from_json(value)?;
    }
    Some(row)
}
