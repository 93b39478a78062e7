//! Derived items, interpreted in the compiler, against entries of the reference data.

use aether_engine::eval::evaluate;
use aether_engine::expr::Leaf;
use aether_engine::interpret::Item;
use aether_engine::parse::ParamKind;
use serde_json::Value;

/// How far a uniform is from 0 and 1 at least for an entry to be judged here: on borders the emitted code
/// weighs rounding errors, which needs the runtime (the crate `tests` judges those).
const BORDER: f64 = 1e-9;

/// Condition numbers above this say that rounding of the inputs decides: no form of the code is measured
/// there.
const WORST_CONDITION: f64 = 1e3;

/// The larger error of sample and density at an entry, as a multiple of 1e-12 times its condition number
/// (at least one). `None` where the runtime or rounding has to decide: on borders, where the rounded point
/// is off its manifold, where squares of parameters leave the range, and where both are ill-conditioned.
pub fn worst_error(item: &Item, entry: &Value) -> Option<f64> {
    let u = numbers(&entry["u_hex"], hexadecimal);
    if entry["kind"] == "query" || u.iter().any(|u| *u < BORDER || *u > 1.0 - BORDER) {
        return None;
    }
    let p = parameters(item, &entry["params"]);
    // Emitted code computes a root of squares again on another scale, where these leave the range.
    if p.iter().any(|p| *p != 0.0 && !(1e-150..1e150).contains(&p.abs())) {
        return None;
    }
    if between_pieces(item, &p, &u) {
        return None;
    }
    let x = numbers(&entry["x_hex"], hexadecimal);
    let found = item.pdf(&p, &x);
    if found == 0.0 {
        return None;
    }
    // Rounding takes a point off its manifold: the density may be that of the nearest point on it.
    let expected = ["pdf_at_rounded_x", "pdf_at_projected_x"];
    let expected = expected.iter().filter_map(|name| entry[*name].as_str().map(decimal));
    let density = expected.map(|e| distance(&[found], &[e])).fold(f64::INFINITY, f64::min);
    let made = item.forward(&p, &u).unwrap_or_default();
    let sample = distance(&made, &numbers(&entry["x"], decimal));
    let multiple = |error: f64, condition: &str| {
        let condition = entry[condition].as_f64().filter(|c| *c <= WORST_CONDITION)?;
        Some(error / (1e-12 * condition.max(1.0)))
    };
    let both = [multiple(density, "condition_pdf"), multiple(sample, "condition_sample")];
    both.into_iter().flatten().reduce(f64::max)
}

/// Whether uniforms lie where one way through the branches of the body ends.
fn between_pieces(item: &Item, p: &[f64], u: &[f64]) -> bool {
    let at = |leaf: Leaf| match leaf {
        Leaf::Param(i) => p[usize::from(i)],
        Leaf::Unknown(i) => u[usize::from(i)],
        _ => f64::NAN,
    };
    item.parsed.pieces.iter().any(|piece| {
        piece.tests.iter().any(|t| evaluate(&piece.graph, t.difference, &at).abs() < BORDER)
    })
}

/// |a - b| / |b|, Euclidean; infinite where a number is missing or none.
fn distance(a: &[f64], b: &[f64]) -> f64 {
    if a.len() != b.len() {
        return f64::INFINITY;
    }
    // Squares of the numbers may leave the range.
    let scale = b.iter().fold(f64::MIN_POSITIVE, |m, x| m.max(x.abs()));
    let norm = |v: &mut dyn Iterator<Item = f64>| v.map(|x| (x / scale) * (x / scale)).sum::<f64>();
    let gap = norm(&mut a.iter().zip(b).map(|(a, b)| a - b));
    let error = (gap / norm(&mut b.iter().copied())).sqrt();
    if gap == 0.0 {
        0.0
    } else if error.is_nan() {
        f64::INFINITY
    } else {
        error
    }
}

fn numbers(list: &Value, read: fn(&str) -> f64) -> Vec<f64> {
    let list = list.as_array().into_iter().flatten();
    list.map(|v| read(v.as_str().unwrap_or("nan"))).collect()
}

fn decimal(text: &str) -> f64 {
    text.parse().unwrap_or(f64::NAN)
}

/// The scalar parameters: by name, or by the names of the coordinates of a vector.
fn parameters(item: &Item, given: &Value) -> Vec<f64> {
    let mut list = Vec::new();
    for param in &item.parsed.signature.params {
        let name = param.name.to_string();
        let count = param.kind.numbers();
        let value = [name.clone(), name.to_uppercase()]
            .into_iter()
            .map(|n| &given[n])
            .find(|v| !v.is_null());
        match value {
            Some(Value::Array(v)) => {
                let v: Vec<f64> = v.iter().map(|v| v.as_f64().unwrap_or(f64::NAN)).collect();
                // A direction is made a unit vector, as it is when an item is made.
                let length = match param.kind {
                    ParamKind::Direction => v.iter().map(|c| c * c).sum::<f64>().sqrt(),
                    _ => 1.0,
                };
                list.extend(v.iter().map(|c| c / length));
            }
            Some(v) => list.push(v.as_f64().unwrap_or(f64::NAN)),
            None if count == 2 => list.extend(
                ["x", "y"].map(|c| given[format!("{name}{c}")].as_f64().unwrap_or(f64::NAN)),
            ),
            // A matrix is given by its columns a, b, c; what has another name is in order.
            None if count == 9 => {
                for c in ["a", "b", "c"] {
                    list.extend((0..3).map(|i| given[c][i].as_f64().unwrap_or(f64::NAN)));
                }
            }
            None => {
                // By name, because the order of a JSON object depends on how it was read.
                let entries = given.as_object().into_iter().flatten();
                let numbers = entries.filter_map(|(name, v)| Some((name, v.as_f64()?)));
                let first = numbers.min_by(|a, b| a.0.cmp(b.0));
                list.push(first.map_or(f64::NAN, |(_, number)| number));
            }
        }
    }
    list
}

/// A hexadecimal floating-point number as C99 prints it.
fn hexadecimal(text: &str) -> f64 {
    let (sign, digits) = text.strip_prefix('-').map_or((1.0, text), |rest| (-1.0, rest));
    let Some((mantissa, exponent)) = digits.strip_prefix("0x").and_then(|d| d.split_once('p'))
    else {
        return text.parse().unwrap_or(f64::NAN);
    };
    let (whole, fraction) = mantissa.split_once('.').unwrap_or((mantissa, ""));
    let bits = u64::from_str_radix(&format!("{whole}{fraction}"), 16).unwrap_or(0);
    let exponent: i32 = exponent.parse().unwrap_or(0) - 4 * fraction.len() as i32;
    let half = exponent / 2;
    sign * bits as f64 * 2f64.powi(half) * 2f64.powi(exponent - half)
}
