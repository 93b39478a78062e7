//! How well what the compiler derives agrees with reference values, without building the samplers.
//!
//! `cargo run --release -p aether-engine --example agreement REFERENCE.json FILE.rs…`, where the
//! reference is one of `tests/reference/catalogue-*.json` and the files hold its samplers. Points on
//! borders are judged with a fixed tolerance here; the tests of the crate `tests` judge them as they
//! are.

use std::collections::BTreeMap;
use std::process::ExitCode;
use std::time::Instant;

use aether_engine::interpret::Item;
use aether_engine::parse::ParamKind;
use proc_macro2::TokenStream;
use quote::ToTokens;
use serde_json::Value;

fn main() -> ExitCode {
    let mut arguments = std::env::args().skip(1);
    let Some(reference) = arguments.next() else {
        eprintln!("give a file of reference values and the source files of its samplers");
        return ExitCode::FAILURE;
    };
    let Ok(text) = std::fs::read_to_string(&reference) else {
        eprintln!("{reference}: cannot be read");
        return ExitCode::FAILURE;
    };
    let entries: Vec<Value> = serde_json::from_str(&text).unwrap_or_default();
    let mut of: BTreeMap<&str, Vec<&Value>> = BTreeMap::new();
    for entry in &entries {
        of.entry(entry["name"].as_str().unwrap_or_default()).or_default().push(entry);
    }
    for file in arguments {
        let parsed = std::fs::read_to_string(&file).ok().and_then(|t| syn::parse_file(&t).ok());
        let Some(parsed) = parsed else {
            eprintln!("{file}: cannot be read as Rust");
            return ExitCode::FAILURE;
        };
        for item in parsed.items {
            if let syn::Item::Fn(f) = item {
                let name = f.sig.ident.to_string();
                judge(f, of.get(name.as_str()).map_or(&[], Vec::as_slice));
            }
        }
    }
    ExitCode::SUCCESS
}

fn judge(mut function: syn::ItemFn, entries: &[&Value]) {
    let Some(index) = function.attrs.iter().position(|a| a.path().is_ident("sampler")) else {
        return;
    };
    let name = function.sig.ident.to_string();
    let attribute = match function.attrs.remove(index).meta {
        syn::Meta::List(list) => list.tokens,
        _ => TokenStream::new(),
    };
    let started = Instant::now();
    let item = match Item::new(attribute, function.to_token_stream(), true) {
        Ok(item) => item,
        Err(why) => return println!("{name}: refused: {why}"),
    };
    let milliseconds = 1e3 * started.elapsed().as_secs_f64();
    let preimages: usize = item.derived.iter().map(|d| d.preimages.len()).sum();
    let mut worst = 0.0f64;
    let mut wrong = Vec::new();
    for entry in entries {
        let (error, text) = compare(&item, entry);
        worst = worst.max(error);
        if error > 1.0 || error.is_nan() {
            wrong.push(text);
        }
    }
    println!(
        "{name}: {} pieces, {preimages} preimages, {milliseconds:.0} ms, {} entries, {} wrong, worst {worst:.1e} of what is allowed",
        item.derived.len(),
        entries.len(),
        wrong.len(),
    );
    for text in wrong {
        println!("    {text}");
    }
}

/// The largest error at an entry as a multiple of what its condition allows, and what it was.
fn compare(item: &Item, entry: &Value) -> (f64, String) {
    let p = parameters(item, &entry["params"]);
    let exact = |v: &Value| v.as_str().map_or(f64::NAN, |s| s.parse().unwrap_or(f64::NAN));
    let hex = |v: &Value| -> Vec<f64> {
        v.as_array().map_or(vec![], |l| {
            l.iter().map(|h| hexadecimal(h.as_str().unwrap_or("nan"))).collect()
        })
    };
    let x = hex(&entry["x_hex"]);
    let query = entry["kind"] == "query";
    let right = exact(if query { &entry["pdf"] } else { &entry["pdf_at_rounded_x"] });
    let found = item.pdf(&p, &x);
    let condition = |name: &str| entry[name].as_f64().unwrap_or(1e3).clamp(1.0, 1e3);
    let off = if found == right || found.is_infinite() && right > 1e150 {
        0.0
    } else {
        (found - right).abs() / right.abs()
    };
    let mut worst = off / (1e-12 * condition("condition_pdf"));
    let mut text = format!("{p:?} x {x:?}: density {found:e}, is {right:e}");
    if !query {
        let u = hex(&entry["u_hex"]);
        text += &format!(", u {u:?} preimages {:?}", item.preimages(&p, &x));
        let exact: Vec<f64> =
            entry["x"].as_array().map_or(vec![], |l| l.iter().map(exact).collect());
        let made = item.forward(&p, &u).unwrap_or_default();
        let off = exact
            .iter()
            .zip(&made)
            .map(|(e, m)| if e == m { 0.0 } else { (e - m).abs() / e.abs() })
            .fold(0.0, f64::max);
        if off / (1e-12 * condition("condition_sample")) > 1.0 {
            text += &format!(", sample {made:?}, is {exact:?}");
        }
        worst = worst.max(off / (1e-12 * condition("condition_sample")));
    }
    (worst, text)
}

/// The scalar parameters: by name, or by the names of the coordinates of a vector.
fn parameters(item: &Item, given: &Value) -> Vec<f64> {
    let mut list = Vec::new();
    for param in &item.parsed.signature.params {
        let name = param.name.to_string();
        let count = match param.kind {
            ParamKind::Scalar => 1,
            ParamKind::Vec2 => 2,
            ParamKind::Vec3 | ParamKind::Direction => 3,
            ParamKind::Mat3 | ParamKind::Frame => 9,
            ParamKind::Identity => 0,
        };
        let value = [name.clone(), name.to_uppercase()]
            .into_iter()
            .map(|n| &given[n])
            .find(|v| !v.is_null());
        match value {
            Some(Value::Array(v)) => list.extend(v.iter().map(|v| v.as_f64().unwrap_or(f64::NAN))),
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
                let numbers = given.as_object().into_iter().flatten().map(|(_, v)| v);
                list.push(numbers.filter_map(Value::as_f64).next().unwrap_or(f64::NAN));
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
